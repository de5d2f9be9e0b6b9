//! Held-out losses by configuration: what every hypothesis leaves of readings that it was not fitted to.
//!
//! A loss is the sum of squared weighted residuals of one configuration, everything that is calibrated being fitted with the
//! hypothesis to the configurations of other folds. Readings of one configuration share what no model has: losses are
//! compared configuration by configuration.
//!
//! Source: Hansen, Lunde and Nason, *The model confidence set*, Econometrica 79, 2011 (paired comparison of losses).

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use rayon::prelude::*;

use super::linear_problem::LinearProblem;
use super::projection::Projection;
use crate::math::linear::tr_mul;
use crate::math::{joined, least_squares, orthonormal};

/// Diagonal of a Cholesky factor below which the fit of a fold is singular; the columns are orthonormal over all rows.
const REGULAR: f64 = 1e-5;

/// Configurations dealt into folds.
pub struct HeldOut {
    /// Number of configurations.
    poses: usize,
    /// Of each row: its configuration, counted from 0.
    pose: Vec<usize>,
    /// Rows of each fold.
    folds: Vec<Vec<usize>>,
}

/// Losses by configuration.
pub struct Losses {
    /// With the members alone.
    pub base: Vec<f64>,
    /// With each candidate in addition, in the order asked.
    pub with: Vec<Vec<f64>>,
}

/// A difference of two losses over the configurations.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Paired {
    /// Sum of the differences.
    pub sum: f64,
    /// Its mean over its standard error; 0 where it is the same everywhere.
    pub t: f64,
}

/// By how much `b` is below `a`, configuration by configuration. Gains that a few configurations hold have a large variance:
/// where the roots of the losses agree in sign, the clearer of the two comparisons counts.
pub fn paired(a: &[f64], b: &[f64]) -> Paired {
    let sum: f64 = a.iter().zip(b).map(|(a, b)| a - b).sum();
    let squares = student(a.iter().zip(b).map(|(a, b)| a - b));
    let roots = student(a.iter().zip(b).map(|(a, b)| a.sqrt() - b.sqrt()));
    let t = if squares * roots > 0.0 && roots.abs() > squares.abs() { roots } else { squares };
    Paired { sum, t }
}

/// Mean over its standard error; 0 where the values are all the same.
fn student(values: impl Iterator<Item = f64> + Clone) -> f64 {
    let n = values.clone().count() as f64;
    let mean = values.clone().sum::<f64>() / n.max(1.0);
    let squares: f64 = values.map(|value| (value - mean).powi(2)).sum();
    let error = (squares / (n - 1.0).max(1.0) / n.max(1.0)).sqrt();
    if error > 0.0 { mean / error } else { 0.0 }
}

impl HeldOut {
    /// Folds of a problem by configuration, `of_pose` giving the fold of each configuration as counted by
    /// [`LinearProblem::poses`]; those without a fold are always fitted.
    pub fn new(problem: &LinearProblem, of_pose: &[Option<usize>]) -> Self {
        let (pose, poses) = problem.numbered();
        let count = of_pose.iter().flatten().max().map_or(0, |last| last + 1);
        let mut folds = vec![Vec::new(); count];
        for (row, &pose) in pose.iter().enumerate() {
            if let Some(fold) = of_pose.get(pose).copied().flatten() {
                folds[fold].push(row);
            }
        }
        Self { poses, pose, folds }
    }

    /// Losses with the members of `additions` and each of its candidates; zero of configurations that no fold holds out.
    pub fn losses(&self, additions: &Additions) -> Losses {
        let Additions { basis, residual, right, candidates } = additions;
        let folds: Vec<Fold> = self.folds.iter().map(|rows| Fold::new(basis, residual, right, rows)).collect();
        let loss = |own: &DMatrix<f64>| {
            let all = own.tr_mul(*residual);
            let mut losses = vec![0.0; self.poses];
            for (fold, rows) in folds.iter().zip(&self.folds) {
                for (row, left) in rows.iter().zip(fold.left(basis, own, &all, residual, rows).iter()) {
                    losses[self.pose[*row]] += left * left;
                }
            }
            losses
        };
        Losses { base: loss(&DMatrix::zeros(residual.len(), 0)), with: candidates.par_iter().map(loss).collect() }
    }
}

impl HeldOut {
    /// Sum over all rows held out of the variance that the uncertainty of a candidate's amounts adds to their prediction, for
    /// noise of one sigma; infinite where the rows fitted do not determine them.
    pub fn added_variance(&self, additions: &Additions, at: usize) -> f64 {
        let own = &additions.candidates[at];
        let of_fold = |rows: &Vec<usize>| {
            let fold = Fold::new(&additions.basis, additions.residual, &additions.right, rows);
            let factor = fold.factor.as_ref()?;
            let own_held = own.select_rows(rows);
            let cross = -tr_mul(&own_held, &fold.held);
            let normal = DMatrix::identity(own.ncols(), own.ncols()) - tr_mul(&own_held, &own_held);
            let schur = (normal - &cross * factor.solve(&cross.transpose())).cholesky().filter(is_regular)?;
            let moved = &own_held - &fold.held * factor.solve(&cross.transpose());
            Some(schur.solve(&moved.tr_mul(&moved)).trace())
        };
        self.folds.iter().map(|rows| of_fold(rows).unwrap_or(f64::INFINITY)).sum()
    }
}

/// Members, and candidates to be added to them, made orthogonal over all rows.
pub struct Additions<'a> {
    /// Orthonormal basis of the nuisance and the members.
    pub basis: DMatrix<f64>,
    residual: &'a DVector<f64>,
    right: DVector<f64>,
    /// Orthonormal bases of what each candidate adds.
    pub candidates: Vec<DMatrix<f64>>,
}

impl<'a> Additions<'a> {
    /// Sets of hypotheses to be added to the members.
    pub fn new(projection: &'a Projection, members: &[usize], candidates: &[Vec<usize>]) -> Self {
        let used = projection.span(members).unwrap_or_else(|| DMatrix::zeros(projection.nuisance.nrows(), 0));
        // The blocks are orthogonal to the nuisance already.
        let own = |set: &Vec<usize>| match set[..] {
            [one] => orthonormal(&projection.blocks[one], Some(&used)),
            _ => projection
                .span(set)
                .map_or_else(|| used.columns(0, 0).into_owned(), |all| orthonormal(&all, Some(&used))),
        };
        let candidates = candidates.par_iter().map(own).collect();
        let basis = joined(&projection.nuisance, &used);
        let residual = &projection.problem.residual;
        Self { right: basis.tr_mul(residual), residual, basis, candidates }
    }

    /// Other columns as the candidates.
    pub fn with(&self, columns: &[DMatrix<f64>]) -> Self {
        let off = |columns: &DMatrix<f64>| columns - &self.basis * tr_mul(&self.basis, columns);
        let candidates = columns.iter().map(|columns| orthonormal(&off(&off(columns)), None)).collect();
        Self { basis: self.basis.clone(), residual: self.residual, right: self.right.clone(), candidates }
    }

    /// Some of the candidates.
    pub fn only(&self, chosen: &[usize]) -> Self {
        Self {
            basis: self.basis.clone(),
            residual: self.residual,
            right: self.right.clone(),
            candidates: chosen.iter().map(|&at| self.candidates[at].clone()).collect(),
        }
    }
}

/// What all hypotheses share in one fold.
struct Fold {
    /// Normal matrix of the basis over the fitted rows, factored; `None` where it is singular.
    factor: Option<Cholesky<f64, Dyn>>,
    /// Its right side.
    right: DVector<f64>,
    /// Rows of the basis that are held out.
    held: DMatrix<f64>,
    /// Residuals that are held out.
    residual: DVector<f64>,
}

impl Fold {
    fn new(basis: &DMatrix<f64>, residual: &DVector<f64>, right: &DVector<f64>, rows: &[usize]) -> Self {
        let (held, residual) = (basis.select_rows(rows), residual.select_rows(rows));
        let normal = DMatrix::identity(basis.ncols(), basis.ncols()) - tr_mul(&held, &held);
        let factor = normal.cholesky().filter(is_regular);
        Self { factor, right: right - held.tr_mul(&residual), held, residual }
    }

    /// What is left of the rows held out, `own` columns (orthonormal, off the basis) being fitted too; `all` is `own' r`.
    fn left(
        &self,
        basis: &DMatrix<f64>,
        own: &DMatrix<f64>,
        all: &DVector<f64>,
        residual: &DVector<f64>,
        rows: &[usize],
    ) -> DVector<f64> {
        let own_held = own.select_rows(rows);
        let reduced = self.factor.as_ref().and_then(|factor| {
            // Over the fitted rows: own' basis = -(held part), since they are orthogonal over all.
            let cross = -tr_mul(&own_held, &self.held);
            let normal = DMatrix::identity(own.ncols(), own.ncols()) - tr_mul(&own_held, &own_held);
            let schur = normal - &cross * factor.solve(&cross.transpose());
            let right = all - own_held.tr_mul(&self.residual) - &cross * factor.solve(&self.right);
            let amounts = match own.ncols() {
                0 => DVector::zeros(0),
                _ => schur.cholesky().filter(is_regular)?.solve(&right),
            };
            let others = factor.solve(&(&self.right - cross.tr_mul(&amounts)));
            Some(&self.residual - &self.held * others - &own_held * amounts)
        });
        reduced.unwrap_or_else(|| {
            // A direction that only the rows held out show: it stays at zero.
            let mut is_held = vec![false; residual.len()];
            rows.iter().for_each(|&row| is_held[row] = true);
            let fitted: Vec<usize> = (0..residual.len()).filter(|&row| !is_held[row]).collect();
            let both = joined(basis, own);
            let x = least_squares(&both.select_rows(&fitted), &residual.select_rows(&fitted));
            &self.residual - both.select_rows(rows) * x
        })
    }
}

fn is_regular(factor: &Cholesky<f64, Dyn>) -> bool {
    factor.l_dirty().diagonal().min() > REGULAR
}
