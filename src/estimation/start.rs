//! A start for springs, however far off the description is.
//!
//! Deflections are nearly linear in compliances, but not in a spring parallel to a joint: its rate and its free length enter
//! as a product, and one that is far too stiff hides the joint. So springs between bodies are left out at first, then their
//! rates found for a few free lengths, and only then all are fitted together.

use super::bounds::bounds_of;
use super::problem::CampaignProblem;
use super::reduction::{Reduction, reduced};
use super::result::CalibrationError;
use super::settings::Settings;
use crate::identifiability::{Criterion, DEFAULT_TOLERANCE, Scaling, Why};
use crate::kinematics::{Geometry, Placements};
use crate::least_squares::{self, Loss, Problem, UsageError};
use crate::parameter::Slot;
use crate::prediction::{Linearised, PredictionError, Predictor};

/// Moves `start` to where the fit of the predictor's springs, those `held` left out, cannot go astray. `sigmas` are those of
/// the predictor's rows (m, rad).
pub fn elastic_start(
    predictor: &Predictor,
    sigmas: &[f64],
    held: &[Slot],
    start: &mut Vec<f64>,
    settings: &Settings,
) -> Result<(), CalibrationError> {
    let registry = &predictor.model.registry;
    let free = |wanted: &dyn Fn(Slot) -> bool| -> Vec<Slot> {
        predictor.slots.iter().copied().filter(|slot| wanted(*slot) && !held.contains(slot)).collect()
    };
    let kind = |slot: Slot| registry[slot].kind;
    let series = free(&|slot| kind(slot).is_compliance());
    let parallel = free(&|slot| kind(slot).is_stiffness());
    let springs = &predictor.model.structure.springs;
    let lengths = free(&|slot| springs.iter().any(|spring| spring.slots[1] == slot));
    let search = Search { predictor, sigmas, settings };
    if parallel.is_empty() && lengths.is_empty() {
        search.scale(&series, start)?;
        return Ok(());
    }
    let given = start.clone();
    parallel.iter().for_each(|&slot| start[slot] = registry[slot].bounds[0]);
    search.scale(&series, start)?;
    let (alone, mut best) = search.fit(&series, start)?;
    *start = alone;
    let mut starts = vec![start.clone()];
    if !lengths.is_empty() {
        let means = mean_lengths(predictor, start)?;
        starts.extend(settings.start.lengths.iter().map(|part| {
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
        search.scale(&parallel, &mut trial)?;
        let (found, _) = search.fit(&both, &trial)?;
        let (found, cost) = search.fit(&all, &found)?;
        if cost < best {
            (*start, best) = (found, cost);
        }
    }
    Ok(())
}

/// What every trial fits.
struct Search<'s> {
    predictor: &'s Predictor<'s>,
    sigmas: &'s [f64],
    settings: &'s Settings,
}

impl Search<'_> {
    /// Multiplies springs by the power of ten that fits best: a start that is far off all round then costs nothing.
    fn scale(&self, springs: &[Slot], start: &mut [f64]) -> Result<(), PredictionError> {
        if springs.is_empty() {
            return Ok(());
        }
        let registry = &self.predictor.model.registry;
        let scaled = |slot: Slot, value: f64, decade: i32| {
            (value * 10.0_f64.powi(decade)).clamp(registry[slot].bounds[0], registry[slot].bounds[1])
        };
        let mut found = Linearised::default();
        let mut best = (f64::INFINITY, 0);
        let mut trial = start.to_vec();
        // From the description outwards: of equally good ones the nearest is taken.
        for decade in std::iter::once(0).chain((1..=self.settings.start.decades).flat_map(|decade| [-decade, decade])) {
            springs.iter().for_each(|&slot| trial[slot] = scaled(slot, start[slot], decade));
            self.predictor.linearise(&trial, false, &mut found)?;
            let cost: f64 = found.residual.iter().zip(self.sigmas).map(|(r, s)| (r / s).powi(2)).sum();
            if cost < best.0 {
                best = (cost, decade);
            }
        }
        springs.iter().for_each(|&slot| start[slot] = scaled(slot, start[slot], best.1));
        Ok(())
    }

    /// Values and cost of a fit of some parameters alone.
    fn fit(&self, slots: &[Slot], start: &[f64]) -> Result<(Vec<f64>, f64), CalibrationError> {
        let (model, campaign) = (self.predictor.model, self.predictor.campaign);
        // What the readings do not determine at all would run away on rounding, and spoil the statics.
        let all = Predictor::new(model, campaign, slots.to_vec())?;
        let criterion = Criterion::Relative(DEFAULT_TOLERANCE);
        let Reduction { identifiability, mut slots } =
            reduced(&all, start, self.sigmas, &[], Scaling::Norm, criterion)?;
        let undetermined: Vec<Slot> =
            identifiability.dropped.iter().filter(|(_, why)| *why == Why::Exact).map(|(k, _)| slots[*k]).collect();
        slots.retain(|slot| !undetermined.contains(slot));
        let (bounds, zero) = (bounds_of(model, &slots, start), vec![0.0; slots.len()]);
        let problem =
            CampaignProblem::new(Predictor::new(model, campaign, slots)?, start, self.sigmas.to_vec(), vec![]);
        let limits = least_squares::Settings {
            max_iterations: self.settings.start.max_iterations,
            cost_tolerance: self.settings.start.cost_tolerance,
            // A start only: the fit that follows is robust where that was asked for.
            loss: Loss::Squares,
            ..self.settings.least_squares(problem.residuals())
        };
        match least_squares::minimize(&problem, &zero, &bounds, &limits) {
            Ok(found) => Ok((problem.values(&found.x), found.cost)),
            // Worse than any other trial.
            Err(UsageError::NoStart(_)) => Ok((start.to_vec(), f64::INFINITY)),
            Err(error) => Err(error.into()),
        }
    }
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
