//! The fit of chosen parameters by the scheme that was asked for.

use nalgebra::{DMatrix, DVector};

use super::problem::CampaignProblem;
use super::result::CalibrationError;
use super::robust;
use super::schemes::{alternating, pose_by_pose};
use super::settings::{Scheme, Settings};
use crate::least_squares::{Bounds, Problem, Progress, Status};
use crate::parameter::Group;

/// Where a fit ended; `n` parameters as changes from the start, `m` residuals in standard deviations.
pub struct Fit {
    /// Changes (n).
    pub x: Vec<f64>,
    /// Residuals, then priors (m).
    pub residual: DVector<f64>,
    /// Their derivative (m x n).
    pub jacobian: DMatrix<f64>,
    /// Robust weights (m).
    pub weights: DVector<f64>,
    /// Which parameters stopped at a bound (n).
    pub at_bound: Vec<bool>,
    pub iterations: usize,
    pub status: Status,
}

/// Fits by the scheme of the settings.
pub fn fit(
    problem: &CampaignProblem,
    bounds: &Bounds,
    settings: &Settings,
    progress: &mut dyn FnMut(&Progress),
) -> Result<Fit, CalibrationError> {
    if settings.scheme != Scheme::Batch {
        return in_turns(problem, bounds, settings);
    }
    let solution = robust::minimize(problem, bounds, &settings.least_squares(problem.residuals()), progress)?;
    Ok(Fit {
        at_bound: solution.at_bound.iter().map(Option::is_some).collect(),
        iterations: solution.iterations,
        status: solution.status,
        x: solution.x,
        residual: solution.residual,
        jacobian: solution.jacobian,
        weights: solution.weights,
    })
}

/// Fits by one of the iterative schemes.
fn in_turns(problem: &CampaignProblem, bounds: &Bounds, settings: &Settings) -> Result<Fit, CalibrationError> {
    let parameters = || problem.slots().iter().map(|&slot| &problem.model().registry[slot]);
    let tolerances: Vec<f64> = parameters().map(|parameter| parameter.tolerance).collect();
    let most = settings.max_iterations.unwrap_or(settings.scheme.iterations());
    let reached = if settings.scheme == Scheme::PoseByPose {
        pose_by_pose(problem, &problem.blocks(), &tolerances, most)
    } else {
        let arrangement: Vec<bool> = parameters().map(|parameter| parameter.group != Group::Geometry).collect();
        alternating(problem, &arrangement, bounds, &tolerances, most)
    };
    let reached = reached?;
    let n = problem.parameters();
    if let Some(j) = (0..n).find(|&j| reached.x[j] < bounds.lower[j] || reached.x[j] > bounds.upper[j]) {
        let name = &problem.model().registry[problem.slots()[j]].name;
        return Err(CalibrationError::LeftBounds(name.clone()));
    }
    let (mut residual, mut jacobian) = (DVector::zeros(problem.residuals()), DMatrix::zeros(problem.residuals(), n));
    problem.evaluate(&reached.x, &mut residual, Some(&mut jacobian))?;
    Ok(Fit {
        at_bound: (0..n).map(|j| reached.x[j] <= bounds.lower[j] || reached.x[j] >= bounds.upper[j]).collect(),
        weights: DVector::repeat(residual.len(), 1.0),
        x: reached.x,
        residual,
        jacobian,
        iterations: reached.iterations,
        status: if reached.converged { Status::Step } else { Status::IterationLimit },
    })
}
