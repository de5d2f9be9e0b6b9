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
    /// Distance from the predicted position to the barycentre of the readings, AP.
    pub accuracy: f64,
    /// RP: mean distance from the barycentre, and three standard deviations of it.
    pub repeatability: f64,
    /// The same of orientations: angle of the mean rotation from the predicted one, and RP of the angles.
    pub orientation: Option<[f64; 2]>,
    /// vAP: greatest distance between barycentres of readings that joints reached from different sides; none where they came
    /// from one, or nobody knows.
    pub variation: Option<f64>,
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
    let position = |own: &[f64]| Vector3::new(own[0], own[1], own[2]);
    let turned: Vec<Vector3<f64>> =
        group.iter().filter_map(|(_, own)| Some(Vector3::from_column_slice(own.get(3..6)?))).collect();
    let positions: Vec<Vector3<f64>> = group.iter().map(|(_, own)| position(own)).collect();
    let [accuracy, repeatability] = spread(&positions);
    // Barycentres by the sides from which the joints came.
    let side = |index: usize| -> Option<Vec<i8>> {
        let sides: Vec<Option<f64>> =
            campaign.conditions.approach.iter().map(|all| all.as_ref().map(|all| all[index])).collect();
        sides.iter().any(Option::is_some).then(|| sides.iter().map(|side| side.unwrap_or(0.0) as i8).collect())
    };
    let mut from: Vec<(Vec<i8>, Vector3<f64>, f64)> = Vec::new();
    for ((index, _), at) in group.iter().zip(&positions) {
        let Some(side) = side(*index) else { continue };
        match from.iter_mut().find(|(known, _, _)| *known == side) {
            Some((_, sum, count)) => (*sum, *count) = (*sum + at, *count + 1.0),
            None => from.push((side, *at, 1.0)),
        }
    }
    let centres: Vec<Vector3<f64>> = from.into_iter().map(|(_, sum, count)| sum / count).collect();
    let apart = centres.iter().enumerate().flat_map(|(k, a)| centres[k + 1..].iter().map(move |b| (a - b).norm()));
    Repeated {
        first: group[0].0,
        count: group.len(),
        accuracy,
        repeatability,
        orientation: (turned.len() == group.len()).then(|| spread(&turned)),
        variation: apart.max_by(f64::total_cmp),
    }
}

/// Distance of the barycentre from the origin, and mean plus three standard deviations of the distances from it.
fn spread(all: &[Vector3<f64>]) -> [f64; 2] {
    let n = all.len() as f64;
    let centre = all.iter().sum::<Vector3<f64>>() / n;
    let distances: Vec<f64> = all.iter().map(|at| (at - centre).norm()).collect();
    let mean = distances.iter().sum::<f64>() / n;
    let variance = distances.iter().map(|l| (l - mean).powi(2)).sum::<f64>() / (n - 1.0);
    [centre.norm(), mean + 3.0 * variance.sqrt()]
}
