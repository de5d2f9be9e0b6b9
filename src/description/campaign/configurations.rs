//! Which readings were taken at one configuration, and which are copies: readings that may share an error, or all of it.

use std::collections::{HashMap, HashSet};

use indexmap::IndexMap;

use super::{Campaign, Reading};
use crate::math::extremes;
use crate::observation::MOST_ROWS;

/// Rows from which on two readings that agree to the last digit are one: instruments of coarse resolution often repeat one
/// number, hardly ever three.
const TELLING_ROWS: usize = 3;

/// Variables of one neighbourhood differ by no more, rad or m: encoders of robots repeat to a hundredth of a degree at worst. A judgement.
const NEAR: f64 = 2e-4;

/// What must agree for readings of one configuration to be repeats.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Point {
    kind: &'static str,
    marker: Option<usize>,
    target: Option<usize>,
    wrench: [u64; 6],
    payload: Option<[u64; 5]>,
}

/// Bits that are equal for equal numbers.
fn bits(value: f64) -> u64 {
    (value + 0.0).to_bits()
}

/// What a reading measures at its configuration, and under which load.
pub fn point_of(reading: &Reading) -> Point {
    let payload = reading.payload.map(|payload| {
        let [x, y, z] = [payload.com.x, payload.com.y, payload.com.z].map(bits);
        [bits(payload.mass), x, y, z, payload.frame as u64]
    });
    let wrench = reading.wrench.map(bits);
    Point { kind: reading.observes.name(), marker: reading.marker, target: reading.target, wrench, payload }
}

impl Campaign {
    /// Of each pose, the first one of the same session that has the same variables (of its first reading): itself where no
    /// other has them. Rows without a name of a pose, and poses named anew at every visit, are distinguished by nothing else.
    pub fn configurations(&self) -> Vec<usize> {
        let mut known: HashMap<(usize, Vec<u64>), usize> = HashMap::new();
        self.first_poses(|index| {
            let reading = &self.readings[index];
            let variables = self.configuration(index).iter().map(|value| bits(*value)).collect();
            *known.entry((reading.session.session, variables)).or_insert(reading.pose)
        })
    }

    /// The same of poses whose variables are within 2e-4 (rad, m) of those of the first one, as they are where joints are recorded anew at every
    /// visit: what a model misses, or a drive leaves, is the same at all of them.
    pub fn neighbourhoods(&self) -> Vec<usize> {
        let widest = self.widest_variable();
        let cell = |q: &[f64]| widest.and_then(|k| q.get(k)).map_or(0, |value| (value / NEAR).floor() as i64);
        let mut known: HashMap<(usize, i64), Vec<usize>> = HashMap::new();
        self.first_poses(|index| {
            let (session, q) = (self.readings[index].session.session, self.configuration(index));
            let is_near = |other: &&usize| {
                self.configuration(**other).iter().zip(q).all(|(a, b)| a == b || (a - b).abs() <= NEAR)
            };
            let at = cell(q);
            let near = [at - 1, at, at + 1].into_iter().filter_map(|cell| known.get(&(session, cell))).flatten();
            let first = near.filter(is_near).min().copied();
            if first.is_none() {
                known.entry((session, at)).or_default().push(index);
            }
            self.readings[first.unwrap_or(index)].pose
        })
    }

    /// Of each pose, what its first reading, by index, gives: the first pose like it; itself without readings.
    fn first_poses(&self, mut first_like: impl FnMut(usize) -> usize) -> Vec<usize> {
        let mut first: Vec<usize> = (0..self.poses.len()).collect();
        let mut seen = vec![false; self.poses.len()];
        for (index, reading) in self.readings.iter().enumerate() {
            if !std::mem::replace(&mut seen[reading.pose], true) {
                first[reading.pose] = first_like(index);
            }
        }
        first
    }

    /// The variable whose values differ most; `None` without readings or variables.
    fn widest_variable(&self) -> Option<usize> {
        let spread = |k: usize| {
            let values = (0..self.readings.len()).filter_map(|index| self.configuration(index).get(k).copied());
            let [low, high] = extremes(values);
            high - low
        };
        (0..self.variables).map(|k| (k, spread(k))).max_by(|a, b| a.1.total_cmp(&b.1)).map(|(k, _)| k)
    }

    /// Readings that are held out at configurations that are fitted as well, by marks of which readings are held out: what they leave
    /// is no error of unseen configurations.
    pub fn held_out_and_fitted(&self, is_held_out: impl Fn(usize) -> Option<bool>) -> Vec<usize> {
        let first = self.configurations();
        let at = |index: usize| first.get(self.readings[index].pose).copied();
        let (fitted, held): (Vec<usize>, Vec<usize>) = (0..self.readings.len())
            .filter(|&index| is_held_out(index).is_some())
            .partition(|&index| is_held_out(index) == Some(false));
        let fitted: HashSet<Option<usize>> = fitted.into_iter().map(at).collect();
        held.into_iter().filter(|&index| fitted.contains(&at(index))).collect()
    }

    /// Of each reading, the earlier one of which it is an exact copy: same configuration, station, point, load and values. Readings
    /// of fewer than three numbers repeat by chance, and count as copies only where at least half of all do.
    pub fn copies(&self) -> Vec<Option<usize>> {
        let configurations = self.configurations();
        let mut first: IndexMap<(usize, usize, Point, [u64; MOST_ROWS]), usize> =
            IndexMap::with_capacity(self.readings.len());
        let of_reading = |(index, reading): (usize, &Reading)| {
            let station = reading.session.station;
            let key = (configurations[reading.pose], station, point_of(reading), reading.measured.map(bits));
            let original = *first.entry(key).or_insert(index);
            (original != index).then_some(original)
        };
        let mut copies: Vec<Option<usize>> = self.readings.iter().enumerate().map(of_reading).collect();
        if 2 * copies.iter().flatten().count() < copies.len() {
            for (copy, reading) in copies.iter_mut().zip(&self.readings) {
                copy.take_if(|_| reading.observes.rows() < TELLING_ROWS);
            }
        }
        copies
    }
}
