//! Intervals of cross-validated errors, by bootstrap over configurations: fitted to those drawn, judged on those left out.
//!
//! Source: Efron and Tibshirani, *An Introduction to the Bootstrap*, sec. 17.6 and 13.3.

use nalgebra::{DMatrix, DVector};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use super::cross_validation::errors_of;
use super::linear_problem::LinearProblem;
use crate::math::{joined, least_squares, median, orthonormal};

/// The Gram matrix of a draw is regular if its Cholesky factor has no diagonal below this: the columns are orthonormal
/// over all configurations.
const REGULAR: f64 = 1e-5;

/// Root mean square errors (m) of the configurations that a draw left out, for every draw: with no member, with one, and
/// so on.
pub struct Bootstrap(Vec<Vec<f64>>);

impl Bootstrap {
    /// Draws configurations with replacement and fits the nuisance and the first members to them.
    pub fn new(problem: &LinearProblem, members: &[usize], draws: usize, seed: u64) -> Self {
        // The fit is that of any columns with the same span.
        let mut basis = orthonormal(&problem.nuisance, None);
        let mut widths = vec![basis.ncols()];
        for &member in members {
            basis = joined(&basis, &orthonormal(&problem.hypotheses[member].columns, Some(&basis)));
            widths.push(basis.ncols());
        }
        // Rows together: those that a draw leaves out are read one by one.
        let by_row = basis.transpose();
        let poses = problem.poses();
        let rows_of =
            |pose: &usize| -> Vec<usize> { (0..problem.rows()).filter(|&row| problem.pose[row] == *pose).collect() };
        let rows: Vec<Vec<usize>> = poses.iter().map(rows_of).collect();
        let normal_equations = |rows: &Vec<usize>| {
            let own = basis.select_rows(rows);
            (own.tr_mul(&own), own.tr_mul(&problem.residual.select_rows(rows)))
        };
        let parts: Vec<(DMatrix<f64>, DVector<f64>)> = rows.iter().map(normal_equations).collect();
        let draw = |index: usize| -> Option<Vec<f64>> {
            let mut random = ChaCha8Rng::seed_from_u64(seed.wrapping_mul(1_000_003).wrapping_add(index as u64));
            let mut times = vec![0_usize; poses.len()];
            (0..poses.len()).for_each(|_| times[random.random_range(0..poses.len())] += 1);
            let (mut gram, mut right) = (DMatrix::zeros(basis.ncols(), basis.ncols()), DVector::zeros(basis.ncols()));
            for (times, (own, other)) in times.iter().zip(&parts).filter(|(times, _)| **times > 0) {
                let weight = *times as f64;
                gram.zip_apply(own, |sum, own| *sum += weight * own);
                right.axpy(weight, other, 1.0);
            }
            let left_out: Vec<usize> =
                times.iter().zip(&rows).filter(|(times, _)| **times == 0).flat_map(|(_, rows)| rows.clone()).collect();
            let error = |&width: &usize| {
                let x = solved(gram.view((0, 0), (width, width)).into_owned(), right.rows(0, width).into_owned());
                let mut residual = DVector::zeros(problem.rows());
                for &row in &left_out {
                    residual[row] = problem.residual[row] - by_row.view((0, row), (width, 1)).dot(&x);
                }
                errors_of(problem, &residual, left_out.iter().map(|&row| problem.reading[row]).collect())[1]
            };
            (!left_out.is_empty()).then(|| widths.iter().map(error).collect())
        };
        Self((0..draws).into_par_iter().filter_map(draw).collect())
    }

    /// 95 % interval of the shrinkage from one step to a later one about its `value`, on a fresh campaign: `wider` is
    /// [`super::settings::VerdictSettings::promise`].
    pub fn shrinkage(&self, from: usize, to: usize, value: f64, wider: f64) -> Option<[f64; 2]> {
        let ratios = self.0.iter().map(|rms| (rms[to] / rms[from].max(f64::MIN_POSITIVE)).max(1e-9).ln());
        let [low, high] = about_median(ratios.collect())?.map(|end| wider * end);
        let about = (1.0 - value).max(1e-9);
        Some([1.0 - about * high.exp(), 1.0 - about * low.exp()])
    }

    /// Whether the 95 % interval of the shrinkage from the first step to a later one, the scatter of this campaign and of a fresh one alone in it,
    /// excludes nothing; so where none is drawn.
    pub fn excludes_nothing(&self, to: usize, value: f64) -> bool {
        self.shrinkage(0, to, value, std::f64::consts::SQRT_2).is_none_or(|[low, _]| low > 0.0)
    }

    /// 95 % interval of the root mean square error at a step about its `value`, m.
    pub fn rms(&self, step: usize, value: f64) -> Option<[f64; 2]> {
        let sizes = self.0.iter().map(|rms| rms[step].max(f64::MIN_POSITIVE).ln());
        Some(about_median(sizes.collect())?.map(|end| value * end.exp()))
    }
}

/// Solution of the normal equations of one draw.
fn solved(gram: DMatrix<f64>, right: DVector<f64>) -> DVector<f64> {
    match gram.clone().cholesky() {
        Some(factor) if factor.l_dirty().diagonal().min() > REGULAR => factor.solve(&right),
        _ => least_squares(&gram, &right),
    }
}

/// 2.5 % and 97.5 % points, less the median; `None` of nothing.
fn about_median(mut values: Vec<f64>) -> Option<[f64; 2]> {
    let ends = interval95(&mut values)?;
    let middle = median(&mut values)?;
    Some(ends.map(|end| end - middle))
}

/// 2.5 % and 97.5 % points; `None` of nothing.
pub fn interval95(values: &mut [f64]) -> Option<[f64; 2]> {
    values.sort_by(f64::total_cmp);
    let at = |share: f64| values.get((values.len().checked_sub(1)? as f64 * share).round() as usize).copied();
    Some([at(0.025)?, at(0.975)?])
}
