//! Fits in which outliers count little: a safe start and a robust scale first, then the loss that was asked for.
//!
//! A loss that forgets large residuals (Tukey's, Cauchy's) has a minimum wherever the start lies: where the start is off by
//! more than its scale, nothing pulls. MM-estimation (Yohai, *High breakdown-point and high efficiency robust estimates for
//! regression*, Ann. Statist. 15, 1987) therefore goes in three steps, and so does this: a first robust fit that any start
//! serves, the scale of its residuals, then the loss with that scale, begun there. The first fit is Huber's, which is convex
//! for a linear model, taken in turns with the scale, the median absolute deviation of the residuals (Huber and Ronchetti,
//! *Robust Statistics*, 2nd ed., Wiley 2009, sections 6.4 and 7.8). Lengths and angles have a scale each. It withstands
//! outliers of the measured values; against wrong joint values, which act as leverage points, no loss of this kind does.

use nalgebra::DVector;

use super::problem::CampaignProblem;
use crate::least_squares::{self, Bounds, Loss, Problem, Progress, Settings, Solution, Status, UsageError};
use crate::math::median;
use crate::math::quantiles::{HUBER, OF_MEDIAN};

/// Most turns of fit and scale. Each shrinks the scale by the bias that outliers leave, a factor of 3 or more with a fifth
/// of the rows bad: from metres to micrometres in a dozen.
const TURNS: usize = 40;
/// A turn that changes the scale by less than this part is the last; the loss itself does not notice.
const SETTLED: f64 = 1e-2;
/// Most iterations of one turn: it goes on in the next.
const ITERATIONS: usize = 30;
/// Relative change of the cost that ends a turn.
const TOLERANCE: f64 = 1e-8;

/// Standard deviation of normal noise of which these are, by their median absolute deviation from zero; `None` of nothing.
pub(super) fn deviation(residuals: impl Iterator<Item = f64>) -> Option<f64> {
    median(&mut residuals.map(f64::abs).collect::<Vec<f64>>()).map(|middle| OF_MEDIAN * middle)
}

/// As [`least_squares::minimize_observed`] from no change; with a robust loss by the three steps above, after which the
/// problem holds the scales that the loss was used with.
pub fn minimize(
    problem: &CampaignProblem,
    bounds: &Bounds,
    limits: &Settings,
    progress: &mut dyn FnMut(&Progress),
) -> Result<Solution, UsageError> {
    let mut start = vec![0.0; problem.parameters()];
    if limits.loss == Loss::Squares {
        return to_the_end(problem, &start, bounds, limits, progress);
    }
    let mut before = 0;
    let mut residual = DVector::zeros(problem.residuals());
    if problem.evaluate(&start, &mut residual, None).is_ok() {
        let huber = Settings {
            loss: Loss::Huber(HUBER),
            max_iterations: limits.max_iterations.min(ITERATIONS),
            cost_tolerance: limits.cost_tolerance.max(TOLERANCE),
            ..*limits
        };
        problem.tune(scales(problem, &residual));
        for _ in 0..TURNS {
            let known = problem.tuned();
            let found = least_squares::minimize_observed(problem, &start, bounds, &huber, progress)?;
            let new = scales(problem, &found.residual);
            problem.tune(new);
            start = found.x;
            before += found.iterations;
            if known.iter().zip(&new).all(|(known, new)| (new / known - 1.0).abs() <= SETTLED) {
                break;
            }
        }
    }
    let mut found = to_the_end(problem, &start, bounds, limits, progress)?;
    found.iterations += before;
    Ok(found)
}

/// As [`least_squares::minimize_observed`]; where derivatives that leave out the sag lead nowhere, on with those that count it. They
/// are a tenth wrong where a ball touches a small sphere: the sag turns the direction in which it touches.
fn to_the_end(
    problem: &CampaignProblem,
    start: &[f64],
    bounds: &Bounds,
    limits: &Settings,
    progress: &mut dyn FnMut(&Progress),
) -> Result<Solution, UsageError> {
    let found = least_squares::minimize_observed(problem, start, bounds, limits, progress)?;
    let Some(exact) = problem.with_sag().filter(|_| found.status == Status::Stalled) else { return Ok(found) };
    let mut last = least_squares::minimize_observed(&exact, &found.x, bounds, limits, progress)?;
    last.iterations += found.iterations;
    Ok(last)
}

/// Robust standard deviations of the residuals that are lengths, of those that are angles and of torques, in stated ones: at least 1
/// where the noise is stated, so that a lucky fit does not reject sound readings.
fn scales(problem: &CampaignProblem, residual: &DVector<f64>) -> [f64; 3] {
    let (kinds, least) = (problem.kinds(), problem.least_scales());
    // What the fit took up is missing in the residuals.
    let (rows, used) = (kinds.len() as f64, problem.parameters() as f64);
    let small = (rows / (rows - used).max(1.0)).sqrt();
    std::array::from_fn(|kind| {
        let own = residual.iter().zip(kinds).filter(|(_, own)| **own == kind).map(|(r, _)| *r);
        deviation(own).map_or(1.0, |scale| (small * scale).max(least[kind]))
    })
}
