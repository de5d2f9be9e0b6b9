//! Calibration of a robot's geometry and stiffness from a campaign, stage by stage: base and tool are registered, what the
//! readings cannot separate is merged, the kept parameters are fitted, and the result is judged on readings held out.
//!
//! Sources: IR663 calibration paper (reduction, equivalent springs); KR-270 paper (weights by direction, predicted errors).

use super::bounds::bounds_of;
use super::covariance::Covariance;
use super::dropped::at_solution;
use super::equivalence::{Equivalence, SpringGroup, moves};
use super::fit::{Fit, fit};
use super::problem::{CampaignProblem, LEAST_SIGMA, Prior, row_sigmas};
use super::reduction::reduced;
use super::registration::{arrangement, rough};
use super::result::{Calibration, CalibrationError, Estimate, Figures, PredictedError};
use super::robust;
use super::selection::Selection;
use super::settings::{Scheme, Settings, Weights, loss_fault};
use super::shared::Sharing;
use super::statistics::errors_of;
use indexmap::IndexMap;
use nalgebra::{DMatrix, DVector};

use crate::description::campaign::{Campaign, Reading};
use crate::description::raw::RawFit;
use crate::least_squares::{Bounds, Loss, Problem, Progress};
use crate::math::mean_rms_max;
use crate::math::quantiles::t95;
use crate::model::Model;
use crate::parameter::{Group, Kind, Slot};
use crate::prediction::{ConfigurationError, ConfigurationErrors, Linearised, NoiseParts, PredictionError, Predictor};

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

/// Calibrates as [`super::calibrate_as_weighed`] does, springs that end at a bound left there.
///
/// # Errors
/// As [`super::calibrate`].
pub(super) fn calibrate_as_asked(
    request: Request,
    progress: &mut dyn FnMut(&Progress),
) -> Result<Calibration, CalibrationError> {
    calibrate_from(None, request, progress)
}

/// The same begun, and reduced, at other values (by slot) than those of the registered description.
///
/// # Errors
/// As [`super::calibrate`].
pub(super) fn calibrate_from(
    begin: Option<&[f64]>,
    request: Request,
    progress: &mut dyn FnMut(&Progress),
) -> Result<Calibration, CalibrationError> {
    let Request { model, held_out, settings, .. } = request;
    let task = Task::new(request)?;
    let (before, _) = task.errors(&task.nominal)?;
    let mut start = task.registered()?;
    let (registration, registered) = task.errors(&start)?;
    if let Some(values) = begin {
        start = values.to_vec();
    }
    let mut selection = Selection::new(model, &task.fitted, &task.sigmas, &task.held, settings, &mut start)?;
    let Selected { problem, bounds } = task.problem(&selection, &mut start)?;
    let (found, history) = task.fit(&problem, &bounds, progress)?;
    let covariance = covariance(&task.fitted, &problem, &found);
    let ci95 = covariance.ci95();
    let mut values = problem.values(&found.x);
    let groups = selection.groups.iter().cloned().filter_map(|group| {
        let k = problem.slots().iter().position(|slot| *slot == group.members[0].0)?;
        Some(group.fitted(model, ci95[k], settings.split, &mut values))
    });
    let mut equivalences: Vec<Equivalence> = groups.collect();
    let free = task.back_to_nominal(&selection, &found, &mut values)?;
    equivalences.iter_mut().for_each(|group| group.value = group.springs.of(model, &values));
    let fitted = Fitted { covariance: &covariance, at_bound: &free, logarithms: problem.logarithms() };
    let (after, residual) = task.errors(&values)?;
    let direction_noise = task.direction_noise(&residual);
    let open = task.second_order(&mut selection, &values)?;
    let (predicted, configurations) = task.predicted_error(problem.slots(), &values, &covariance, &residual)?;
    Ok(Calibration {
        fit: task.carried(problem.slots(), &covariance, direction_noise),
        estimates: task.estimates(&selection, &values, &fitted, &open)?,
        predicted,
        configurations,
        slots: selection.predictor.slots,
        identifiability: selection.identifiability,
        values,
        equivalences,
        correlation: covariance.correlation(),
        before,
        registration,
        after,
        noise_ratio: covariance.noise_ratio,
        degrees_of_freedom: covariance.freedom,
        shared: covariance.shared,
        direction_noise,
        iterations: found.iterations,
        history,
        ending: found.status,
        residual,
        registered,
        held_out: held_out.to_vec(),
    })
}

/// Greatest change of a reading, in its standard deviations, that no campaign shows: a hundred thousand readings together would
/// show it by three.
const UNSEEN: f64 = 0.01;

/// What was asked, checked.
pub(super) struct Task<'a> {
    model: &'a Model,
    campaign: &'a Campaign,
    held_out: &'a [bool],
    settings: &'a Settings,
    /// Readings to be fitted, and the standard deviation of each of their rows (m, rad).
    fitted: Campaign,
    sigmas: Vec<f64>,
    /// Parameters to be held.
    held: Vec<Slot>,
    /// Values of the description, by slot.
    pub(super) nominal: Vec<f64>,
    /// Of all readings, fitted or not.
    everything: Predictor<'a>,
}

/// What a fit tells of its parameters.
struct Fitted<'t> {
    covariance: &'t Covariance,
    at_bound: &'t [bool],
    logarithms: &'t [bool],
}

/// The fit of the kept parameters, and their bounds.
struct Selected<'t> {
    problem: CampaignProblem<'t>,
    bounds: Bounds,
}

impl<'a> Task<'a> {
    /// The fit, its Jacobian by the parameters themselves, and its course: root mean square residual by accepted step.
    fn fit(
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
    fn second_order(&self, selection: &mut Selection, values: &[f64]) -> Result<Vec<f64>, CalibrationError> {
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
            let message = "a robust loss needs the batch scheme; the iterative schemes of the papers know squares only";
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
        let mut found = Linearised::default();
        self.everything.linearise(values, false, &mut found)?;
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
    fn problem(&self, selection: &Selection, start: &mut [f64]) -> Result<Selected<'_>, CalibrationError> {
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
        let mut found = Linearised::default();
        Predictor::new(self.model, &self.fitted, Vec::new())?.linearise(&values, false, &mut found)?;
        // By kind of reading and component.
        let mut by_component: IndexMap<(&str, usize), Vec<f64>> = IndexMap::new();
        let readings = || self.fitted.by_reading(&found.residual, 1);
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

    /// Standard deviation of the fitted residuals of each direction, m: of positions, or of single lengths where none is read.
    fn direction_noise(&self, residual: &[f64]) -> [f64; 3] {
        let lengths = self.campaign.readings.iter().map(|reading| reading.observes.length_rows());
        self.noise_of_lengths(residual, lengths.max().unwrap_or(0))
    }

    /// Standard deviation of the fitted residuals of readings with so many lengths, m.
    fn noise_of_lengths(&self, residual: &[f64], lengths: usize) -> [f64; 3] {
        std::array::from_fn(|k| {
            let readings = self.campaign.by_reading(residual, 1).zip(self.held_out);
            let fitted = readings.filter(|(_, held_out)| !**held_out).map(|(reading, _)| reading);
            let alike = fitted.filter(|(reading, _)| lengths > k && reading.observes.length_rows() == lengths);
            mean_rms_max(alike.map(|(_, own)| own[k]))[1]
        })
    }

    /// Puts springs that a fit left at a bound back to what is declared where that moves no reading: no reading tells them. Which
    /// kept parameters are at a bound then.
    fn back_to_nominal(
        &self,
        selection: &Selection,
        found: &Fit,
        values: &mut Vec<f64>,
    ) -> Result<Vec<bool>, CalibrationError> {
        let mut at_bound = found.at_bound.clone();
        let sigmas = row_sigmas(self.campaign);
        let predicted = |values: &[f64]| -> Result<Vec<f64>, PredictionError> {
            let mut found = Linearised::default();
            self.everything.linearise(values, false, &mut found)?;
            Ok(found.residual)
        };
        for (k, slot) in selection.kept().into_iter().enumerate() {
            if !at_bound[k] || self.model.registry[slot].group != Group::Elastic {
                continue;
            }
            let group = selection.groups.iter().find(|group| group.members[0].0 == slot);
            let members =
                group.map_or_else(|| vec![slot], |group| group.members.iter().map(|(slot, _)| *slot).collect());
            let mut declared = values.clone();
            members.iter().for_each(|&slot| declared[slot] = self.nominal[slot]);
            let (now, then) = (predicted(values)?, predicted(&declared)?);
            let moved = now.iter().zip(&then).zip(&sigmas).map(|((a, b), sigma)| (a - b).abs() / sigma);
            if moved.fold(0.0, f64::max) < UNSEEN {
                *values = declared;
                at_bound[k] = false;
            }
        }
        Ok(at_bound)
    }

    /// Results of all candidates.
    fn estimates(
        &self,
        selection: &Selection,
        values: &[f64],
        &Fitted { covariance, at_bound, logarithms }: &Fitted,
        open: &[f64],
    ) -> Result<Vec<Estimate>, CalibrationError> {
        let slots = &selection.predictor.slots;
        let mut last = Linearised::default();
        selection.predictor.linearise(values, true, &mut last)?;
        let moves = moves(&self.fitted, &last.jacobian, slots, values);
        // Of readings and of what dropped parameters leave open, which is as good as known (Welch and Satterthwaite).
        let width = |k: usize| {
            let own = covariance.matrix[(k, k)].max(0.0).sqrt();
            let sigma = own.hypot(open.get(k).copied().unwrap_or(0.0));
            let degrees_of_freedom = covariance.degrees_of_freedom[k] * (sigma / own.max(f64::MIN_POSITIVE)).powi(4);
            let degrees_of_freedom = degrees_of_freedom.clamp(1.0, f64::MAX);
            (t95(degrees_of_freedom) * sigma, degrees_of_freedom)
        };
        let estimate = |(column, (&slot, moves)): (usize, (&Slot, f64))| {
            let position = selection.identifiability.kept.binary_search(&column).ok();
            let (ci95, degrees_of_freedom) = position.map(width).unzip();
            let value = values[slot];
            let of_factors = |ci95: f64| [-1.0, 1.0].map(|side| value * (side * ci95 / value).exp());
            let interval = ci95.filter(|_| position.is_some_and(|k| logarithms[k]) && value > 0.0).map(of_factors);
            Estimate {
                slot,
                nominal: self.nominal[slot],
                value,
                ci95,
                interval,
                of_dropped: position.and_then(|k| open.get(k).copied()).filter(|open| *open > 0.0),
                degrees_of_freedom: degrees_of_freedom.unwrap_or(0.0),
                at_bound: position.is_some_and(|k| at_bound[k]),
                moves: (self.model.registry[slot].group == Group::Elastic).then_some(moves),
            }
        };
        Ok(slots.iter().zip(moves).enumerate().map(estimate).collect())
    }

    /// What a description carries of the covariance: base, scale and what belongs to sessions and contacts are no part of it,
    /// nor what dropped parameters leave open in second order, which moves the kept ones so that positions stay.
    fn carried(&self, kept: &[Slot], covariance: &Covariance, direction_noise: [f64; 3]) -> RawFit {
        let (model, arranged) = (self.model, arrangement(self.model, self.campaign));
        let markers = model.markers.iter().map(|marker| marker.slot..marker.slot + 3);
        let points: Vec<_> = markers.chain(std::iter::once(model.tool.1..model.tool.1 + 6)).collect();
        let belongs = |slot: &Slot| !arranged.contains(slot) || points.iter().any(|own| own.contains(slot));
        let own: Vec<usize> = (0..kept.len()).filter(|&k| belongs(&kept[k])).collect();
        let rows = own.iter().enumerate();
        // Residuals of the stated noise scatter themselves: their variance by sqrt(2 / n), of which 5 % exceed 1.64.
        let excess = covariance.noise_ratio.powi(2) - 1.0;
        let is_noise = self.campaign.sigma.is_some() && excess < 1.64 * (2.0 / covariance.freedom).sqrt();
        let noise = if is_noise { [f64::INFINITY; 3] } else { self.campaign.sigma.unwrap_or_default() };
        RawFit {
            parameters: own.iter().map(|&k| model.registry[kept[k]].name.clone()).collect(),
            covariance: rows
                .map(|(at, &row)| own[..=at].iter().map(|&column| covariance.matrix[(row, column)]).collect())
                .collect(),
            unexplained: std::array::from_fn(|k| (direction_noise[k].powi(2) - noise[k].powi(2)).max(0.0).sqrt()),
        }
    }

    /// Position error of the held-out readings that the covariance predicts, of all together and of each configuration (KR-270
    /// paper, Tables X, XII).
    fn predicted_error(
        &self,
        kept: &[Slot],
        values: &[f64],
        covariance: &Covariance,
        residual: &[f64],
    ) -> Result<(Option<PredictedError>, Vec<ConfigurationError>), CalibrationError> {
        let check = self.campaign.select(|i, _| self.held_out[i]);
        if check.readings.is_empty() {
            return Ok((None, Vec::new()));
        }
        let mut found = Linearised::default();
        Predictor::new(self.model, &check, kept.to_vec())?.linearise(values, true, &mut found)?;
        let predicted = self.predicted_rms(&check, &found.jacobian, covariance, residual);
        let of_rows = self.noise_by_direction(covariance, residual);
        let errors = ConfigurationErrors {
            jacobian: &found.jacobian,
            covariance: &covariance.matrix,
            freedom: covariance.shared.map_or(covariance.freedom, |shared| shared.between.min(covariance.freedom)),
        };
        let part = covariance.shared.map_or(0.0, |of| of.shared.powi(2) / (of.shared.powi(2) + of.own.powi(2)));
        let mut configurations = errors.of(&check, &found.residual, |reading| {
            let sigmas = reading.observes.sigmas(&reading.noise);
            std::array::from_fn(|k| {
                let variance = of_rows[k] * sigmas[k].powi(2);
                NoiseParts { own: (1.0 - part) * variance, shared: part * variance }
            })
        });
        let held_out: Vec<usize> = (0..self.held_out.len()).filter(|&index| self.held_out[index]).collect();
        for index in configurations.iter_mut().flat_map(|of| &mut of.readings) {
            *index = held_out[*index];
        }
        Ok((predicted, configurations))
    }

    /// Root mean square error of the lengths held out that the covariance predicts; angles and torques have no part in it. `None`
    /// where none is held out.
    fn predicted_rms(
        &self,
        check: &Campaign,
        jacobian: &[f64],
        covariance: &Covariance,
        residual: &[f64],
    ) -> Option<PredictedError> {
        let width = covariance.matrix.nrows().max(1);
        let noise: [f64; 4] = std::array::from_fn(|lengths| {
            self.noise_of_lengths(residual, lengths).iter().map(|sigma| sigma * sigma).sum()
        });
        let (mut count, mut of_parameters, mut of_noise) = (0.0, 0.0, 0.0);
        for (reading, own) in check.by_reading(jacobian, width) {
            let lengths = reading.observes.length_rows().min(3);
            if lengths == 0 {
                continue;
            }
            count += 1.0;
            of_parameters += own.chunks(width).take(lengths).map(|row| covariance.variance(row)).sum::<f64>();
            of_noise += noise[lengths];
        }
        (count > 0.0).then(|| PredictedError {
            parameters: (of_parameters / count).sqrt(),
            with_noise: ((of_parameters + of_noise) / count).sqrt(),
        })
    }

    /// Variance of the noise along x, y, z over the stated one, as the fitted residuals show it.
    fn noise_by_direction(&self, covariance: &Covariance, residual: &[f64]) -> [f64; 3] {
        let used = (covariance.freedom + covariance.matrix.nrows() as f64) / covariance.freedom;
        std::array::from_fn(|k| {
            let readings = self.campaign.by_reading(residual, 1).zip(self.held_out);
            let fitted = readings.filter(|(_, held_out)| !**held_out).map(|(reading, _)| reading);
            let along = fitted.filter(|(reading, _)| reading.observes.length_rows() == 3);
            used * mean_rms_max(along.map(|(of, own)| own[k] / of.observes.sigmas(&of.noise)[k]))[1].powi(2)
        })
    }
}

/// Covariance of a fit to `fitted`: copies of readings add nothing, readings of one configuration may share errors.
fn covariance(fitted: &Campaign, problem: &CampaignProblem, found: &Fit) -> Covariance {
    let copies = fitted.copies();
    let is_copy = |index: usize| copies.get(index).is_some_and(Option::is_some);
    let once = fitted.select(|index, _| !is_copy(index));
    let of = |residual: &DVector<f64>, jacobian: &DMatrix<f64>, weights: &DVector<f64>| {
        let covariance = Covariance::new(residual, jacobian, weights, problem.priors());
        match Sharing::of(&once) {
            Some(sharing) => covariance.sharing(residual, jacobian, weights, &sharing),
            None => covariance,
        }
    };
    if once.readings.len() == fitted.readings.len() {
        return of(&found.residual, &found.jacobian, &found.weights);
    }
    let readings = fitted.readings.iter().enumerate();
    let copied = readings.flat_map(|(index, reading)| std::iter::repeat_n(is_copy(index), reading.observes.rows()));
    let rows: Vec<usize> = copied
        .chain(std::iter::repeat(false))
        .take(found.residual.len())
        .enumerate()
        .filter_map(|(row, copied)| (!copied).then_some(row))
        .collect();
    of(&found.residual.select_rows(&rows), &found.jacobian.select_rows(&rows), &found.weights.select_rows(&rows))
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
