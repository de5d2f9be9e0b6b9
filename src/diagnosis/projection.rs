//! The linear problem with the nuisance projected off: what is left of the residuals and of the columns of every
//! hypothesis once everything that can be calibrated is calibrated.
//!
//! Source: Frisch, Waugh and Lovell; Davidson and MacKinnon, *Econometric Theory and Methods*, sec. 2.4.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::linear_problem::LinearProblem;
use crate::math::{joined, orthonormal, project_off};

/// A set of hypotheses fitted together with the nuisance.
#[derive(Debug, Clone, Default)]
pub struct Subset {
    /// Hypotheses, by index.
    pub members: Vec<usize>,
    /// Residual sum of squares.
    pub squares: f64,
    /// Directions used by the members.
    pub directions: usize,
}

impl Subset {
    /// Whether another has the same members.
    pub fn is_same(&self, other: &Self) -> bool {
        self.members.len() == other.members.len() && self.members.iter().all(|member| other.members.contains(member))
    }

    /// The members but for the one at a position.
    pub fn without(&self, at: usize) -> Vec<usize> {
        let mut others = self.members.clone();
        others.remove(at);
        others
    }
}

/// What a hypothesis adds to others.
#[derive(Debug, Clone, Copy, Default)]
pub struct Gain {
    /// Sum of squares that it takes up.
    pub squares: f64,
    /// Directions that it uses; 0 where it has none of its own or its amounts are not plausible.
    pub directions: usize,
}

/// Residual and hypotheses, projected.
pub struct Projection<'a> {
    /// The problem before projection.
    pub problem: &'a LinearProblem,
    /// Degrees of freedom left by the nuisance.
    pub freedom: f64,
    /// Orthonormal basis of the nuisance.
    pub nuisance: DMatrix<f64>,
    /// Residual, projected.
    residual: DVector<f64>,
    /// For each hypothesis an orthonormal basis of its projected columns.
    pub blocks: Vec<DMatrix<f64>>,
}

impl<'a> Projection<'a> {
    /// Projects the nuisance off.
    pub fn new(problem: &'a LinearProblem) -> Self {
        let basis = orthonormal(&problem.nuisance, None);
        let blocks = problem.hypotheses.par_iter().map(|h| orthonormal(&h.columns, Some(&basis))).collect();
        Self {
            problem,
            freedom: (problem.rows() - basis.ncols()).max(1) as f64,
            residual: project_off(&problem.residual, &basis),
            nuisance: basis,
            blocks,
        }
    }

    /// Residual sum of squares without any hypothesis.
    pub fn squares(&self) -> f64 {
        self.residual.norm_squared()
    }

    /// Fits a set of hypotheses.
    pub fn fit(&self, members: &[usize]) -> Subset {
        let used = self.span(members);
        let squares =
            used.as_ref().map_or_else(|| self.squares(), |used| project_off(&self.residual, used).norm_squared());
        Subset { members: members.to_vec(), squares, directions: used.map_or(0, |used| used.ncols()) }
    }

    /// An orthonormal basis of all columns of some hypotheses; `None` of none.
    pub fn span(&self, members: &[usize]) -> Option<DMatrix<f64>> {
        members.iter().fold(None, |used: Option<DMatrix<f64>>, &member| match used {
            Some(used) => Some(joined(&used, &orthonormal(&self.blocks[member], Some(&used)))),
            None => Some(self.blocks[member].clone()),
        })
    }

    /// Gain of every hypothesis over those fitted; none where an amount would exceed `greatest` times its common size.
    pub fn gains(&self, members: &[usize], greatest: f64) -> Vec<Gain> {
        let used = self.span(members);
        let residual = used.as_ref().map_or_else(|| self.residual.clone(), |used| project_off(&self.residual, used));
        let gain = |(h, block): (usize, &DMatrix<f64>)| {
            let own = used.as_ref().map_or_else(|| block.clone(), |used| orthonormal(block, Some(used)));
            let along = own.tr_mul(&residual);
            if self.is_plausible(h, &own, &along, greatest) {
                Gain { squares: along.norm_squared(), directions: own.ncols() }
            } else {
                Gain::default()
            }
        };
        self.blocks.par_iter().enumerate().map(gain).collect()
    }

    /// Whether the amounts by which a hypothesis would fit are plausible: compliances of what is rigid are positive, and
    /// no parameter is many times its common size.
    fn is_plausible(&self, h: usize, own: &DMatrix<f64>, along: &DVector<f64>, greatest: f64) -> bool {
        let hypothesis = &self.problem.hypotheses[h];
        if own.ncols() < hypothesis.columns.ncols() {
            return !hypothesis.is_positive;
        }
        let Some(amounts) = own.tr_mul(&hypothesis.columns).lu().solve(along) else { return false };
        amounts.iter().zip(&hypothesis.parameters).all(|(amount, parameter)| match hypothesis.is_positive {
            true => *amount >= 0.0,
            false => amount.abs() <= greatest * parameter.scale,
        })
    }

    /// Cosine of the smallest angle between the columns of two hypotheses.
    pub fn alignment(&self, a: usize, b: usize) -> f64 {
        let product = self.blocks[a].tr_mul(&self.blocks[b]);
        if product.is_empty() { 0.0 } else { product.singular_values().max() }
    }
}
