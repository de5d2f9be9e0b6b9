//! Figures on readings that the fit did not see.

use nalgebra::{DMatrix, DVector, Vector3};
use rand::RngExt;
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use super::algebra::solve;
use super::evidence::Evidence;

/// Parts into which configurations are divided where the campaign sets none aside.
const FOLDS: usize = 10;

/// Rows that are held out together.
pub fn folds(evidence: &Evidence, aside: &[bool], seed: u64) -> Vec<Vec<bool>> {
    if aside.iter().any(|a| *a) && aside.iter().any(|a| !*a) {
        return vec![evidence.reading.iter().map(|&reading| aside[reading]).collect()];
    }
    let mut poses: Vec<usize> = evidence.pose.clone();
    poses.sort_unstable();
    poses.dedup();
    poses.shuffle(&mut ChaCha8Rng::seed_from_u64(seed));
    let count = FOLDS.min(poses.len());
    (0..count)
        .map(|fold| {
            let held: Vec<usize> = poses.iter().skip(fold).step_by(count.max(1)).copied().collect();
            evidence.pose.iter().map(|pose| held.contains(pose)).collect()
        })
        .collect()
}

/// Weighted residuals of held-out rows after the nuisance and the members' columns were fitted to the others; rows that
/// are never held out are NaN.
pub fn held_out(evidence: &Evidence, members: &[usize], folds: &[Vec<bool>]) -> DVector<f64> {
    let design = design(evidence, members);
    let parts: Vec<Vec<(usize, f64)>> = folds
        .par_iter()
        .map(|held| {
            let train: Vec<usize> = (0..held.len()).filter(|&row| !held[row]).collect();
            let test: Vec<usize> = (0..held.len()).filter(|&row| held[row]).collect();
            let x = solve(&design.select_rows(&train), &evidence.residual.select_rows(&train));
            test.into_iter().map(|row| (row, evidence.residual[row] - design.row(row).transpose().dot(&x))).collect()
        })
        .collect();
    let mut out = DVector::from_element(evidence.rows(), f64::NAN);
    for (row, value) in parts.into_iter().flatten() {
        out[row] = value;
    }
    out
}

/// Nuisance and members side by side.
pub fn design(evidence: &Evidence, members: &[usize]) -> DMatrix<f64> {
    let mut columns: Vec<DVector<f64>> = evidence.nuisance.column_iter().map(|c| c.into_owned()).collect();
    for &member in members {
        columns.extend(evidence.hypotheses[member].columns.column_iter().map(|c| c.into_owned()));
    }
    if columns.is_empty() { DMatrix::zeros(evidence.rows(), 0) } else { DMatrix::from_columns(&columns) }
}

/// Error of each reading (m), from weighted residuals: the position error, or that of a distance. NaN where not held out.
pub fn reading_errors(evidence: &Evidence, residual: &DVector<f64>) -> Vec<(usize, Vector3<f64>)> {
    let mut out: Vec<(usize, Vector3<f64>)> = Vec::new();
    let mut component = 0;
    for row in 0..evidence.rows() {
        if row == 0 || evidence.reading[row] != evidence.reading[row - 1] {
            out.push((evidence.pose[row], Vector3::zeros()));
            component = 0;
        }
        if component < 3
            && let Some((_, error)) = out.last_mut()
        {
            error[component] = residual[row] * evidence.sigmas[row];
        }
        component += 1;
    }
    out
}

/// Root mean square and greatest of errors; those that are NaN left out.
pub fn rms_max(errors: &[(usize, Vector3<f64>)]) -> [f64; 2] {
    let norms: Vec<f64> = errors.iter().map(|(_, e)| e.norm()).filter(|n| n.is_finite()).collect();
    let [_, rms, max] = crate::math::mean_rms_max(norms.into_iter());
    [rms, max]
}

/// Shrinkage 1 - after/before of the root mean square over drawn configurations: 95 % interval for a fresh campaign of
/// this size; and 2.5 % and 97.5 % points of the root mean square after.
pub fn bootstrap(
    before: &[(usize, Vector3<f64>)],
    after: &[(usize, Vector3<f64>)],
    draws: usize,
    seed: u64,
) -> ([f64; 2], [f64; 2]) {
    let mut sums: Vec<(usize, f64, f64, f64)> = Vec::new();
    for ((pose, b), (_, a)) in before.iter().zip(after) {
        if !b.norm().is_finite() || !a.norm().is_finite() {
            continue;
        }
        match sums.iter_mut().find(|s| s.0 == *pose) {
            Some(sum) => {
                sum.1 += b.norm_squared();
                sum.2 += a.norm_squared();
                sum.3 += 1.0;
            }
            None => sums.push((*pose, b.norm_squared(), a.norm_squared(), 1.0)),
        }
    }
    if sums.is_empty() {
        return ([f64::NAN; 2], [f64::NAN; 2]);
    }
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut shrinkage = Vec::with_capacity(draws);
    let mut rms = Vec::with_capacity(draws);
    for _ in 0..draws {
        let (mut b, mut a, mut n) = (0.0, 0.0, 0.0);
        for _ in 0..sums.len() {
            let sum = &sums[random.random_range(0..sums.len())];
            b += sum.1;
            a += sum.2;
            n += sum.3;
        }
        shrinkage.push(1.0 - (a / b.max(f64::MIN_POSITIVE)).sqrt());
        rms.push((a / n).sqrt());
    }
    let (before, after): (f64, f64) = sums.iter().fold((0.0, 0.0), |s, own| (s.0 + own.1, s.1 + own.2));
    let value = 1.0 - (after / before.max(f64::MIN_POSITIVE)).sqrt();
    // A fresh campaign, of which the interval speaks, scatters as much as this one.
    let wider = |[low, high]: [f64; 2]| {
        let widen = std::f64::consts::SQRT_2;
        [value - widen * (value - low), value + widen * (high - value)]
    };
    (wider(ends(&mut shrinkage)), ends(&mut rms))
}

/// 2.5 % and 97.5 % points.
pub fn ends(values: &mut [f64]) -> [f64; 2] {
    values.sort_by(f64::total_cmp);
    let at = |share: f64| values[((values.len() - 1) as f64 * share).round() as usize];
    if values.is_empty() { [f64::NAN; 2] } else { [at(0.025), at(0.975)] }
}
