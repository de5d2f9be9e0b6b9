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
use crate::identifiability::{Identifiability, merged};
use crate::parameter::{Group, Slot};
use crate::prediction::{PredictionError, Predictor};

/// Step of the derivative along the surface, in tolerances: small against the curvature of angles of degrees, large against
/// rounding.
const STEP: f64 = 0.1;

/// Of the kept parameters at the solution.
pub struct Merged {
    /// What each took over, as [`Identifiability::combinations`].
    pub combinations: Vec<(usize, Vec<(usize, f64)>)>,
    /// Standard uncertainty of each kept one by what dropped ones do in second order, in its unit.
    pub second_order: Vec<f64>,
}

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
    let about = columns(predictor, held);
    let factors = |values: &[f64]| -> Result<_, PredictionError> {
        Ok(merged(&weighted(predictor, values, sigmas)?, &about, &found.kept, &found.dropped))
    };
    let combinations = factors(values)?;
    // Springs that act as one are split by their own rule.
    let registry = &predictor.model.registry;
    let uncertain = |column: &usize| {
        let tolerance = about[*column].tolerance;
        registry[predictor.slots[*column]].group != Group::Elastic && tolerance > 0.0 && tolerance.is_finite()
    };
    let is_merged = |column: &usize| combinations.iter().any(|(_, terms)| terms.iter().any(|(k, _)| k == column));
    let dropped: Vec<usize> =
        found.dropped.iter().map(|(column, _)| *column).filter(uncertain).filter(is_merged).collect();
    let dense = |combinations: &[(usize, Vec<(usize, f64)>)]| dense(combinations, &found.kept, &dropped);
    let here = dense(&combinations);
    // B_ij s_i s_j of each kept parameter, one table for each i.
    let mut bends = Vec::with_capacity(dropped.len());
    for (i, &column) in dropped.iter().enumerate() {
        let step = STEP * about[column].tolerance;
        let mut moved = values.to_vec();
        moved[predictor.slots[column]] += step;
        for (row, &kept) in found.kept.iter().enumerate() {
            moved[predictor.slots[kept]] -= here[(row, i)] * step;
        }
        // A loop that cannot be closed there says nothing of the curvature.
        let Ok(there) = factors(&moved) else { continue };
        let mut bend = (dense(&there) - &here) / STEP;
        for (mut of_column, &column) in bend.column_iter_mut().zip(&dropped) {
            of_column *= about[column].tolerance;
        }
        bends.push((i, bend));
    }
    let second_order = (0..found.kept.len()).map(|row| {
        let mut table = DMatrix::<f64>::zeros(dropped.len(), dropped.len());
        for (i, bend) in &bends {
            for j in 0..dropped.len() {
                table[(*i, j)] += 0.5 * bend[(row, j)];
                table[(j, *i)] += 0.5 * bend[(row, j)];
            }
        }
        (0.25 * table.trace().powi(2) + 0.5 * table.norm_squared()).sqrt()
    });
    Ok(Merged { second_order: second_order.collect(), combinations })
}

/// Factors as a table, a row for each kept column and a column for each dropped one.
fn dense(combinations: &[(usize, Vec<(usize, f64)>)], kept: &[usize], dropped: &[usize]) -> DMatrix<f64> {
    let mut table = DMatrix::zeros(kept.len(), dropped.len());
    for (keeper, terms) in combinations {
        let Ok(row) = kept.binary_search(keeper) else { continue };
        for (column, factor) in terms {
            if let Some(j) = dropped.iter().position(|other| other == column) {
                table[(row, j)] = *factor;
            }
        }
    }
    table
}
