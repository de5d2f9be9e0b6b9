//! One competition: the robot is calibrated, its predictions linearised, and hypotheses selected, without the outliers
//! that are known so far.

use super::choice::choice;
use super::claims::Claim;
use super::free_errors::FreeErrors;
use super::hypothesis::{Hypothesis, hypotheses};
use super::inputs::Inputs;
use super::linear_problem::LinearProblem;
use super::misfit::{Readings, first_readings};
use super::projection::Subset;
use super::refinement::refine;
use super::repeatability::noise;
use super::result::{Excluded, NotTried};
use super::selection::Selector;
use super::untried::{excluded, moves_too_far, not_tried};
use crate::description::campaign::{Campaign, Reading};
use crate::estimation::{self, Calibration, CalibrationError, calibrate_as_weighed};
use crate::kinematics::Geometry;
use crate::least_squares::Status;
use crate::parameter::Slot;
use crate::prediction::{PredictionError, joint_loads, survey};

/// One competition and the hypotheses selected.
pub struct Competition {
    /// The campaign without outliers.
    pub campaign: Campaign,
    /// Which of its readings are not fitted.
    pub held_out: Vec<bool>,
    /// Nuisance parameters that the readings determine.
    pub kept: Vec<Slot>,
    /// Calibrated values.
    pub values: Vec<f64>,
    /// Root mean square error with base and tool fitted alone, m.
    pub registration: Option<f64>,
    /// Whether tolerances pulled the calibration, which did not converge without them.
    pub is_pulled: bool,
    /// The calibration; `None` where nothing is fitted.
    pub calibration: Option<Calibration>,
    /// Noise over the sigmas of the rows: 1 where the campaign states them, else that of repeated readings.
    pub noise: Option<f64>,
    /// The linear problem without outliers.
    pub problem: LinearProblem,
    /// The linear problem of all readings.
    pub all: LinearProblem,
    /// Effects that could not compete.
    pub not_tried: Vec<NotTried>,
    /// Hypotheses that other measurements exclude.
    pub excluded: Vec<Excluded>,
    /// What can be claimed of each cause.
    pub claims: Vec<Claim>,
    /// The subsets selected, from the empty one.
    pub path: Vec<Subset>,
}

impl Competition {
    /// Holds the competition. Where fixed reflectors moved, that the base did competes too; where more of it is found than they moved by,
    /// once more without.
    ///
    /// # Errors
    /// As [`crate::estimation::calibrate`].
    pub fn new(inputs: &Inputs, outliers: &[bool], progress: &mut dyn FnMut(&str)) -> Result<Self, CalibrationError> {
        let found = Self::held(inputs, outliers, false, progress)?;
        match moves_too_far(&found.campaign, &found.problem, &found.claims, found.left()) {
            true => Self::held(inputs, outliers, true, progress),
            false => Ok(found),
        }
    }

    /// Root mean square error that calibration leaves, m.
    fn left(&self) -> f64 {
        self.calibration.as_ref().map_or(0.0, |found| found.after.fit.distance[1])
    }

    /// The competition, `is_fixed` that the base does not move with time even where fixed reflectors moved a little.
    fn held(
        inputs: &Inputs,
        outliers: &[bool],
        is_fixed: bool,
        progress: &mut dyn FnMut(&str),
    ) -> Result<Self, CalibrationError> {
        let (model, settings) = (inputs.model, inputs.settings);
        let campaign = inputs.campaign.select(|i, _| !outliers[i]);
        let held_out = held_out(inputs.held_out, outliers);
        progress("calibrating");
        let is_calibrated = !inputs.nuisance.is_empty() || campaign.estimate_base || campaign.estimate_tool;
        let found = if is_calibrated { Some(calibrated(inputs, &campaign, &held_out)?) } else { None };
        let is_pulled = found.as_ref().is_some_and(|(_, is_pulled)| *is_pulled);
        let calibration = found.map(|(found, _)| found);
        let (values, kept, registration) = match &calibration {
            None => (model.registry.nominal(), Vec::new(), None),
            Some(found) => (found.values.clone(), found.kept_slots(), Some(found.registration.fit.distance[1])),
        };
        progress("linearising");
        let geometry = Geometry::new(model, &values).map_err(PredictionError::from)?;
        let survey = survey(&geometry, &campaign)?;
        let mut tried = hypotheses(model, &values, &kept, &survey, settings);
        fits_memory(&campaign, &tried, kept.len())?;
        let not_tried = not_tried(model, &survey, &tried, &settings.known);
        let left = calibration.as_ref().map_or(0.0, |found| found.after.fit.distance[1]);
        let excluded = excluded(&campaign, left, is_fixed, &mut tried);
        let mut all = LinearProblem::new(model, inputs.campaign, &values, &kept, tried)?.pruned();
        let noise = noise(&campaign, settings.least_repeats);
        progress("comparing hypotheses");
        let unused: Vec<bool> = inputs.held_out.iter().zip(outliers).map(|(held, outlier)| *held || *outlier).collect();
        let found = Selector::new(&all.without(&unused), &settings.selection).search(noise);
        if let Some(last) = found.last() {
            refine(inputs, &values, &survey, &mut all, &last.members, &unused)?;
        }
        let found = found.last().map_or_else(Vec::new, |last| last.members.clone());
        let fitted = campaign.select(|i, _| !held_out.get(i).copied().unwrap_or(false));
        let training = all.without(&unused);
        let free_errors = FreeErrors::new(model, &fitted, &values, &training)?;
        let first = first_readings(&training, &fitted);
        let loads = joint_loads(&geometry, &fitted)?;
        let readings = Readings { campaign: &fitted, first: &first, model, loads: &loads };
        let (claims, path) = choice(settings, &training, readings, &found, noise, &free_errors);
        // With causes that are not claimed a value may have been another one.
        let claimed: Vec<usize> = claims.iter().map(|claim| claim.hypothesis).collect();
        refine(inputs, &values, &survey, &mut all, &claimed, &unused)?;
        let problem = all.without(outliers);
        Ok(Self {
            campaign,
            held_out,
            kept,
            values,
            registration,
            is_pulled,
            calibration,
            noise,
            problem,
            all,
            not_tried,
            excluded,
            claims,
            path,
        })
    }

    /// Whether a wrench is applied in any reading.
    pub fn is_loaded(&self) -> bool {
        self.campaign.readings.iter().any(Reading::is_loaded)
    }

    /// The hypotheses selected, in order.
    pub fn members(&self) -> &[usize] {
        self.path.last().map_or(&[], |fit| &fit.members)
    }
}

/// Megabytes meant for the columns of all hypotheses: with the program and its readings they stay below 400.
const MOST_MEGABYTES: usize = 330;

/// Copies of all columns that are held at one time: of all readings, of those fitted, as they are and projected.
const COPIES: usize = 4;

/// Refuses more readings and hypotheses than fit into [`MOST_MEGABYTES`].
fn fits_memory(campaign: &Campaign, tried: &[Hypothesis], nuisance: usize) -> Result<(), CalibrationError> {
    let rows: usize = campaign.readings.iter().map(|reading| reading.observes.rows()).sum();
    let columns = nuisance + tried.iter().map(|hypothesis| hypothesis.parameters.len()).sum::<usize>();
    let megabytes = (COPIES * rows * columns * size_of::<f64>()).div_ceil(1_000_000);
    match megabytes > MOST_MEGABYTES {
        true => Err(CalibrationError::TooMuch { megabytes, most: MOST_MEGABYTES }),
        false => Ok(()),
    }
}

/// The nuisance parameters calibrated. What no model of the catalogue explains yet can push a fit along directions that the
/// readings hardly show, without end: there the tolerances of the description pull, and the mark is set.
fn calibrated(
    inputs: &Inputs,
    campaign: &Campaign,
    held_out: &[bool],
) -> Result<(Calibration, bool), CalibrationError> {
    let fitted = |prior: bool| {
        let only = Some(inputs.nuisance.clone());
        let asked = estimation::Settings {
            only,
            prior,
            second_order: false,
            hold_far_springs: false,
            ..estimation::Settings::default()
        };
        calibrate_as_weighed(inputs.model, campaign, held_out, &asked, &mut |_| {})
    };
    let free = fitted(false)?;
    if free.converged() {
        return Ok((free, false));
    }
    let pulled = fitted(true)?;
    // Where no step makes it better any more, what is missing to the minimum is of the size of rounding, and of first order.
    if pulled.converged() || pulled.ending == Status::Stalled {
        return Ok((pulled, true));
    }
    if free.ending == Status::Stalled {
        return Ok((free, true));
    }
    Err(CalibrationError::NotConverged { ending: free.ending, iterations: free.iterations })
}

/// Which of the readings that are no outliers are held out; none where all are.
fn held_out(held_out: &[bool], outliers: &[bool]) -> Vec<bool> {
    let kept: Vec<bool> =
        held_out.iter().zip(outliers).filter(|(_, outlier)| !**outlier).map(|(held, _)| *held).collect();
    if kept.contains(&false) { kept } else { vec![false; kept.len()] }
}
