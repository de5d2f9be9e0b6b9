//! The two iterative schemes of the papers next to the batch fit; all reach the same answer.
//!
//! Sources: IR663 calibration paper, sec. 2.1.5 (pose by pose); KR-270 paper, sec. III.A (base and geometry in turns).

use nalgebra::{DMatrix, DVector};

use crate::least_squares::{Bounds, EvaluationError, Problem, minimize_in_box};
use crate::math::linear::{least_norm, triangle};

/// What an iterative scheme reached.
pub struct Reached {
    pub x: Vec<f64>,
    pub iterations: usize,
    pub converged: bool,
}

/// A pass has converged when it changes no parameter by more than this part of its tolerance.
const PASS: f64 = 1e-7;
/// The same of a turn, which is followed by many as large: a factor of convergence of 0.9 leaves ten times this.
const TURN: f64 = 1e-8;

/// Pose by pose: each configuration's readings are added to the information gathered so far; passes over all
/// configurations, linearised at the pass's start, are repeated until a pass changes nothing. `blocks` are the rows of each
/// configuration, `tolerances` the size of a parameter's change that matters.
///
/// The information is kept as the triangle of a QR to which rows are added (Bierman, *Factorization Methods for Discrete
/// Sequential Estimation*, 1977): the same answer as the paper's recursive update of the covariance, without an invented
/// covariance to begin with.
pub fn pose_by_pose(
    problem: &impl Problem,
    blocks: &[Vec<usize>],
    tolerances: &[f64],
    most: usize,
) -> Result<Reached, EvaluationError> {
    let n = problem.parameters();
    let (mut residual, mut jacobian) = (DVector::zeros(problem.residuals()), DMatrix::zeros(problem.residuals(), n));
    let mut x = vec![0.0; n];
    for pass in 1..=most {
        problem.evaluate(&x, &mut residual, Some(&mut jacobian))?;
        // Columns in units of the tolerances, and the residual as the last one.
        let mut information = DMatrix::<f64>::zeros(0, n + 1);
        for rows in blocks {
            let known = information.nrows();
            let mut stacked = information.resize_vertically(known + rows.len(), 0.0);
            for (k, &row) in rows.iter().enumerate() {
                (0..n).for_each(|j| stacked[(known + k, j)] = jacobian[(row, j)] * tolerances[j]);
                stacked[(known + k, n)] = residual[row];
            }
            information = triangle(stacked);
        }
        let step = least_norm(information.columns(0, n).into_owned(), &information.column(n).into_owned());
        for ((x, step), tolerance) in x.iter_mut().zip(&step).zip(tolerances) {
            *x += step * tolerance;
        }
        if step.amax() < PASS {
            return Ok(Reached { x, iterations: pass, converged: true });
        }
    }
    Ok(Reached { x, iterations: most, converged: false })
}

/// In turns: base and tool with the geometry held, then the geometry with base and tool held, one linear step each, until
/// neither changes. `arrangement` marks base and tool.
pub fn alternating(
    problem: &impl Problem,
    arrangement: &[bool],
    bounds: &Bounds,
    tolerances: &[f64],
    most: usize,
) -> Result<Reached, EvaluationError> {
    let n = problem.parameters();
    let (mut residual, mut jacobian) = (DVector::zeros(problem.residuals()), DMatrix::zeros(problem.residuals(), n));
    let mut x = vec![0.0; n];
    let turns = [true, false].map(|turn| (0..n).filter(|&j| arrangement[j] == turn).collect::<Vec<usize>>());
    for iteration in 1..=most {
        let mut largest = 0.0_f64;
        for own in turns.iter().filter(|own| !own.is_empty()) {
            problem.evaluate(&x, &mut residual, Some(&mut jacobian))?;
            let columns = jacobian.select_columns(own);
            let allowed = Bounds {
                lower: own.iter().map(|&j| bounds.lower[j] - x[j]).collect(),
                upper: own.iter().map(|&j| bounds.upper[j] - x[j]).collect(),
            };
            let step = minimize_in_box(&columns, &residual, &allowed).map_err(EvaluationError::new)?;
            for (&j, step) in own.iter().zip(&step) {
                x[j] += step;
                largest = largest.max(step.abs() / tolerances[j]);
            }
        }
        if largest < TURN {
            return Ok(Reached { x, iterations: iteration, converged: true });
        }
    }
    Ok(Reached { x, iterations: most, converged: false })
}
