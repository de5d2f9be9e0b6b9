//! A start for what gives, however far off the description is.
//!
//! Deflections are nearly linear in compliances, but not in a spring side by side with a joint: its rate and its free
//! length enter as a product, and one that is far too stiff hides the joint. So springs are left out at first, then their
//! rates found for a few free lengths, and only then all is free.

use super::observation::{Observation, reduced};
use super::problem::CampaignProblem;
use super::result::CalibrationError;
use crate::identifiability::{Criterion, DEFAULT_TOLERANCE, Scaling, Why};
use crate::kinematics::{Geometry, Placements};
use crate::least_squares::{self, Bounds};
use crate::parameter::{Kind, Slot};
use crate::prediction::{Linearised, PredictionError, Predictor};

/// Orders of magnitude tried on either side of the description's springs.
const DECADES: i32 = 4;
/// Free lengths tried, as parts of the mean length of the spring over the campaign.
const LENGTHS: [f64; 4] = [0.3, 0.6, 0.9, 1.2];

/// Moves `start` to where the fit of the predictor's springs, those `held` left out, cannot go astray.
pub fn elastic_start(
    predictor: &Predictor,
    sigmas: &[f64],
    held: &[Slot],
    start: &mut Vec<f64>,
    settings: &least_squares::Settings,
) -> Result<(), CalibrationError> {
    let registry = &predictor.model.registry;
    let free = |wanted: &dyn Fn(Slot) -> bool| -> Vec<Slot> {
        predictor.slots.iter().copied().filter(|slot| wanted(*slot) && !held.contains(slot)).collect()
    };
    let kind = |slot: Slot| registry[slot].kind;
    let series = free(&|slot| matches!(kind(slot), Kind::LinearCompliance | Kind::RotationalCompliance));
    let parallel = free(&|slot| matches!(kind(slot), Kind::LinearStiffness | Kind::RotationalStiffness));
    let springs = &predictor.model.structure.springs;
    let lengths = free(&|slot| springs.iter().any(|spring| spring.slots[1] == slot));
    if parallel.is_empty() && lengths.is_empty() {
        scale(predictor, sigmas, &series, start)?;
        return Ok(());
    }
    let given = start.clone();
    parallel.iter().for_each(|&slot| start[slot] = registry[slot].bounds[0]);
    scale(predictor, sigmas, &series, start)?;
    let (alone, mut best) = fit(predictor, sigmas, &series, start, settings)?;
    *start = alone;
    let mut starts = vec![start.clone()];
    if !lengths.is_empty() {
        let means = mean_lengths(predictor, start)?;
        starts.extend(LENGTHS.iter().map(|part| {
            let mut trial = start.clone();
            for (spring, mean) in springs.iter().zip(&means).filter(|(spring, _)| lengths.contains(&spring.slots[1])) {
                trial[spring.slots[1]] = part * mean;
            }
            trial
        }));
    }
    let both = [&series[..], &parallel[..]].concat();
    let all = [&both[..], &lengths[..]].concat();
    for mut trial in starts {
        parallel.iter().for_each(|&slot| trial[slot] = given[slot]);
        scale(predictor, sigmas, &parallel, &mut trial)?;
        let (found, _) = fit(predictor, sigmas, &both, &trial, settings)?;
        let (found, cost) = fit(predictor, sigmas, &all, &found, settings)?;
        if cost < best {
            (*start, best) = (found, cost);
        }
    }
    Ok(())
}

/// Multiplies springs by the power of ten that fits best: a start that is far off all round then costs nothing.
fn scale(predictor: &Predictor, sigmas: &[f64], springs: &[Slot], start: &mut [f64]) -> Result<(), PredictionError> {
    if springs.is_empty() {
        return Ok(());
    }
    let registry = &predictor.model.registry;
    let scaled = |slot: Slot, value: f64, decade: i32| {
        (value * 10.0_f64.powi(decade)).clamp(registry[slot].bounds[0], registry[slot].bounds[1])
    };
    let mut found = Linearised::default();
    let mut best = (f64::INFINITY, 0);
    let mut trial = start.to_vec();
    for decade in (0..=DECADES).flat_map(|d| if d == 0 { vec![0] } else { vec![-d, d] }) {
        springs.iter().for_each(|&slot| trial[slot] = scaled(slot, start[slot], decade));
        predictor.linearise(&trial, false, &mut found)?;
        let cost: f64 = found.residual.iter().zip(sigmas).map(|(r, s)| (r / s).powi(2)).sum();
        if cost < best.0 {
            best = (cost, decade);
        }
    }
    springs.iter().for_each(|&slot| start[slot] = scaled(slot, start[slot], best.1));
    Ok(())
}

/// Values and cost of a fit of some parameters alone.
fn fit(
    predictor: &Predictor,
    sigmas: &[f64],
    slots: &[Slot],
    start: &[f64],
    settings: &least_squares::Settings,
) -> Result<(Vec<f64>, f64), CalibrationError> {
    let registry = &predictor.model.registry;
    // What the readings cannot see would run away on rounding, and spoil the statics.
    let all = Predictor::new(predictor.model, predictor.campaign, slots.to_vec())?;
    let Observation { identifiability, .. } =
        reduced(&all, start, sigmas, &[], Scaling::Norm, Criterion::Relative(DEFAULT_TOLERANCE))?;
    let unseen: Vec<usize> =
        identifiability.dropped.iter().filter(|(_, why)| *why == Why::Exact).map(|(column, _)| *column).collect();
    let seen: Vec<Slot> =
        slots.iter().enumerate().filter(|(column, _)| !unseen.contains(column)).map(|(_, slot)| *slot).collect();
    let slots = &seen[..];
    let own = Predictor::new(predictor.model, predictor.campaign, seen.clone())?;
    let problem = CampaignProblem::new(own, start, sigmas.to_vec(), vec![]);
    let side = |k: usize| slots.iter().map(|&slot| registry[slot].bounds[k] - start[slot]).collect();
    let bounds = Bounds { lower: side(0), upper: side(1) };
    let settings = least_squares::Settings { max_iterations: 30, cost_tolerance: 1e-9, ..*settings };
    let solution = least_squares::minimize(&problem, &vec![0.0; slots.len()], &bounds, &settings)?;
    let cost = if solution.cost.is_finite() { solution.cost } else { f64::INFINITY };
    Ok((problem.values(&solution.x), cost))
}

/// Mean length of each spring over the campaign's configurations, m.
fn mean_lengths(predictor: &Predictor, values: &[f64]) -> Result<Vec<f64>, PredictionError> {
    let (campaign, springs) = (predictor.campaign, &predictor.model.structure.springs);
    let geometry = Geometry::new(predictor.model, values)?;
    let mut placements = Placements::default();
    let mut means = vec![0.0; springs.len()];
    for index in 0..campaign.readings.len() {
        geometry.place(campaign.configuration(index), &mut placements)?;
        for (mean, spring) in means.iter_mut().zip(springs) {
            let anchor = |k: usize| {
                let [x, y, z] = [0, 1, 2].map(|axis| values[spring.slots[2 + 3 * k + axis]]);
                placements.frames[spring.spring.bodies[k]] * nalgebra::Point3::new(x, y, z)
            };
            *mean += (anchor(0) - anchor(1)).norm() / campaign.readings.len() as f64;
        }
    }
    Ok(means)
}
