//! Errors of readings that were not fitted: held out by the campaign, or in turn.

use std::collections::BTreeMap;

use nalgebra::DVector;
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use super::linear_problem::LinearProblem;
use crate::math::{least_squares, mean_rms_max};

/// Rows that are held out together: those of the readings `held_out`, else `count` parts of the configurations.
pub fn folds(problem: &LinearProblem, held_out: &[bool], count: usize, seed: u64) -> Vec<Vec<bool>> {
    if held_out.contains(&true) && held_out.contains(&false) {
        return vec![problem.reading.iter().map(|&reading| held_out.get(reading) == Some(&true)).collect()];
    }
    let mut poses = problem.poses();
    poses.shuffle(&mut ChaCha8Rng::seed_from_u64(seed));
    let count = count.min(poses.len());
    (0..count)
        .map(|fold| {
            let held: Vec<usize> = poses.iter().skip(fold).step_by(count).copied().collect();
            problem.pose.iter().map(|pose| held.contains(pose)).collect()
        })
        .collect()
}

/// What is left of readings that were not fitted.
pub struct Validated {
    /// Root mean square error, m.
    pub rms: f64,
    /// Greatest error, m.
    pub max: f64,
    /// Sum of squared weighted residuals of each configuration that was held out, in the order of their numbers.
    pub losses: Vec<f64>,
}

/// Errors of the readings held out, nuisance and members fitted to the others.
pub fn validated(problem: &LinearProblem, members: &[usize], folds: &[Vec<bool>]) -> Validated {
    let design = problem.design(members);
    let parts: Vec<Vec<(usize, f64)>> = folds
        .par_iter()
        .map(|held| {
            let train: Vec<usize> = (0..held.len()).filter(|&row| !held[row]).collect();
            let x = least_squares(&design.select_rows(&train), &problem.residual.select_rows(&train));
            let test = (0..held.len()).filter(|&row| held[row]);
            test.map(|row| (row, problem.residual[row] - design.row(row).transpose().dot(&x))).collect()
        })
        .collect();
    let mut residual = DVector::zeros(problem.rows());
    let mut held: Vec<usize> = Vec::new();
    let mut losses: BTreeMap<usize, f64> = BTreeMap::new();
    for (row, value) in parts.into_iter().flatten() {
        residual[row] = value;
        held.push(problem.reading[row]);
        *losses.entry(problem.pose[row]).or_default() += value * value;
    }
    let [_, rms, max] = errors_of(problem, &residual, held);
    Validated { rms, max, losses: losses.into_values().collect() }
}

/// Mean, root mean square and greatest error (m) of some readings.
pub fn errors_of(problem: &LinearProblem, residual: &DVector<f64>, mut readings: Vec<usize>) -> [f64; 3] {
    let errors = problem.errors(residual);
    readings.sort_unstable();
    readings.dedup();
    readings.retain(|&reading| reading < errors.len());
    mean_rms_max(readings.into_iter().map(|reading| errors[reading].norm()))
}
