//! How often the same cause wins when half of the configurations choose it and the other half judges.
//!
//! Source: Shah and Samworth, *Variable selection with error control: another look at stability selection*, J. R. Stat.
//! Soc. B 75, 2013 (complementary pairs).

use nalgebra::DMatrix;
use rand::seq::SliceRandom;

use super::held_out::{Additions, HeldOut};
use super::level::Stability;
use super::linear_problem::LinearProblem;
use super::settings::ClaimSettings;
use crate::simulation::generator;

/// Stability of the first of some candidates, with which the next `tied` ones are tied, from complementary halves of the
/// configurations.
pub fn stability(
    problem: &LinearProblem,
    additions: &Additions,
    candidates: &[usize],
    tied: usize,
    settings: &ClaimSettings,
) -> Stability {
    let hypotheses = &problem.hypotheses;
    let poses = problem.poses().len();
    // Of its family where it sits; or another that can do all that it does there, as curves of a joint can be the same everywhere.
    let is_within = |curve: &DMatrix<f64>, law: &DMatrix<f64>| {
        curve.tr_mul(law).norm_squared() >= settings.near_curve * law.ncols() as f64
    };
    let holds: Vec<bool> = (0..candidates.len())
        .map(|at| {
            let [law, curve] = [0, at].map(|at| &hypotheses[candidates[at]]);
            let is_there = curve.is_free() && !law.is_free() && curve.site.name == law.site.name;
            curve.holds(law) || is_there && is_within(&additions.candidates[at], &additions.candidates[0])
        })
        .collect();
    let (mut counts, mut draws) = ([0_usize; 5], 0);
    for pair in 0..settings.halves {
        let mut order: Vec<usize> = (0..poses).collect();
        order.shuffle(&mut generator(settings.seed.wrapping_mul(1_000_003).wrapping_add(pair as u64)));
        let mut half = vec![None; poses];
        order.iter().enumerate().for_each(|(k, &pose)| half[pose] = Some(usize::from(2 * k >= poses)));
        let losses = HeldOut::new(problem, &half).losses(additions);
        for side in 0..2 {
            let sum = |all: &[f64]| -> f64 {
                (0..poses).filter(|&pose| half[pose] == Some(side)).map(|pose| all[pose]).sum()
            };
            let before = sum(&losses.base);
            let left: Vec<f64> = losses.with.iter().map(|with| sum(with)).collect();
            let Some(best) = (0..candidates.len()).min_by(|&a, &b| left[a].total_cmp(&left[b])) else { continue };
            // A curve wins for the law that it holds.
            let is_near = before - left[0] >= settings.near_curve * (before - left[best]);
            let best = if holds[best] && is_near { 0 } else { best };
            let [one, other] = [0, best].map(|at| &hypotheses[candidates[at]]);
            let same_family = one.family() == other.family();
            let same_site = same_family && one.site.name == other.site.name;
            counts[0] += usize::from(same_family);
            counts[1] += usize::from(same_site);
            let same_law = same_site && one.is_same(other);
            counts[2] += usize::from(same_law);
            let is_at = |at: usize| {
                let own = &hypotheses[candidates[at]];
                own.family() == other.family() && own.site.name == other.site.name
            };
            counts[3] += usize::from((0..=tied).any(is_at));
            let is_law = |at: usize| hypotheses[candidates[at]].is_same(other);
            counts[4] += usize::from((0..=tied).any(is_law));
            draws += 1;
        }
    }
    // Laplace's rule of succession, which never says certain.
    let [family, site, law, group, group_law] = counts.map(|count| (count as f64 + 1.0) / (draws as f64 + 2.0));
    Stability { family, site, law, group, group_law }
}
