//! Accuracy and repeatability of poses that were measured several times (ISO 9283:1998, sec. 7.2).

use indexmap::IndexMap;
use nalgebra::Vector3;

use crate::description::campaign::{Campaign, Reading};

/// A point that was measured several times. Lengths in m, angles in rad.
#[derive(Debug, Clone, PartialEq)]
pub struct Repeated {
    /// Index of its first reading.
    pub first: usize,
    /// Number of readings.
    pub count: usize,
    /// AP and RP of positions: distance from the predicted one to the barycentre of the readings; mean distance from the barycentre,
    /// and three standard deviations of it.
    pub position: [f64; 2],
    /// The same of orientations: angle of the mean rotation from the predicted one, and RP of the angles.
    pub orientation: Option<[f64; 2]>,
    /// The same by the sides from which joints came, where they came from several and are known: of the readings of each side.
    pub directions: Vec<Direction>,
    /// vAP: greatest distance between barycentres of readings that joints reached from different sides; none where they came
    /// from one, or that is not known.
    pub variation: Option<f64>,
}

impl Repeated {
    /// AP and RP as the standard means them, of readings that were approached from one side: the greatest over the sides, where two
    /// readings or more came from each; else of all readings.
    pub fn unidirectional(&self) -> Figures {
        let all = Figures { position: self.position, orientation: self.orientation };
        if self.directions.is_empty() || self.directions.iter().any(|direction| direction.count < 2) {
            return all;
        }
        let greatest = |a: [f64; 2], b: [f64; 2]| [a[0].max(b[0]), a[1].max(b[1])];
        let own = self.directions.iter().map(|direction| direction.figures);
        own.reduce(|a, b| Figures {
            position: greatest(a.position, b.position),
            orientation: a.orientation.zip(b.orientation).map(|(a, b)| greatest(a, b)),
        })
        .unwrap_or(all)
    }
}

/// Accuracy and repeatability (AP, RP) of positions, m, and of orientations, rad.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Figures {
    pub position: [f64; 2],
    pub orientation: Option<[f64; 2]>,
}

/// Readings of a point that was approached from one side.
#[derive(Debug, Clone, PartialEq)]
pub struct Direction {
    /// Sign of the last motion of each variable; 0 where it is not known.
    pub sides: Vec<i8>,
    pub count: usize,
    pub figures: Figures,
}

/// Configurations count as one where joints (rad, m) and loads do not differ by more: they are as commanded, not as read.
const SAME: f64 = 1e-9;

/// Points with at least two readings of a position, in the order of the files, from residuals (measured less predicted) as
/// [`crate::prediction::Linearised::residual`].
pub fn repeated(campaign: &Campaign, residual: &[f64]) -> Vec<Repeated> {
    let mut groups: IndexMap<Vec<i64>, Vec<(usize, &[f64])>> = IndexMap::new();
    for (index, (reading, own)) in campaign.by_reading(residual, 1).enumerate() {
        if reading.observes.length_rows() == 3 {
            groups.entry(key(campaign, reading, index)).or_default().push((index, own));
        }
    }
    groups.values().filter(|group| group.len() > 1).map(|group| figures(campaign, group)).collect()
}

/// What readings of the same point in the same configuration under the same load have in common.
fn key(campaign: &Campaign, reading: &Reading, index: usize) -> Vec<i64> {
    let number = |value: Option<usize>| value.map_or(-1, |value| value as i64);
    let names = [number(reading.marker), number(Some(reading.session.session)), number(Some(reading.session.station))];
    let load = reading.payload.map_or(0.0, |payload| payload.mass);
    let sizes = campaign.configuration(index).iter().chain(&reading.wrench).chain([&load]);
    names.into_iter().chain(sizes.map(|size| (size / SAME).round() as i64)).collect()
}

fn figures(campaign: &Campaign, group: &[(usize, &[f64])]) -> Repeated {
    let of = |group: &[(usize, &[f64])]| {
        let positions: Vec<_> = group.iter().map(|(_, own)| Vector3::from_column_slice(&own[..3])).collect();
        let turned: Vec<_> =
            group.iter().filter_map(|(_, own)| Some(Vector3::from_column_slice(own.get(3..6)?))).collect();
        let orientation = (turned.len() == group.len()).then(|| spread(&turned));
        (Figures { position: spread(&positions), orientation }, centre(&positions))
    };
    let side = |index: usize| -> Option<Vec<i8>> {
        let sides: Vec<Option<f64>> =
            campaign.conditions.approach.iter().map(|all| all.as_ref().map(|all| all[index])).collect();
        sides.iter().any(Option::is_some).then(|| sides.iter().map(|side| side.unwrap_or(0.0) as i8).collect())
    };
    let mut from: IndexMap<Vec<i8>, Vec<(usize, &[f64])>> = IndexMap::new();
    for &(index, own) in group {
        if let Some(side) = side(index) {
            from.entry(side).or_default().push((index, own));
        }
    }
    let (directions, centres): (Vec<Direction>, Vec<Vector3<f64>>) = from
        .into_iter()
        .map(|(sides, own)| {
            let (figures, centre) = of(&own);
            (Direction { sides, count: own.len(), figures }, centre)
        })
        .unzip();
    let apart = centres.iter().enumerate().flat_map(|(k, a)| centres[k + 1..].iter().map(move |b| (a - b).norm()));
    let (Figures { position, orientation }, _) = of(group);
    Repeated {
        first: group[0].0,
        count: group.len(),
        position,
        orientation,
        variation: apart.max_by(f64::total_cmp),
        directions: if directions.len() > 1 { directions } else { Vec::new() },
    }
}

fn centre(all: &[Vector3<f64>]) -> Vector3<f64> {
    all.iter().sum::<Vector3<f64>>() / all.len() as f64
}

/// Distance of the barycentre from the origin, and mean plus three standard deviations of the distances from it.
fn spread(all: &[Vector3<f64>]) -> [f64; 2] {
    let (n, centre) = (all.len() as f64, centre(all));
    let distances: Vec<f64> = all.iter().map(|at| (at - centre).norm()).collect();
    let mean = distances.iter().sum::<f64>() / n;
    let variance = distances.iter().map(|l| (l - mean).powi(2)).sum::<f64>() / (n - 1.0).max(1.0);
    [centre.norm(), mean + 3.0 * variance.sqrt()]
}
