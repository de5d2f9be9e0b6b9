//! The linear problem with the nuisance projected off: what is left of the residuals and of the columns of every
//! hypothesis once everything that can be calibrated is calibrated.
//!
//! Source: Frisch, Waugh and Lovell; Davidson and MacKinnon, *Econometric Theory and Methods*, sec. 2.4.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::hypothesis::{Hypothesis, JointCompliance};
use super::linear_problem::LinearProblem;
use crate::effects::SiteKind;
use crate::math::linear::tr_mul;
use crate::math::{distinct, joined, least_squares, orthonormal, project_off};

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
    /// For each hypothesis its columns in that basis.
    products: Vec<DMatrix<f64>>,
}

/// Standard errors beyond which an amount is certain.
const CERTAIN: f64 = 2.0;
/// Share of the greatest amount below which a joint has none of what all joints have. A judgement: controllers and loads of the joints of one
/// arm differ, by a factor of five on the machine that is known (`docs/real-data.md`).
const LEAST_OF_JOINTS: f64 = 0.1;
/// Least diagonal of a Cholesky factor, of columns of length one, by which gains are computed from Gram matrices.
const REGULAR: f64 = 1e-3;

impl<'a> Projection<'a> {
    /// Projects the nuisance off.
    pub fn new(problem: &'a LinearProblem) -> Self {
        let basis = orthonormal(&problem.nuisance, None);
        let of = |h: &Hypothesis| {
            let block = orthonormal(&h.columns, Some(&basis));
            let product = tr_mul(&block, &h.columns);
            (block, product)
        };
        let (blocks, products) = problem.hypotheses.par_iter().map(of).unzip();
        Self {
            problem,
            freedom: (problem.rows() - basis.ncols()).max(1) as f64,
            residual: project_off(&problem.residual, &basis),
            nuisance: basis,
            blocks,
            products,
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

    /// Gain of every hypothesis over those fitted; none where an amount would exceed `greatest` times its common size, or a curve
    /// take away more than the share `slope` of its joint's motion.
    pub fn gains(&self, members: &[usize], greatest: f64, slope: f64) -> Vec<Gain> {
        self.gains_with(members, (greatest, slope), false)
    }

    /// The same, of curves by their shapes: what these readings do not show of their amounts may be any.
    pub fn gains_of_shapes(&self, members: &[usize], greatest: f64, slope: f64) -> Vec<Gain> {
        self.gains_with(members, (greatest, slope), true)
    }

    fn gains_with(&self, members: &[usize], (greatest, slope): (f64, f64), of_shapes: bool) -> Vec<Gain> {
        let used = self.span(members);
        let residual = used.as_ref().map_or_else(|| self.residual.clone(), |used| project_off(&self.residual, used));
        let gain = |(h, block): (usize, &DMatrix<f64>)| {
            let right = block.tr_mul(&residual);
            // What the block adds has the Gram matrix 1 - C'C, C being its part along what is used.
            let normal = match &used {
                Some(used) => {
                    let along = tr_mul(used, block);
                    DMatrix::identity(block.ncols(), block.ncols()) - along.tr_mul(&along)
                }
                None => DMatrix::identity(block.ncols(), block.ncols()),
            };
            let factor =
                normal.clone().cholesky().filter(|factor| factor.l_dirty().diagonal().iter().all(|d| *d > REGULAR));
            let (squares, directions, amounts) = match (factor, &used) {
                (Some(factor), _) => {
                    let x = factor.solve(&right);
                    (x.dot(&right), block.ncols(), x)
                }
                (None, None) => return Gain::default(),
                (None, Some(used)) => {
                    let own = orthonormal(block, Some(used));
                    if own.is_empty() {
                        return Gain::default();
                    }
                    let along = own.tr_mul(&residual);
                    let amounts = least_squares(&tr_mul(&own, block), &along);
                    (along.norm_squared(), own.ncols(), amounts)
                }
            };
            let variance = (residual.norm_squared() - squares).max(0.0) / self.freedom;
            let has_compliance = |of: &JointCompliance| {
                members.iter().any(|&member| self.problem.hypotheses[member].constants.contains(&of.slot))
            };
            let compliance = self.problem.hypotheses[h].compliance.as_ref();
            // Without a limit of slopes amounts are not judged; where the joint's own compliance is fitted too, the sum is not known here.
            let compliance = compliance.filter(|of| slope.is_finite() && !has_compliance(of));
            let is_negative = compliance.is_some_and(|of| {
                directions == self.problem.hypotheses[h].columns.ncols()
                    && self.amounts(h, &amounts, of_shapes).is_some_and(|amounts| of.is_negative(&amounts))
            });
            let is_plausible = !is_negative
                && self.is_plausible(h, directions, &amounts, (greatest, slope, of_shapes))
                && self.is_of_all_joints(h, &amounts, &normal, variance);
            if is_plausible { Gain { squares, directions } } else { Gain::default() }
        };
        self.blocks.par_iter().enumerate().map(gain).collect()
    }

    /// Whether the amounts by which a hypothesis would fit, of its orthonormal columns, are plausible: compliances of what is
    /// rigid and what cannot be negative are positive, and no parameter is many times its common size.
    fn is_plausible(
        &self,
        h: usize,
        directions: usize,
        of_block: &DVector<f64>,
        (greatest, slope, of_shapes): (f64, f64, bool),
    ) -> bool {
        let hypothesis = &self.problem.hypotheses[h];
        if slope.is_finite() && self.is_steeper(h, of_block, slope) {
            return false;
        }
        if directions < hypothesis.columns.ncols() {
            return !hypothesis.is_positive;
        }
        let Some(amounts) = self.amounts(h, of_block, of_shapes) else { return false };
        let greatest = match hypothesis.effect.greatest_amount() {
            Some(own) if greatest.is_finite() => own,
            _ => greatest,
        };
        // Amounts of constants are shifts: those of what is not rigid can be negative.
        let can_be_negative = |is_positive: bool| !is_positive || !hypothesis.constants.is_empty();
        amounts.iter().zip(&hypothesis.parameters).all(|(amount, parameter)| match hypothesis.is_positive {
            true => *amount >= 0.0,
            false => {
                amount.abs() <= greatest * parameter.scale && (*amount >= 0.0 || can_be_negative(parameter.is_positive))
            }
        })
    }

    /// Whether a hypothesis is a curve over its joint's own position that undoes more than a share of its motion between two knots; of columns that
    /// are not told apart by the least amounts that do as much.
    fn is_steeper(&self, h: usize, of_block: &DVector<f64>, share: f64) -> bool {
        let (hypothesis, product) = (&self.problem.hypotheses[h], &self.products[h]);
        if product.is_empty() || !hypothesis.is_over_own_position() {
            return false;
        }
        let svd = product.clone().svd(true, true);
        let least = f64::EPSILON * svd.singular_values.max() * product.nrows().max(product.ncols()) as f64;
        svd.solve(of_block, least).is_ok_and(|amounts| hypothesis.is_steeper(&amounts, share))
    }

    /// Amounts of a hypothesis from those of its orthonormal columns; of a shape without what these readings do not show: along a line for which
    /// constants can stand amounts may be any.
    fn amounts(&self, h: usize, of_block: &DVector<f64>, of_shapes: bool) -> Option<DVector<f64>> {
        let hypothesis = &self.problem.hypotheses[h];
        let product = &self.products[h];
        if !(of_shapes && hypothesis.is_free()) || product.is_empty() {
            return product.clone().lu().solve(of_block);
        }
        let scale = |k: usize| hypothesis.parameters.get(k).map_or(1.0, |own| own.scale);
        let scaled = DMatrix::from_fn(product.nrows(), product.ncols(), |i, k| product[(i, k)] * scale(k));
        // Amounts of common size along it then make less than one sigma in all.
        let found = scaled.svd(true, true).solve(of_block, 1.0).ok()?;
        Some(DVector::from_fn(found.len(), |k, _| found[k] * scale(k)))
    }

    /// Whether amounts of all joints together, which have one cause, are not certainly of some joints alone: at least two certainly differ from
    /// zero, and none is certainly below [`LEAST_OF_JOINTS`] of the greatest, in its direction. `normal` is the Gram matrix of the block off what
    /// is used, `variance` that of the residuals.
    fn is_of_all_joints(&self, h: usize, of_block: &DVector<f64>, normal: &DMatrix<f64>, variance: f64) -> bool {
        if self.problem.hypotheses[h].site.kind != SiteKind::Joints {
            return true;
        }
        let product = &self.products[h];
        // Few configurations do not tell the joints apart.
        if !product.is_square() {
            return false;
        }
        let (Some(amounts), Some(inverse)) =
            (product.clone().lu().solve(of_block), product.tr_mul(&(normal * product)).try_inverse())
        else {
            return false;
        };
        let of = |(amount, own): (&f64, f64)| (*amount, CERTAIN * (variance * own).sqrt());
        let known: Vec<(f64, f64)> = amounts.iter().zip(inverse.diagonal().iter().copied()).map(of).collect();
        let certain = known.iter().filter(|(amount, error)| amount.abs() > *error).count();
        // Joints that turn and those that slide each among themselves.
        let units: Vec<&str> = self.problem.hypotheses[h].parameters.iter().map(|own| own.unit).collect();
        let are_alike = |unit: &str| {
            let own = || known.iter().zip(&units).filter(|(_, own)| **own == unit).map(|(own, _)| own);
            let certain = own().filter(|(amount, error)| amount.abs() > *error).map(|(amount, _)| *amount);
            let greatest = certain.fold(0.0_f64, |most, amount| if amount.abs() > most.abs() { amount } else { most });
            own().all(|(amount, error)| amount * greatest.signum() + error > LEAST_OF_JOINTS * greatest.abs())
        };
        certain > 1 && distinct(units.iter().copied()).into_iter().all(are_alike)
    }

    /// Cosine of the smallest angle between the columns of two hypotheses.
    pub fn alignment(&self, a: usize, b: usize) -> f64 {
        let product = tr_mul(&self.blocks[a], &self.blocks[b]);
        if product.is_empty() { 0.0 } else { product.singular_values().max() }
    }
}
