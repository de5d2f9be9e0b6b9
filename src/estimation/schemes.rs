//! The two iterative schemes of the papers, beside the batch fit; all reach the same answer.

use nalgebra::{DMatrix, DVector};

use crate::least_squares::{Bounds, EvaluationError, Problem};

/// What an iterative scheme reached.
pub struct Reached {
    pub x: Vec<f64>,
    pub iterations: usize,
    pub converged: bool,
}

const STEP: f64 = 1e-10;

/// Pose by pose (IR663 paper, sec. 2.1.5): each configuration's readings are added to the information gathered so far
/// and the parameters updated at once; passes over all configurations are repeated until a pass changes nothing.
/// `blocks` are the rows of each configuration, `sigmas` the size of a parameter's change that matters.
pub fn pose_by_pose(
    problem: &impl Problem,
    blocks: &[Vec<usize>],
    sigmas: &[f64],
    most: usize,
) -> Result<Reached, EvaluationError> {
    let n = problem.parameters();
    let (mut residual, mut jacobian) = (DVector::zeros(problem.residuals()), DMatrix::zeros(problem.residuals(), n));
    let mut x = vec![0.0; n];
    for pass in 1..=most {
        let start = x.clone();
        // A prior much wider than the tolerances keeps the first updates, which see few readings, determined.
        let mut information =
            DMatrix::from_diagonal(&DVector::from_iterator(n, sigmas.iter().map(|s| (1e-6 / s).powi(2))));
        let mut right = DVector::zeros(n);
        // Linearised at the pass's start: on the way, few readings can lead far astray.
        problem.evaluate(&start, &mut residual, Some(&mut jacobian))?;
        for rows in blocks {
            let own = jacobian.select_rows(rows.iter());
            let about_start = DVector::from_iterator(rows.len(), rows.iter().map(|&row| -residual[row]));
            information += own.transpose() * &own;
            right += own.transpose() * about_start;
            let scale = DVector::from_iterator(n, information.diagonal().iter().map(|d| 1.0 / d.sqrt()));
            let scaled = DMatrix::from_fn(n, n, |i, j| information[(i, j)] * scale[i] * scale[j]);
            let Some(factor) = scaled.cholesky() else { continue };
            let step = factor.solve(&right.component_mul(&scale)).component_mul(&scale);
            x = start.iter().zip(step.iter()).map(|(s, d)| s + d).collect();
        }
        let largest = x.iter().zip(&start).zip(sigmas).fold(0.0_f64, |m, ((x, s), sigma)| m.max((x - s).abs() / sigma));
        if largest < 1e-7 {
            return Ok(Reached { x, iterations: pass, converged: true });
        }
    }
    Ok(Reached { x, iterations: most, converged: false })
}

/// Alternately (KR-270 paper, sec. III.A): base and tool with the geometry held, then the geometry with base and tool
/// held, one linear step each, until neither changes. `first` marks base and tool.
pub fn alternating(
    problem: &impl Problem,
    first: &[bool],
    bounds: &Bounds,
    sigmas: &[f64],
    most: usize,
) -> Result<Reached, EvaluationError> {
    let n = problem.parameters();
    let (mut residual, mut jacobian) = (DVector::zeros(problem.residuals()), DMatrix::zeros(problem.residuals(), n));
    let mut x = vec![0.0; n];
    for iteration in 1..=most {
        let mut largest = 0.0_f64;
        for turn in [true, false] {
            let own: Vec<usize> = (0..n).filter(|&j| first[j] == turn).collect();
            if own.is_empty() {
                continue;
            }
            problem.evaluate(&x, &mut residual, Some(&mut jacobian))?;
            let columns = jacobian.select_columns(own.iter());
            let room = Bounds {
                lower: own.iter().map(|&j| bounds.lower[j] - x[j]).collect(),
                upper: own.iter().map(|&j| bounds.upper[j] - x[j]).collect(),
            };
            let step = crate::least_squares::minimize_in_box(&columns, &residual, &room)
                .map_err(|error| EvaluationError(error.to_string()))?;
            for (k, &j) in own.iter().enumerate() {
                x[j] += step[k];
                largest = largest.max(step[k].abs() / sigmas[j]);
            }
        }
        if largest < STEP * 1e2 {
            return Ok(Reached { x, iterations: iteration, converged: true });
        }
    }
    Ok(Reached { x, iterations: most, converged: false })
}
