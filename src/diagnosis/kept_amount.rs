//! Whether a law keeps its amount where errors at another site are free in every configuration.
//!
//! What a true law explains, free errors elsewhere change by no more than they make it uncertain. A law that imitates an error
//! of another site, of no shape that is known, loses most of its amount to them.
//!
//! Source: Hausman, *Specification tests in econometrics*, Econometrica 46, 1978; standard errors by configuration: Liang and
//! Zeger, *Longitudinal data analysis using generalized linear models*, Biometrika 73, 1986.

use nalgebra::{DMatrix, DVector, SymmetricEigen};

use super::compared::Compared;
use super::forward::Forward;
use super::held_out::Additions;
use super::linear_problem::LinearProblem;
use crate::math::linear::tr_mul;
use crate::math::norm;
use crate::math::{joined, project_off};

/// Squares of a direction of what is fitted in addition, of 1, below which free errors have taken it up: far above rounding (1e-16), far
/// below what readings can show.
const LEAST_SQUARES: f64 = 1e-6;

/// Whether most of the amount of a candidate is certainly lost where errors at some site that is not among its own are free.
/// `members` are its hypotheses, `others` those that it is added to; what corrects another of these at its site belongs there.
pub fn is_lost_elsewhere(
    forward: &Forward,
    (additions, others): (&Additions, &[usize]),
    at: usize,
    members: &[usize],
) -> bool {
    let (problem, settings) = (forward.problem, forward.settings);
    let before = project_off(&problem.residual, &additions.basis);
    let own = &additions.candidates[at];
    let shape = own * own.tr_mul(&before);
    let is_own = |site: &str| members.iter().any(|&h| problem.hypotheses[h].is_of_site(site));
    if others.iter().any(|&h| is_own(&problem.hypotheses[h].site.name)) {
        return false;
    }
    let least = LEAST_SQUARES * shape.norm_squared();
    let all = joined(&additions.basis, &DMatrix::from_columns(&[shape, before]));
    let is_lost = |left: &DMatrix<f64>| {
        kept(problem, left, least)
            .is_some_and(|[amount, error]| amount.abs() + settings.paired_t * error < settings.least_rival)
    };
    forward.free_errors.off(&all).any(|(site, left)| !is_own(site) && is_lost(&left))
}

impl Compared<'_> {
    /// Whether most of a candidate's amount is certainly lost where errors at some other site are free.
    pub fn is_lost_elsewhere(&self, at: usize) -> bool {
        is_lost_elsewhere(self.forward, (self.additions, self.others), at, &self.sets[at])
    }
}

/// Amount of a law over the one that it has without free errors, and its standard error. The columns are those of what is fitted in addition,
/// of the law with its amount, and the residual, off the free errors. `None` where these leave less than `least` squares of the law.
fn kept(problem: &LinearProblem, columns: &DMatrix<f64>, least: f64) -> Option<[f64; 2]> {
    let count = columns.ncols() - 2;
    let (others, both) = (columns.columns(0, count).into_owned(), columns.columns(count, 2).into_owned());
    let left = if count == 0 { both } else { off(&others, &both) };
    let (shape, residual) = (left.column(0), left.column(1));
    let squares = shape.norm_squared();
    if squares <= least {
        return None;
    }
    let amount = shape.dot(&residual) / squares;
    let scores = by_configuration(problem, &shape.component_mul(&(residual - shape * amount)));
    Some([amount, norm(&scores) / squares])
}

/// Columns without what others, of which some directions may be gone, take of them.
fn off(others: &DMatrix<f64>, columns: &DMatrix<f64>) -> DMatrix<f64> {
    let eigen = SymmetricEigen::new(tr_mul(others, others));
    let regular: Vec<usize> = (0..others.ncols()).filter(|&k| eigen.eigenvalues[k] > LEAST_SQUARES).collect();
    let directions = eigen.eigenvectors.select_columns(&regular);
    let mut amounts = directions.tr_mul(&tr_mul(others, columns));
    regular.iter().enumerate().for_each(|(k, &own)| amounts.row_mut(k).scale_mut(1.0 / eigen.eigenvalues[own]));
    columns - others * (directions * amounts)
}

/// Sums of rows by configuration.
fn by_configuration(problem: &LinearProblem, rows: &DVector<f64>) -> Vec<f64> {
    let (pose, poses) = problem.numbered();
    let mut sums = vec![0.0; poses];
    rows.iter().zip(pose).for_each(|(value, pose)| sums[pose] += value);
    sums
}
