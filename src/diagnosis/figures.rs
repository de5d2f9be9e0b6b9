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

/// Root mean square errors (m) of configurations that a draw left out, after the nuisance and the first members were
/// fitted to those that it drew: for every draw, with no member, with one, and so on.
pub struct Drawn(Vec<Vec<f64>>);

impl Drawn {
    /// Draws configurations with replacement.
    pub fn new(evidence: &Evidence, members: &[usize], draws: usize, seed: u64) -> Self {
        let mut design = design(evidence, members);
        let mut widths = vec![evidence.nuisance.ncols()];
        for &member in members {
            widths.push(widths[widths.len() - 1] + evidence.hypotheses[member].columns.ncols());
        }
        for mut column in design.column_iter_mut() {
            let norm = column.norm();
            column /= norm.max(f64::MIN_POSITIVE);
        }
        let mut poses = evidence.pose.clone();
        poses.sort_unstable();
        poses.dedup();
        let rows_of =
            |pose: &usize| -> Vec<usize> { (0..evidence.rows()).filter(|&row| evidence.pose[row] == *pose).collect() };
        let rows: Vec<Vec<usize>> = poses.iter().map(rows_of).collect();
        let parts: Vec<(DMatrix<f64>, DVector<f64>)> = rows
            .iter()
            .map(|rows| {
                let own = design.select_rows(rows);
                (own.tr_mul(&own), own.tr_mul(&evidence.residual.select_rows(rows)))
            })
            .collect();
        let n = design.ncols();
        let draw = |index: usize| -> Option<Vec<f64>> {
            let mut random = ChaCha8Rng::seed_from_u64(seed.wrapping_mul(1_000_003).wrapping_add(index as u64));
            let mut times = vec![0_usize; poses.len()];
            (0..poses.len()).for_each(|_| times[random.random_range(0..poses.len())] += 1);
            let (mut normal, mut right) = (DMatrix::identity(n, n) * 1e-10, DVector::zeros(n));
            for (times, (own, other)) in times.iter().zip(&parts).filter(|(times, _)| **times > 0) {
                let weight = *times as f64;
                normal.zip_apply(own, |sum, own| *sum += weight * own);
                right.axpy(weight, other, 1.0);
            }
            let unseen: Vec<usize> =
                times.iter().zip(&rows).filter(|(times, _)| **times == 0).flat_map(|(_, rows)| rows.clone()).collect();
            let of = |width: &usize| -> Option<f64> {
                let factor = normal.view((0, 0), (*width, *width)).into_owned().cholesky()?;
                let x = factor.solve(&right.rows(0, *width).into_owned());
                let mut left = DVector::from_element(evidence.rows(), f64::NAN);
                for &row in &unseen {
                    left[row] = evidence.residual[row] - (0..*width).map(|k| design[(row, k)] * x[k]).sum::<f64>();
                }
                Some(rms_max(&reading_errors(evidence, &left))[0])
            };
            if unseen.is_empty() { None } else { widths.iter().map(of).collect() }
        };
        Self((0..draws).into_par_iter().filter_map(draw).collect())
    }

    /// 95 % interval of the shrinkage from one step to a later one about its `value`.
    pub fn shrinkage(&self, from: usize, to: usize, value: f64) -> [f64; 2] {
        let ratios = self.0.iter().map(|rms| (rms[to] / rms[from].max(f64::MIN_POSITIVE)).max(1e-9).ln());
        let [low, middle, high] = points(&mut ratios.collect::<Vec<_>>());
        // The campaign at hand and a fresh one both scatter.
        let [low, high] = [low, high].map(|end| middle + std::f64::consts::SQRT_2 * (end - middle));
        let about = (1.0 - value).max(1e-9);
        [1.0 - about * (high - middle).exp(), 1.0 - about * (low - middle).exp()]
    }

    /// 95 % interval of the root mean square at a step about its `value`, m.
    pub fn rms(&self, step: usize, value: f64) -> [f64; 2] {
        let sizes = self.0.iter().map(|rms| rms[step].max(f64::MIN_POSITIVE).ln());
        let [low, middle, high] = points(&mut sizes.collect::<Vec<_>>());
        [value * (low - middle).exp(), value * (high - middle).exp()]
    }
}

/// 2.5 %, 50 % and 97.5 % points.
fn points(values: &mut [f64]) -> [f64; 3] {
    let [low, high] = ends(values);
    [low, crate::math::median(values), high]
}

/// 2.5 % and 97.5 % points.
pub fn ends(values: &mut [f64]) -> [f64; 2] {
    values.sort_by(f64::total_cmp);
    let at = |share: f64| values[((values.len() - 1) as f64 * share).round() as usize];
    if values.is_empty() { [f64::NAN; 2] } else { [at(0.025), at(0.975)] }
}
