//! All campaigns calibrated with the same free parameters.
//!
//! Which of several nearly dependent parameters a reduction keeps may differ from campaign to campaign, and the change of one would
//! then appear in another. So those are estimated that all campaigns keep, of which an error of its tolerance shows above the noise:
//! what noise decides shows no change, and hides that of others. The others stand where the reference has them:
//! at the description's values where it says how certain these are, else at those of the first campaign's calibration.

use super::check::{Check, is_of_robot, kept};
use super::error::TrackingError;
use crate::description::campaign::Campaign;
use crate::description::raw::RawFit;
use crate::estimation::{Calibration, Settings, calibrate};
use crate::identifiability::Criterion;
use crate::model::Model;

/// A campaign to be calibrated.
#[derive(Debug, Clone)]
pub struct Measured<'a> {
    /// Its name.
    pub name: String,
    /// When, in the unit of the history.
    pub time: f64,
    /// The robot, as described, with what belongs to the campaign.
    pub model: &'a Model,
    /// The campaign.
    pub campaign: &'a Campaign,
    /// Whether each reading is held out.
    pub held_out: Vec<bool>,
}

/// Campaigns calibrated alike.
#[derive(Debug, Clone)]
pub struct Calibrated {
    /// Of each campaign: the robot as the reference has it, and the calibration from there.
    pub campaigns: Vec<(Model, Calibration)>,
    /// The checks in order; the first is the description where it says how certain it is.
    pub checks: Vec<Check>,
    /// Whether the first check is the description.
    pub with_description: bool,
}

/// Calibrates campaigns, which are in the order of time, from one reference; `fit` is what the description says of its certainty,
/// at the time given.
///
/// # Errors
/// [`TrackingError`].
pub fn calibrated(
    measured: &[Measured],
    fit: Option<(&RawFit, f64)>,
    settings: &Settings,
    progress: &mut dyn FnMut(&str),
) -> Result<Calibrated, TrackingError> {
    let (Some(first), true) = (measured.first(), measured.len() + usize::from(fit.is_some()) > 1) else {
        return Err(TrackingError::OneCheck);
    };
    let described = fit.and_then(|(fit, time)| Check::of_description("description", time, first.model, fit));
    let settings = Settings { second_order: false, criterion: Criterion::Noise, ..settings.clone() };
    let mut names = described.as_ref().map(|check| check.robot.names.clone());
    let mut models: Vec<Model> = measured.iter().map(|measured| measured.model.clone()).collect();
    if described.is_none() {
        let found = one(first, first.model, None, &settings, progress)?;
        names = Some(kept(first.model, &found));
        models.iter_mut().for_each(|model| refer(model, first.model, &found.values));
    }
    // Each round leaves out what a campaign does not determine; there are never more rounds than parameters.
    loop {
        let mut all = Vec::with_capacity(measured.len());
        let before = names.clone();
        for (measured, model) in measured.iter().zip(&models) {
            let found = one(measured, model, names.as_deref(), &settings, progress)?;
            let own = kept(model, &found);
            names = names.map(|names| names.into_iter().filter(|name| own.contains(name)).collect());
            all.push(found);
        }
        let Some(names) = names.as_ref().filter(|names| !names.is_empty()) else {
            return Err(TrackingError::NothingCommon);
        };
        if before.as_ref() == Some(names) {
            return gathered(measured, models, all, described, names);
        }
    }
}

/// One campaign calibrated, with these of the robot's parameters free.
fn one(
    measured: &Measured,
    model: &Model,
    names: Option<&[String]>,
    settings: &Settings,
    progress: &mut dyn FnMut(&str),
) -> Result<Calibration, TrackingError> {
    progress(&measured.name);
    let campaign = || measured.name.clone();
    let only = names.map(|names| names.iter().filter_map(|name| model.registry.slot(name)).collect());
    let settings = Settings { only, ..settings.clone() };
    let found = calibrate(model, measured.campaign, &measured.held_out, &settings, &mut |_| {})
        .map_err(|error| TrackingError::Calibration { campaign: campaign(), error })?;
    match found.converged() {
        true => Ok(found),
        false => Err(TrackingError::NotConverged {
            campaign: campaign(),
            ending: found.ending,
            iterations: found.iterations,
        }),
    }
}

/// Puts the robot's own values of a calibration in the place of the description's.
fn refer(model: &mut Model, of: &Model, values: &[f64]) {
    let named: Vec<(String, f64)> = of
        .registry
        .all()
        .iter()
        .zip(values)
        .enumerate()
        .filter(|(slot, _)| is_of_robot(of, *slot))
        .map(|(_, (parameter, value))| (parameter.name.clone(), *value))
        .collect();
    for (name, value) in named {
        if let Some(parameter) = model.registry.slot(&name).and_then(|slot| model.registry.all_mut().get_mut(slot)) {
            parameter.nominal = value;
        }
    }
}

/// The checks of the same parameters.
fn gathered(
    measured: &[Measured],
    models: Vec<Model>,
    found: Vec<Calibration>,
    described: Option<Check>,
    names: &[String],
) -> Result<Calibrated, TrackingError> {
    let with_description = described.is_some();
    let mut checks: Vec<Check> = described.into_iter().collect();
    for ((measured, model), found) in measured.iter().zip(&models).zip(&found) {
        checks.push(Check::of(&measured.name, measured.time, model, measured.campaign, found)?);
    }
    for check in &mut checks {
        let is_described = check.residuals.is_none();
        let robot = if is_described { check.robot.given_others(names) } else { check.robot.only(names) };
        check.robot = robot.ok_or(TrackingError::NothingCommon)?;
    }
    Ok(Calibrated { campaigns: models.into_iter().zip(found).collect(), checks, with_description })
}
