//! Whether any hypothesis shows anything at all, without a noise that is known: signs of whole configurations are flipped.
//!
//! What independent noise leaves in one configuration could as well have had the other sign, whatever its readings share.
//! The score of each hypothesis is standardised and compared with the greatest score of all hypotheses under random flips,
//! which holds the chance over all of them. Flipped residuals keep less of the directions that were fitted; scores are
//! scaled for that.
//!
//! Source: Westfall and Young, *Resampling-Based Multiple Testing*, 1993; Hemerik, Goeman and Finos, *Robust testing in
//! generalized linear models by sign flipping score contributions*, J. R. Stat. Soc. B 82, 2020.

use nalgebra::{DMatrix, DVector};
use rand::RngExt;
use rayon::prelude::*;

use super::held_out::Additions;
use super::linear_problem::LinearProblem;
use crate::math::project_off;
use crate::simulation::generator;

/// Contributions of one set of hypotheses to its score.
struct Score {
    /// By configuration (columns), whitened: the sum of their outer products is the identity.
    parts: DMatrix<f64>,
    /// What flips keep of a variance.
    kept: f64,
}

/// Probability that scores as great as those of each candidate are chance, over all of them.
pub fn chances(problem: &LinearProblem, additions: &Additions, flips: usize, seed: u64) -> Vec<f64> {
    let residual = project_off(&problem.residual, &additions.basis);
    let (pose, poses) = problem.numbered();
    let scores: Vec<Option<Score>> =
        additions.candidates.par_iter().map(|own| Score::new(own, &additions.basis, &residual, &pose)).collect();
    let observed: Vec<f64> =
        scores.iter().map(|score| score.as_ref().map_or(f64::NEG_INFINITY, Score::observed)).collect();
    let greatest = |index: usize| {
        let mut random = generator(seed.wrapping_mul(1_000_003).wrapping_add(index as u64));
        let signs = DVector::from_fn(poses, |_, _| if random.random::<bool>() { 1.0 } else { -1.0 });
        scores.iter().flatten().map(|score| score.flipped(&signs)).fold(f64::NEG_INFINITY, f64::max)
    };
    let greatest: Vec<f64> = (0..flips).into_par_iter().map(greatest).collect();
    let chance = |own: &f64| (1 + greatest.iter().filter(|other| *other >= own).count()) as f64 / (1 + flips) as f64;
    observed.iter().map(chance).collect()
}

impl Score {
    /// `None` where the columns add nothing to the basis.
    fn new(own: &DMatrix<f64>, basis: &DMatrix<f64>, residual: &DVector<f64>, pose: &[usize]) -> Option<Self> {
        let width = own.ncols();
        let count = pose.iter().max().map_or(0, |last| last + 1);
        let mut parts = DMatrix::zeros(width, count);
        let mut lost = 0.0;
        let mut row = 0;
        while row < pose.len() {
            let end = (row..pose.len()).find(|&other| pose[other] != pose[row]).unwrap_or(pose.len());
            let block = own.rows(row, end - row);
            let part = block.tr_mul(&residual.rows(row, end - row));
            let mut column = parts.column_mut(pose[row]);
            column += part;
            lost += basis.rows(row, end - row).tr_mul(&block).norm_squared();
            row = end;
        }
        let variance = &parts * parts.transpose();
        let factor = (width > 0).then(|| variance.cholesky()).flatten()?;
        let whitened = factor.l().solve_lower_triangular(&parts)?;
        Some(Self { parts: whitened, kept: (1.0 - lost / width as f64).max(0.05) })
    }

    fn observed(&self) -> f64 {
        normal(self.parts.column_sum().norm_squared(), self.parts.nrows())
    }

    fn flipped(&self, signs: &DVector<f64>) -> f64 {
        normal((&self.parts * signs).norm_squared() / self.kept, self.parts.nrows())
    }
}

/// Chi-squared with so many degrees of freedom as a standard normal variable, that different widths compare.
///
/// Source: Wilson and Hilferty, *The distribution of chi-square*, PNAS 17, 1931.
fn normal(value: f64, freedom: usize) -> f64 {
    let spread = 2.0 / (9.0 * freedom as f64);
    ((value / freedom as f64).cbrt() - (1.0 - spread)) / spread.sqrt()
}
