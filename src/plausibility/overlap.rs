//! Whether configurations before a row and after it are of the same kind.
//!
//! Where they are not, time and place are confounded: what the model misses in one region looks like a step between two.

use super::evidence::Evidence;
use crate::math::extremes;

/// Configurations that are compared at most, evenly spread over the rows: each with each, and a share of 1000 is known to 2 %.
const MOST: usize = 2000;

/// Share of the configurations on the smaller side of a row whose nearest neighbour (by the ranges of the joints) is on the same side, from 0
/// to 1, less what an order at random gives, over what is left to 1: 0 of an order that has nothing to do with where the robot stood,
/// 1 of regions that do not touch. `readings` are those that are compared, by index.
pub(super) fn apart(evidence: &Evidence, readings: &[usize], is_after: impl Fn(usize) -> bool) -> f64 {
    let campaign = evidence.campaign;
    let mut all: Vec<(&[f64], bool)> =
        readings.iter().map(|&index| (campaign.configuration(index), is_after(index))).collect();
    all.dedup_by(|a, b| a.0 == b.0);
    let all: Vec<(&[f64], bool)> = all.iter().step_by(all.len().div_ceil(MOST).max(1)).copied().collect();
    let of = |side: bool| all.iter().filter(|(_, after)| *after == side).count();
    let side = of(true) < of(false);
    let small = of(side);
    if small == 0 || small == all.len() {
        return 0.0;
    }
    let count = all[0].0.len();
    let ranges: Vec<f64> = (0..count)
        .map(|joint| {
            let [low, high] = extremes(all.iter().map(|(own, _)| own[joint]));
            high - low
        })
        .collect();
    let squares = |a: &[f64], b: &[f64]| -> f64 {
        let joints = a.iter().zip(b).zip(&ranges).filter(|(_, range)| **range > 0.0);
        joints.map(|((a, b), range)| ((a - b) / range).powi(2)).sum()
    };
    let nearest_is_here = |own: &[f64]| {
        let others = all.iter().filter(|(other, _)| *other != own);
        let nearest = others.min_by(|(a, _), (b, _)| squares(own, a).total_cmp(&squares(own, b)));
        nearest.is_some_and(|(_, after)| *after == side)
    };
    let here = all.iter().filter(|(_, after)| *after == side).filter(|(own, _)| nearest_is_here(own)).count();
    let expected = (small - 1) as f64 / (all.len() - 1) as f64;
    ((here as f64 / small as f64 - expected) / (1.0 - expected)).max(0.0)
}
