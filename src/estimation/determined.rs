//! Constants that readings tell far worse than the description does.
//!
//! A reduction by singular values keeps as many parameters as move the readings at all. Where places are unknown too (a ball in
//! sockets that stand anywhere), some of these are hardly determined, and what no model describes moves them to where no arm
//! has them: a twist of an axis by 48 deg. Where a constant has moved by a hundred times its tolerance, and its 95 % interval is as
//! wide, parameters that noise decides are left as described ([`Criterion::Noise`]); so they are where one has moved by ten times its
//! tolerance and its interval holds the description. A wide interval alone does no harm. Nor is a narrow one enough: of a payload
//! the weight alone tells a length along the last axis from where the tool is, and springs that are off moved it by 0.3 m, many times
//! its interval. One that moved by a hundred times its tolerance and that noise would hide is left as described too, where readings
//! held out are then predicted no worse: of nearly parallel axes such constants stand for small angles. So are they where the fit
//! does not end: only weights and loads show a turn of the base about the vertical apart from that of the first joint, say, and by so little that a
//! fit creeps along it.

use super::calibration::calibrate_as_asked;
use super::far::{calibrate_far, describes};
use super::problem::row_sigmas;
use super::reduction::reduced;
use super::result::{Calibration, CalibrationError, Estimate};
use super::settings::Settings;
use super::task::Request;
use crate::description::campaign::Campaign;
use crate::identifiability::{Criterion, DEFAULT_TOLERANCE, Scaling};
use crate::least_squares::Progress;
use crate::model::Model;
use crate::parameter::{Group, Slot};
use crate::prediction::Predictor;

/// Change of a constant, and half width of its 95 % interval, over its tolerance, beyond which it is not determined: no arm is as far
/// from its description. It holds of both measured campaigns with sockets, and of two of eight with an instrument: one where nothing
/// is dropped then, and one in which two joints move alone, where readings held out get worse by 0.2 %.
const WIDE: f64 = 100.0;
/// The same of a constant whose change is not significant: its interval holds the description. Poses within a small region give such
/// constants, with which predictions elsewhere are far off. A judgement: simulated narrow campaigns get better by it, and what is left of the
/// measured ones changes by at most 0.1 %.
const NOT_SIGNIFICANT: f64 = 10.0;

/// Calibrates as asked, or without what noise decides where the usual reduction leaves constants undetermined.
///
/// # Errors
/// As [`super::calibrate`].
pub(super) fn calibrate_determined(
    request: Request,
    progress: &mut dyn FnMut(&Progress),
) -> Result<Calibration, CalibrationError> {
    let Request { model, settings, .. } = request;
    let found = calibrate_far(request, progress)?;
    let is_usual = settings.only.is_none() && settings.criterion == Criterion::Relative(DEFAULT_TOLERANCE);
    let is_undetermined = |own: &Estimate| {
        let parameter = &model.registry[own.slot];
        let Some(ci95) = own.ci95.filter(|_| parameter.group == Group::Geometry) else { return false };
        let moved = (own.value - own.nominal).abs();
        let is_far = |times: f64| moved.min(ci95) > times * parameter.tolerance;
        is_far(WIDE) || is_far(NOT_SIGNIFICANT) && moved < ci95
    };
    if !is_usual {
        return Ok(found);
    }
    if !found.converged() {
        // Along a constant that only weights and loads show, a fit may creep for ever.
        let asked = Settings { criterion: by_noise(request.campaign, &found), ..settings.clone() };
        let other = calibrate_as_asked(request.with(&asked), progress).ok().filter(Calibration::converged);
        return Ok(other.unwrap_or(found));
    }
    let is_undetermined = found.estimates.iter().any(is_undetermined);
    if !is_undetermined && run_away(model, request.campaign, &found).is_empty() {
        return Ok(found);
    }
    let asked = Settings { criterion: by_noise(request.campaign, &found), ..settings.clone() };
    let other = calibrate_as_asked(request.with(&asked), progress).ok().filter(Calibration::converged);
    // What describes the readings to their noise is not given up for what does not, unless with constants that no arm has.
    let has_run_away = far_off(model, &found).next().is_some();
    let is_noise = |of: &Calibration| describes(request.campaign, of) && !has_run_away;
    let other = other.filter(|other| is_noise(other) || !is_noise(&found));
    let other = other.filter(|other| is_undetermined || predicts_as_well(other, &found));
    Ok(other.unwrap_or(found))
}

/// Settings by which what noise decides is dropped where no noise is stated: that is what a calibration as usual leaves.
///
/// # Errors
/// As [`super::calibrate`].
pub(super) fn with_noise_found(
    request: Request,
    progress: &mut dyn FnMut(&Progress),
) -> Result<Option<Settings>, CalibrationError> {
    let Request { campaign, settings, .. } = request;
    if campaign.sigma.is_some() || settings.criterion != Criterion::Noise {
        return Ok(None);
    }
    let usual = Settings { criterion: Criterion::Relative(DEFAULT_TOLERANCE), second_order: false, ..settings.clone() };
    let found = calibrate_determined(request.with(&usual), progress)?;
    let criterion = Criterion::NoiseTimes(found.noise_ratio);
    Ok(found.converged().then(|| Settings { criterion, ..settings.clone() }))
}

/// Whether readings held out are as near to one calibration as to another; not so where none are.
pub fn predicts_as_well(one: &Calibration, other: &Calibration) -> bool {
    one.after.check.readings > 0 && one.after.check.distance[1] <= other.after.check.distance[1]
}

/// Noise that is not stated is what calibration leaves.
fn by_noise(campaign: &Campaign, found: &Calibration) -> Criterion {
    match campaign.sigma {
        Some(_) => Criterion::Noise,
        None => Criterion::NoiseTimes(found.noise_ratio),
    }
}

/// Constants of the geometry that moved by a hundred times their tolerance.
pub fn far_off(model: &Model, found: &Calibration) -> impl Iterator<Item = Slot> {
    let is_far = |own: &&Estimate| {
        let parameter = &model.registry[own.slot];
        parameter.group == Group::Geometry && (own.value - own.nominal).abs() > WIDE * parameter.tolerance
    };
    found.estimates.iter().filter(is_far).map(|own| own.slot)
}

/// Where constants moved by a hundred times their tolerance that the noise of the fitted readings would hide: all constants that it hides.
/// What no model describes moved them there.
pub fn run_away(model: &Model, campaign: &Campaign, found: &Calibration) -> Vec<Slot> {
    let far: Vec<Slot> = far_off(model, found).collect();
    if far.is_empty() {
        return Vec::new();
    }
    let fitted = found.fitted(campaign);
    let seen = Predictor::new(model, &fitted, found.slots.clone()).and_then(|predictor| {
        reduced(&predictor, &found.values, &row_sigmas(&fitted), &[], Scaling::Norm, by_noise(campaign, found))
    });
    let Ok(seen) = seen else { return Vec::new() };
    let dropped = seen.identifiability.dropped.iter().filter_map(|(column, _)| seen.slots.get(*column).copied());
    let hidden: Vec<Slot> = dropped.filter(|&slot| model.registry[slot].group == Group::Geometry).collect();
    if far.iter().any(|slot| hidden.contains(slot)) { hidden } else { Vec::new() }
}
