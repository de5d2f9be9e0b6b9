//! Calibration of a robot's geometry and stiffness from a campaign.

use nalgebra::{DMatrix, DVector};

use super::equivalence::{groups, moves};
use super::observation::{Observation, candidates, reduced};
use super::problem::{CampaignProblem, row_sigmas};
use super::registration::{arrangement, rough};
use super::result::{Calibration, CalibrationError, Comparison, Estimate, Figures};
use super::schemes::{alternating, pose_by_pose};
use super::settings::{Scheme, Settings, Weights, What};
use super::start::elastic_start;
use super::statistics::errors_of;
use crate::description::campaign::Campaign;
use crate::least_squares::{self, Bounds, Loss, Problem, Progress};
use crate::math::linear::cofactor;
use crate::math::mean_rms_max;
use crate::math::quantiles::t95;
use crate::model::Model;
use crate::parameter::{Group, Slot};
use crate::prediction::{Linearised, Predictor};

/// Calibrates `model` on the readings of `campaign` that are not set `aside`.
///
/// # Errors
/// [`CalibrationError`]; a fit that merely converges badly is no error but says so in [`Calibration::ending`].
pub fn calibrate(
    model: &Model,
    campaign: &Campaign,
    aside: &[bool],
    settings: &Settings,
    progress: &mut dyn FnMut(&Progress),
) -> Result<Calibration, CalibrationError> {
    if aside.len() != campaign.readings.len() {
        let (found, expected) = (aside.len(), campaign.readings.len());
        return Err(CalibrationError::Malformed(format!(
            "{found} marks of readings set aside for {expected} readings"
        )));
    }
    if let Some(name) = settings.hold.iter().find(|name| model.registry.slot(name).is_none()) {
        return Err(CalibrationError::Malformed(format!("there is no parameter `{name}` to hold")));
    }
    if settings.scheme != Scheme::Batch && settings.loss != Loss::Squares {
        let message = "a robust loss needs the batch scheme; the iterative schemes of the papers know squares only";
        return Err(CalibrationError::Malformed(message.into()));
    }
    let fit = campaign.select(|i, _| !aside[i]);
    let nominal = model.registry.nominal();
    let everything = Predictor::new(model, campaign, Vec::new())?;
    let figures = |values: &[f64]| -> Result<(Figures, Vec<f64>), CalibrationError> {
        let mut found = Linearised::default();
        everything.linearise(values, false, &mut found)?;
        let fit = errors_of(campaign, &found.residual, |i| !aside[i]);
        let check = errors_of(campaign, &found.residual, |i| aside[i]);
        Ok((Figures { fit, check }, found.residual))
    };
    let (before, _) = figures(&nominal)?;

    let sigmas = match settings.weights {
        Weights::Stated | Weights::Direction => row_sigmas(&fit),
        // All axes alike; an orientation keeps its own unit's noise.
        Weights::Equal => {
            let alike = fit.sigma.map(|axes| [axes.into_iter().fold(f64::INFINITY, f64::min); 3]);
            row_sigmas(&Campaign { sigma: alike, ..fit.clone() })
        }
    };
    let held: Vec<Slot> = settings.hold.iter().filter_map(|name| model.registry.slot(name)).collect();
    let arrangement = arrangement(model, &fit);
    let mut start = rough(model, &fit, &nominal)?;
    held.iter().for_each(|&slot| start[slot] = nominal[slot]);
    let moving: Vec<Slot> = arrangement.iter().copied().filter(|slot| !held.contains(slot)).collect();
    if !moving.is_empty() {
        let problem =
            CampaignProblem::new(Predictor::new(model, &fit, moving.clone())?, &start, sigmas.clone(), vec![]);
        let bounds = Bounds::none(moving.len());
        let solution = least_squares::minimize(&problem, &vec![0.0; moving.len()], &bounds, &least(settings))?;
        start = problem.values(&solution.x);
    }
    let (registration, registered) = figures(&start)?;

    let what = settings.what.unwrap_or_else(|| What::usual(campaign));
    let slots = match &settings.only {
        Some(only) => arrangement_first(model, &fit, only),
        None => candidates(model, &fit, what)?,
    };
    let predictor = Predictor::new(model, &fit, slots)?;
    if settings.only.is_none() {
        elastic_start(&predictor, &sigmas, &held, &mut start, &least(settings))?;
    }
    let Observation { slots, identifiability } =
        reduced(&predictor, &start, &sigmas, &held, settings.scaling, settings.criterion)?;
    let kept: Vec<Slot> = identifiability.kept.iter().map(|&column| slots[column]).collect();
    let mut equivalences = groups(&predictor, &start, &identifiability)?;
    // As many parameters as residuals would fit anything and leave nothing to judge the noise by.
    if !settings.prior && kept.len() >= fit.readings.len() * fit.components() {
        return Err(CalibrationError::TooFew { rows: fit.readings.len() * fit.components(), parameters: kept.len() });
    }
    let priors: Vec<(f64, f64)> = if settings.prior {
        let prior = |&slot: &Slot| {
            let parameter = &model.registry[slot];
            let sigma = if parameter.group == Group::Geometry { parameter.tolerance } else { 1e3 };
            (nominal[slot] - start[slot], sigma)
        };
        kept.iter().map(prior).collect()
    } else {
        Vec::new()
    };

    let sigmas = if settings.weights == Weights::Direction {
        direction_sigmas(&fit, &first_residual(model, &fit, &kept, &start, sigmas, settings)?)
    } else {
        sigmas
    };
    let gathered: Vec<(Slot, [f64; 2])> =
        equivalences.iter().map(|group| (group.members[0].0, group.gather(model, &mut start))).collect();
    let mut bounds = bounds_of(model, &kept, &start);
    for (slot, [low, high]) in gathered {
        if let Some(k) = kept.iter().position(|kept| *kept == slot) {
            (bounds.lower[k], bounds.upper[k]) = (low - start[slot], high - start[slot]);
        }
    }
    let problem = CampaignProblem::new(Predictor::new(model, &fit, kept.clone())?, &start, sigmas, priors.clone());
    let outcome = run(&problem, &fit, model, &bounds, settings, progress)?;
    let mut values = problem.values(&outcome.x);

    let data_rows = fit.readings.len() * fit.components();
    let weights: Vec<f64> = outcome.weights.iter().copied().collect();
    let degrees = (weights.iter().take(data_rows).filter(|w| **w > 1e-3).count() as f64 + priors.len() as f64
        - kept.len() as f64)
        .max(1.0);
    let squares: f64 = outcome.residual.iter().zip(&weights).map(|(r, w)| w * r * r).sum();
    let noise_ratio = (squares / degrees).sqrt();
    let weighted =
        DMatrix::from_fn(outcome.jacobian.nrows(), kept.len(), |i, j| outcome.jacobian[(i, j)] * weights[i].sqrt());
    // Data are as noisy as they show themselves to be, and tolerances, which stand in sigmas, are rescaled with them.
    let covariance = cofactor(&weighted) * noise_ratio.powi(2);
    let quantile = t95(degrees);
    let half_width = |k: usize| quantile * covariance[(k, k)].max(0.0).sqrt();
    for group in &mut equivalences {
        if let Some(k) = kept.iter().position(|slot| *slot == group.members[0].0) {
            group.fitted(model, &values, half_width(k));
            group.split(model, settings.split, &mut values);
        }
    }
    let (after, residual) = figures(&values)?;
    let mut last = Linearised::default();
    predictor.linearise(&values, true, &mut last)?;
    let moves = moves(&fit, &last.jacobian, &slots, &values);
    let estimates = slots
        .iter()
        .enumerate()
        .map(|(column, &slot)| {
            let position = identifiability.kept.binary_search(&column).ok();
            Estimate {
                slot,
                nominal: nominal[slot],
                value: values[slot],
                ci95: position.map_or(f64::NAN, half_width),
                identifiable: position.is_some(),
                at_bound: position.is_some_and(|k| outcome.at_bound[k]),
                moves: if model.registry[slot].group == Group::Elastic { moves[column] } else { f64::NAN },
            }
        })
        .collect();
    let predicted = predicted_error(model, campaign, aside, &kept, &values, &covariance, &residual)?;
    Ok(Calibration {
        values,
        slots,
        identifiability,
        estimates,
        equivalences,
        correlation: correlation(&covariance),
        before,
        registration,
        after,
        predicted,
        noise_ratio,
        direction_noise: direction_noise(campaign, &residual, aside),
        iterations: outcome.iterations,
        ending: outcome.ending,
        converged: outcome.converged,
        residual,
        registered,
    })
}

fn arrangement_first(model: &Model, fit: &Campaign, only: &[Slot]) -> Vec<Slot> {
    let mut slots = arrangement(model, fit);
    slots.extend(only.iter().filter(|slot| !slots.contains(slot)).copied().collect::<Vec<_>>());
    slots
}

fn least(settings: &Settings) -> least_squares::Settings {
    // Deflections are hundreds of sigmas: below this, far less than a thousandth of a standard deviation, rounding of the
    // model is followed and not the data.
    let cost_tolerance = 1e-12;
    let (max_iterations, loss) = (settings.max_iterations, settings.loss);
    least_squares::Settings { max_iterations, loss, cost_tolerance, ..Default::default() }
}

fn bounds_of(model: &Model, kept: &[Slot], start: &[f64]) -> Bounds {
    let side = |k: usize| kept.iter().map(|&slot| model.registry[slot].bounds[k] - start[slot]).collect();
    Bounds { lower: side(0), upper: side(1) }
}

struct Outcome {
    x: Vec<f64>,
    residual: DVector<f64>,
    jacobian: DMatrix<f64>,
    weights: DVector<f64>,
    at_bound: Vec<bool>,
    iterations: usize,
    ending: String,
    converged: bool,
}

fn run(
    problem: &CampaignProblem,
    fit: &Campaign,
    model: &Model,
    bounds: &Bounds,
    settings: &Settings,
    progress: &mut dyn FnMut(&Progress),
) -> Result<Outcome, CalibrationError> {
    let n = problem.parameters();
    let stopped = |error: least_squares::EvaluationError| CalibrationError::Stopped(error.0);
    if settings.scheme == Scheme::Batch {
        let solution = least_squares::minimize_observed(problem, &vec![0.0; n], bounds, &least(settings), progress)?;
        if let least_squares::Status::NoStart(error) = &solution.status {
            return Err(CalibrationError::Stopped(error.0.clone()));
        }
        return Ok(Outcome {
            at_bound: solution.at_bound.iter().map(Option::is_some).collect(),
            iterations: solution.iterations,
            ending: format!("{:?}", solution.status).to_lowercase(),
            converged: solution.status.converged(),
            x: solution.x,
            residual: solution.residual,
            jacobian: solution.jacobian,
            weights: solution.weights,
        });
    }
    let sigmas: Vec<f64> = problem.slots().iter().map(|&slot| model.registry[slot].tolerance).collect();
    let reached = if settings.scheme == Scheme::PoseByPose {
        let components = fit.components();
        let mut blocks: Vec<Vec<usize>> = vec![Vec::new(); fit.poses.len()];
        for (index, reading) in fit.readings.iter().enumerate() {
            blocks[reading.pose].extend(index * components..(index + 1) * components);
        }
        let priors: Vec<usize> = (fit.readings.len() * components..problem.residuals()).collect();
        blocks.retain(|rows| !rows.is_empty());
        if !priors.is_empty() {
            blocks.insert(0, priors);
        }
        pose_by_pose(problem, &blocks, &sigmas, settings.max_iterations).map_err(stopped)?
    } else {
        let first: Vec<bool> =
            problem.slots().iter().map(|&slot| model.registry[slot].group != Group::Geometry).collect();
        alternating(problem, &first, bounds, &sigmas, settings.max_iterations.max(20_000)).map_err(stopped)?
    };
    if let Some(j) = (0..n).find(|&j| reached.x[j] < bounds.lower[j] || reached.x[j] > bounds.upper[j]) {
        let name = &model.registry[problem.slots()[j]].name;
        return Err(CalibrationError::Stopped(format!("pose by pose, `{name}` left its bounds; use the batch scheme")));
    }
    let (mut residual, mut jacobian) = (DVector::zeros(problem.residuals()), DMatrix::zeros(problem.residuals(), n));
    problem.evaluate(&reached.x, &mut residual, Some(&mut jacobian)).map_err(stopped)?;
    let at_bound = (0..n).map(|j| reached.x[j] <= bounds.lower[j] || reached.x[j] >= bounds.upper[j]).collect();
    let ending = if reached.converged { "step" } else { "iterationlimit" };
    Ok(Outcome {
        x: reached.x,
        weights: DVector::repeat(residual.len(), 1.0),
        residual,
        jacobian,
        at_bound,
        iterations: reached.iterations,
        ending: ending.into(),
        converged: reached.converged,
    })
}

/// Residuals of a first fit, from which directions get their noise.
fn first_residual(
    model: &Model,
    fit: &Campaign,
    kept: &[Slot],
    start: &[f64],
    sigmas: Vec<f64>,
    settings: &Settings,
) -> Result<Vec<f64>, CalibrationError> {
    let problem = CampaignProblem::new(Predictor::new(model, fit, kept.to_vec())?, start, sigmas, vec![]);
    let bounds = bounds_of(model, kept, start);
    let solution = least_squares::minimize(&problem, &vec![0.0; kept.len()], &bounds, &least(settings))?;
    let mut found = Linearised::default();
    Predictor::new(model, fit, Vec::new())?.linearise(&problem.values(&solution.x), false, &mut found)?;
    Ok(found.residual)
}

fn direction_sigmas(fit: &Campaign, residual: &[f64]) -> Vec<f64> {
    let components = fit.components();
    let by_component: Vec<f64> = (0..components)
        .map(|k| mean_rms_max(residual.iter().skip(k).step_by(components).copied())[1].max(1e-9))
        .collect();
    by_component.iter().copied().cycle().take(residual.len()).collect()
}

fn direction_noise(campaign: &Campaign, residual: &[f64], aside: &[bool]) -> [f64; 3] {
    let components = campaign.components();
    std::array::from_fn(|k| {
        let of = residual
            .chunks(components)
            .zip(aside)
            .filter(|(_, aside)| !**aside)
            .filter_map(|(r, _)| r[..components.min(3)].get(k));
        mean_rms_max(of.copied())[1]
    })
}

fn correlation(covariance: &DMatrix<f64>) -> DMatrix<f64> {
    let n = covariance.nrows();
    DMatrix::from_fn(n, n, |i, j| {
        covariance[(i, j)] / (covariance[(i, i)] * covariance[(j, j)]).sqrt().max(f64::MIN_POSITIVE)
    })
}

/// Position error of the set-aside readings that the covariance foretells (KR-270 paper, Tables X, XII).
fn predicted_error(
    model: &Model,
    campaign: &Campaign,
    aside: &[bool],
    kept: &[Slot],
    values: &[f64],
    covariance: &DMatrix<f64>,
    residual: &[f64],
) -> Result<Option<[f64; 2]>, CalibrationError> {
    let check = campaign.select(|i, _| aside[i]);
    if check.readings.is_empty() {
        return Ok(None);
    }
    let mut found = Linearised::default();
    Predictor::new(model, &check, kept.to_vec())?.linearise(values, true, &mut found)?;
    let (components, width) = (check.components(), kept.len());
    let position = check.observes.length_rows();
    let mut sum = 0.0;
    for reading in found.jacobian.chunks(components * width.max(1)) {
        for row in reading.chunks(width.max(1)).take(position) {
            let row = DVector::from_column_slice(row);
            sum += (covariance * &row).dot(&row);
        }
    }
    let mean_square = sum / check.readings.len() as f64;
    let noise: f64 = direction_noise(campaign, residual, aside).iter().map(|s| s * s).sum();
    Ok(Some([mean_square.sqrt(), (mean_square + noise).sqrt()]))
}

/// Ordinary and weighted least squares side by side.
///
/// # Errors
/// As [`calibrate`].
pub fn compare(
    model: &Model,
    campaign: &Campaign,
    aside: &[bool],
    settings: &Settings,
) -> Result<Comparison, CalibrationError> {
    let with = |weights| calibrate(model, campaign, aside, &Settings { weights, ..settings.clone() }, &mut |_| {});
    Ok(Comparison { ols: with(Weights::Equal)?, wls: with(Weights::Direction)? })
}
