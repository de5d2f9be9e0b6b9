//! What dropped parameters mean for those that they are merged into, at the solution.
//!
//! Parameters that the readings cannot separate span a surface of equal readings. The calibration names its point where the
//! dropped parameters `d` have the description's values; the robot is at another, their true errors `e` away. To first
//! order the kept parameters there differ by `F e`, with the factors `F` ([`Identifiability::combinations`]); to second,
//! with `B_ij` the derivative of the factor of `j` along the surface in the direction of `i`,
//!
//! ```text
//!   k_found = k_true + F e + 1/2 sum_ij B_ij e_i e_j
//! ```
//!
//! The errors are not known, but their size is: independent, with the tolerances `s` as standard deviations, the last term
//! has for each kept parameter the second moment `(1/2 sum_i B_ii s_i^2)^2 + 1/2 sum_ij (B_ij s_i s_j)^2` (`B` made symmetric). It is
//! an uncertainty of type B (*Guide to the expression of uncertainty in measurement*, JCGM 100, 4.3), of the meaning of a value
//! and not of what the robot does: readings that the calibrated description predicts do not have it.

use nalgebra::DMatrix;

use super::reduction::{columns, weighted};
use crate::description::campaign::Campaign;
use crate::identifiability::{Column, Identifiability, Why, merged};
use crate::parameter::{Group, Slot};
use crate::prediction::{PredictionError, Predictor};

/// Step of the derivative along the surface, in tolerances: small against the curvature of angles of degrees, large against
/// rounding.
const STEP: f64 = 0.1;

/// Rows for each column that the curvature is computed from. How parameters that the readings cannot separate replace each other is the
/// same whichever readings show them; a few times as many rows as columns do.
const ROWS_PER_COLUMN: usize = 10;

/// Relative difference of factors, computed from some of the readings and from all, that is rounding.
const SAME: f64 = 1e-6;

/// Its multiples are spread most evenly over an interval (Weyl 1916).
const GOLDEN: f64 = 0.618_033_988_749_895;

/// Of the kept parameters at the solution.
pub struct Merged {
    /// What each took over, as [`Identifiability::combinations`].
    pub combinations: Combinations,
    /// Standard uncertainty of each kept one by what dropped ones do in second order, in its unit.
    pub second_order: Vec<f64>,
}

/// What each kept column took over: dropped columns and factors.
type Combinations = Vec<(usize, Vec<(usize, f64)>)>;

/// Factors of the reduction `found` at `values`, and what they leave open in second order.
///
/// # Errors
/// Readings that cannot be predicted at `values`.
pub fn at_solution(
    predictor: &Predictor,
    values: &[f64],
    sigmas: &[f64],
    held: &[Slot],
    found: &Identifiability,
) -> Result<Merged, PredictionError> {
    let mut surface = Surface { about: columns(predictor, held), values, found, dropped: Vec::new() };
    let combinations = surface.factors(predictor, values, sigmas)?;
    surface.dropped = surface.uncertain(predictor, &combinations);
    let here = surface.table(&combinations);
    let enough = ROWS_PER_COLUMN * predictor.slots.len();
    let mut bends = None;
    if predictor.campaign.rows() > 2 * enough {
        let (some, own) = spread(predictor.campaign, sigmas, enough);
        let of_some = Predictor::new(predictor.model, &some, predictor.slots.clone())?;
        let there = surface.table(&surface.factors(&of_some, values, &own)?);
        bends = surface.is_same(&here, &there).then(|| surface.bends(&of_some, &own, &there));
    }
    let bends = bends.unwrap_or_else(|| surface.bends(predictor, sigmas, &here));
    Ok(Merged { second_order: surface.second_order(&bends), combinations })
}

/// The surface of equal readings about a solution.
struct Surface<'a> {
    about: Vec<Column>,
    /// By slot.
    values: &'a [f64],
    found: &'a Identifiability,
    /// Dropped columns whose parameters are uncertain and were merged into others.
    dropped: Vec<usize>,
}

impl Surface<'_> {
    fn factors(&self, predictor: &Predictor, values: &[f64], sigmas: &[f64]) -> Result<Combinations, PredictionError> {
        Ok(merged(&weighted(predictor, values, sigmas)?, &self.about, &self.found.kept, &self.found.dropped))
    }

    fn uncertain(&self, predictor: &Predictor, combinations: &Combinations) -> Vec<usize> {
        // Springs that act as one are split by their own rule.
        let is_uncertain = |column: &usize| {
            let tolerance = self.about[*column].tolerance;
            let group = predictor.model.registry[predictor.slots[*column]].group;
            group != Group::Elastic && tolerance > 0.0 && tolerance.is_finite()
        };
        let is_merged = |column: &usize| combinations.iter().any(|(_, terms)| terms.iter().any(|(k, _)| k == column));
        self.found.dropped.iter().map(|(column, _)| *column).filter(is_uncertain).filter(is_merged).collect()
    }

    /// Factors as a table, a row for each kept column and a column for each dropped one.
    fn table(&self, combinations: &Combinations) -> DMatrix<f64> {
        let mut table = DMatrix::zeros(self.found.kept.len(), self.dropped.len());
        for (keeper, terms) in combinations {
            let Ok(row) = self.found.kept.binary_search(keeper) else { continue };
            for (column, factor) in terms {
                if let Some(j) = self.dropped.iter().position(|other| other == column) {
                    table[(row, j)] = *factor;
                }
            }
        }
        table
    }

    /// Whether some of the readings give the exactly dependent columns the factors that all give them, and there are such columns.
    fn is_same(&self, here: &DMatrix<f64>, there: &DMatrix<f64>) -> bool {
        let is_exact = |&k: &usize| self.found.dropped.contains(&(self.dropped[k], Why::Exact));
        let exact: Vec<usize> = (0..self.dropped.len()).filter(is_exact).collect();
        // Entry by entry: factors that cannot be computed equal none.
        let is_same = |&k: &usize| {
            let limit = SAME * here.column(k).amax();
            there.column(k).iter().zip(&here.column(k)).all(|(there, here)| (there - here).abs() <= limit)
        };
        !exact.is_empty() && exact.iter().all(is_same)
    }

    /// `B_ij s_i s_j` of each kept parameter (rows) by each dropped one `j` (columns), one table for each `i` that the surface reaches.
    fn bends(&self, predictor: &Predictor, sigmas: &[f64], here: &DMatrix<f64>) -> Vec<(usize, DMatrix<f64>)> {
        let mut bends = Vec::with_capacity(self.dropped.len());
        for (i, &column) in self.dropped.iter().enumerate() {
            let step = STEP * self.about[column].tolerance;
            let mut moved = self.values.to_vec();
            moved[predictor.slots[column]] += step;
            for (row, &kept) in self.found.kept.iter().enumerate() {
                moved[predictor.slots[kept]] -= here[(row, i)] * step;
            }
            // A loop that cannot be closed there says nothing of the curvature.
            let Ok(there) = self.factors(predictor, &moved, sigmas) else { continue };
            let mut bend = (self.table(&there) - here) / STEP;
            for (mut of_column, &column) in bend.column_iter_mut().zip(&self.dropped) {
                of_column *= self.about[column].tolerance;
            }
            bends.push((i, bend));
        }
        bends
    }

    fn second_order(&self, bends: &[(usize, DMatrix<f64>)]) -> Vec<f64> {
        let count = self.dropped.len();
        let of_row = |row: usize| {
            let mut table = DMatrix::<f64>::zeros(count, count);
            for (i, bend) in bends {
                for j in 0..count {
                    table[(*i, j)] += 0.5 * bend[(row, j)];
                    table[(j, *i)] += 0.5 * bend[(row, j)];
                }
            }
            (0.25 * table.trace().powi(2) + 0.5 * table.norm_squared()).sqrt()
        };
        (0..self.found.kept.len()).map(of_row).collect()
    }
}

/// Readings with at least so many rows, spread over the campaign without a period, and the sigmas of their rows; constraints stay.
fn spread(campaign: &Campaign, sigmas: &[f64], rows: usize) -> (Campaign, Vec<f64>) {
    let part = rows as f64 / campaign.rows().max(1) as f64;
    // Multiples of the golden ratio: no pattern of markers or sessions meets them.
    let is_used = |index: usize| (index as f64 * GOLDEN).fract() < part;
    let of_readings = campaign.by_reading(sigmas, 1).enumerate().filter(|(index, _)| is_used(*index));
    let own = of_readings.flat_map(|(_, (_, own))| own.iter().copied());
    let constraints = sigmas.len().saturating_sub(campaign.constraints.len());
    (campaign.select(|index, _| is_used(index)), own.chain(sigmas[constraints..].iter().copied()).collect())
}
