//! What a calibration is asked for, checked, and its steps: registration, what is fitted of what, the fit.

use super::bounds::bounds_of;
use super::dropped::at_solution;
use super::equivalence::SpringGroup;
use super::fit::{Fit, fit};
use super::problem::{CampaignProblem, LEAST_SIGMA, Prior, row_sigmas};
use super::reduction::reduced;
use super::registration::{arrangement, rough};
use super::result::{CalibrationError, Figures};
use super::robust;
use super::selection::Selection;
use super::settings::{Scheme, Settings, Weights, loss_fault};
use super::statistics::errors_of;
use indexmap::IndexMap;

use crate::description::campaign::{Campaign, Reading};
use crate::least_squares::{Bounds, Loss, Problem, Progress};
use crate::math::mean_rms_max;
use crate::model::Model;
use crate::parameter::{Group, Kind, Slot};
use crate::prediction::{PredictionError, Predictor, residuals};

/// What is to be calibrated: a model, on the readings of a campaign that are not held out.
#[derive(Clone, Copy)]
pub(super) struct Request<'a> {
    pub model: &'a Model,
    pub campaign: &'a Campaign,
    /// One mark for each reading.
    pub held_out: &'a [bool],
    pub settings: &'a Settings,
}

impl<'a> Request<'a> {
    /// The same with other settings.
    pub fn with<'s>(self, settings: &'s Settings) -> Request<'s>
    where
        'a: 's,
    {
        Request { settings, ..self }
    }
}

/// What was asked, checked.
pub(super) struct Task<'a> {
    pub(super) model: &'a Model,
    pub(super) campaign: &'a Campaign,
    pub(super) held_out: &'a [bool],
    pub(super) settings: &'a Settings,
    /// Readings to be fitted, and the standard deviation of each of their rows (m, rad).
    pub(super) fitted: Campaign,
    pub(super) sigmas: Vec<f64>,
    /// Parameters to be held.
    pub(super) held: Vec<Slot>,
    /// Values of the description, by slot.
    pub(super) nominal: Vec<f64>,
    /// Of all readings, fitted or not.
    pub(super) everything: Predictor<'a>,
}

/// The fit of the kept parameters, and their bounds.
pub(super) struct Selected<'t> {
    pub problem: CampaignProblem<'t>,
    pub bounds: Bounds,
}

impl<'a> Task<'a> {
    /// The fit, its Jacobian by the parameters themselves, and its course: root mean square residual by accepted step.
    pub(super) fn fit(
        &self,
        problem: &CampaignProblem,
        bounds: &Bounds,
        progress: &mut dyn FnMut(&Progress),
    ) -> Result<(Fit, Vec<f64>), CalibrationError> {
        let mut history = Vec::new();
        let mut noted = |step: &Progress| {
            if step.accepted {
                history.push((2.0 * step.cost / self.sigmas.len().max(1) as f64).sqrt());
            }
            progress(step);
        };
        let mut found = fit(problem, bounds, self.settings, &mut noted)?;
        let scales = problem.scales(&found.x);
        found.jacobian.column_iter_mut().zip(&scales).for_each(|(mut column, scale)| column.scale_mut(scale.recip()));
        Ok((found, history))
    }

    /// What dropped parameters leave open of the kept ones in second order, where that is asked for; the factors of the
    /// selection are then those at the solution.
    pub(super) fn second_order(&self, selection: &mut Selection, values: &[f64]) -> Result<Vec<f64>, CalibrationError> {
        if !self.settings.second_order {
            return Ok(Vec::new());
        }
        let Selection { predictor, identifiability, .. } = &*selection;
        let merged = at_solution(predictor, values, &self.sigmas, &self.held, identifiability)?;
        selection.identifiability.combinations = merged.combinations;
        Ok(merged.second_order)
    }

    pub(super) fn new(request: Request<'a>) -> Result<Self, CalibrationError> {
        let Request { model, campaign, held_out, settings } = request;
        let malformed = |message: String| Err(CalibrationError::Malformed(message));
        if held_out.len() != campaign.readings.len() {
            let (found, expected) = (held_out.len(), campaign.readings.len());
            return malformed(format!("{found} marks of readings held out for {expected} readings"));
        }
        if settings.scheme != Scheme::Batch && settings.loss != Loss::Squares {
            let message = "a robust loss needs the batch scheme; the iterative schemes of the papers have the quadratic loss only";
            return malformed(message.into());
        }
        if settings.logarithms && settings.scheme != Scheme::Batch {
            return malformed("logarithms of springs need the batch scheme".into());
        }
        if let Some(fault) = loss_fault(settings.loss) {
            return malformed(fault);
        }
        let mut held = Vec::with_capacity(settings.hold.len());
        for name in &settings.hold {
            match model.registry.slot(name) {
                Some(slot) => held.push(slot),
                None => return malformed(format!("there is no parameter `{name}` to hold")),
            }
        }
        // Where nothing says how large the robot is, its greatest length does.
        if campaign.lacks_length() {
            held.extend(longest(model));
        }
        let fitted = campaign.select(|i, _| !held_out[i]);
        let sigmas = match settings.weights {
            Weights::Stated | Weights::Direction => row_sigmas(&fitted),
            // All axes alike; an orientation keeps its own unit's noise.
            Weights::Equal => {
                let mut alike = fitted.clone();
                for Reading { noise, .. } in &mut alike.readings {
                    noise.position = [noise.position.into_iter().fold(f64::INFINITY, f64::min); 3];
                }
                row_sigmas(&alike)
            }
        };
        let everything = Predictor::new(model, campaign, Vec::new())?;
        let nominal = model.registry.nominal();
        Ok(Self { model, campaign, held_out, settings, fitted, sigmas, held, nominal, everything })
    }

    /// Errors and residuals of all readings at some values.
    pub(super) fn errors(&self, values: &[f64]) -> Result<(Figures, Vec<f64>), PredictionError> {
        let found = self.everything.linearised(values)?;
        let of = |held_out: bool| errors_of(self.campaign, &found.residual, |i| self.held_out[i] == held_out);
        Ok((Figures { fit: of(false), check: of(true) }, found.residual))
    }

    /// A plain fit of `slots` from `start`: all values at its end.
    fn quick_fit(&self, slots: Vec<Slot>, start: &[f64], bounds: &Bounds) -> Result<Vec<f64>, CalibrationError> {
        let predictor = Predictor::new(self.model, &self.fitted, slots)?;
        let problem = CampaignProblem::new(predictor, start, self.sigmas.clone(), vec![]);
        let solution =
            robust::minimize(&problem, bounds, &self.settings.least_squares(problem.residuals()), &mut |_| {})?;
        Ok(problem.values(&solution.x))
    }

    /// All values with base, tool and markers fitted and the robot as described. What the readings hardly show of them
    /// stays as described: it would run away. What they cannot tell from others stays where the search put it: those
    /// others would take up its difference, and with errors of the geometry they do so to first order only.
    pub(super) fn registered(&self) -> Result<Vec<f64>, CalibrationError> {
        let mut start = rough(self.model, &self.fitted, &self.nominal, &self.settings.registration)?;
        self.held.iter().for_each(|&slot| start[slot] = self.nominal[slot]);
        let slots = arrangement(self.model, &self.fitted);
        if slots.is_empty() {
            return Ok(start);
        }
        let predictor = Predictor::new(self.model, &self.fitted, slots.clone())?;
        let (scaling, criterion) = (self.settings.scaling, self.settings.criterion);
        let shown = |values: &[f64]| reduced(&predictor, values, &self.sigmas, &self.held, scaling, criterion);
        let mut found = shown(&start)?.identifiability;
        // Which directions show depends on where base and tool are: once more from there.
        for _ in 0..2 {
            let merged: Vec<usize> = found.merged().collect();
            let others = found.dropped.iter().map(|(column, _)| *column).filter(|column| !merged.contains(column));
            others.for_each(|column| start[slots[column]] = self.nominal[slots[column]]);
            let fitted: Vec<Slot> = found.kept.iter().map(|&column| slots[column]).collect();
            let bounds = Bounds::none(fitted.len());
            start = self.quick_fit(fitted, &start, &bounds)?;
            let now = shown(&start)?.identifiability;
            if now.kept == found.kept {
                break;
            }
            found = now;
        }
        Ok(start)
    }

    /// The problem of fitting the kept parameters; groups of springs are gathered in `start`.
    pub(super) fn problem(&self, selection: &Selection, start: &mut [f64]) -> Result<Selected<'_>, CalibrationError> {
        let kept = selection.kept();
        let rows = self.fitted.rows();
        // As many parameters as residuals would fit anything and leave nothing to judge the noise by.
        if !self.settings.prior && kept.len() >= rows {
            return Err(CalibrationError::TooFew { rows, parameters: kept.len() });
        }
        let priors = if self.settings.prior { self.priors(&kept, start) } else { Vec::new() };
        let sigmas = match self.settings.weights {
            Weights::Direction => self.direction_sigmas(&kept, start)?,
            Weights::Stated | Weights::Equal => self.sigmas.clone(),
        };
        let allowed = |group: &SpringGroup| (group.members[0].0, group.gather(self.model, start));
        let gathered: Vec<(Slot, [f64; 2])> = selection.groups.iter().map(allowed).collect();
        let mut bounds = bounds_of(self.model, &kept, start);
        for (slot, [low, high]) in gathered {
            if let Some(k) = kept.iter().position(|kept| *kept == slot) {
                (bounds.lower[k], bounds.upper[k]) = (low - start[slot], high - start[slot]);
            }
        }
        let predictor = Predictor::new(self.model, &self.fitted, kept)?;
        let problem = CampaignProblem::new(predictor, start, sigmas, priors);
        let problem = if self.settings.logarithms { problem.in_logarithms(&mut bounds) } else { problem };
        Ok(Selected { problem, bounds })
    }

    /// Geometric parameters are expected within their tolerance of the description; base, tool and springs are not.
    fn priors(&self, kept: &[Slot], start: &[f64]) -> Vec<Prior> {
        let registry = &self.model.registry;
        let geometric = kept.iter().enumerate().filter(|&(_, &slot)| registry[slot].group == Group::Geometry);
        let prior = |(column, &slot): (usize, &Slot)| Prior {
            column,
            expected: self.nominal[slot] - start[slot],
            sigma: registry[slot].tolerance,
        };
        geometric.map(prior).collect()
    }

    /// Standard deviation of each row from the residuals of a first fit, one for each direction.
    fn direction_sigmas(&self, kept: &[Slot], start: &[f64]) -> Result<Vec<f64>, CalibrationError> {
        let values = self.quick_fit(kept.to_vec(), start, &bounds_of(self.model, kept, start))?;
        let found = residuals(self.model, &self.fitted, &values)?;
        // By kind of reading and component.
        let mut by_component: IndexMap<(&str, usize), Vec<f64>> = IndexMap::new();
        let readings = || self.fitted.by_reading(&found, 1);
        for (reading, own) in readings() {
            for (k, residual) in own.iter().enumerate() {
                by_component.entry((reading.observes.name(), k)).or_default().push(*residual);
            }
        }
        let sigmas: IndexMap<_, f64> =
            by_component.into_iter().map(|(of, all)| (of, mean_rms_max(all.into_iter())[1].max(LEAST_SIGMA))).collect();
        let of_readings =
            readings().flat_map(|(reading, own)| (0..own.len()).map(|k| sigmas[&(reading.observes.name(), k)]));
        Ok(of_readings.chain(self.fitted.constraints.iter().map(|constraint| constraint.sigma)).collect())
    }
}

/// The greatest length among the free constants of the robot.
fn longest(model: &Model) -> Option<Slot> {
    let size = |slot: &Slot| model.registry[*slot].nominal.abs();
    let lengths = model
        .free_slots()
        .into_iter()
        .filter(|slot| model.registry[*slot].group == Group::Geometry && model.registry[*slot].kind == Kind::Length);
    lengths.max_by(|a, b| size(a).total_cmp(&size(b)))
}
