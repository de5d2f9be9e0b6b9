//! Constants that readings tell far worse than the description does.
//!
//! A reduction by singular values keeps as many parameters as move the readings at all. Where places are unknown too (a ball in
//! sockets that stand anywhere), some of these are told by next to nothing, and what no model describes moves them to where no arm
//! has them: a twist of an axis by 48 deg. Where a constant has moved by a hundred times its tolerance, and its 95 % interval is as
//! wide, parameters that noise decides are left as described ([`Criterion::Noise`]); so they are where one has moved by ten times its
//! tolerance and its interval holds the description. A wide interval alone does no harm.

use super::calibration::calibrate_as_asked;
use super::far::calibrate_far;
use super::result::{Calibration, CalibrationError, Estimate};
use super::settings::Settings;
use super::task::Request;
use crate::identifiability::{Criterion, DEFAULT_TOLERANCE};
use crate::least_squares::Progress;
use crate::parameter::Group;

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
    if !is_usual || !found.converged() || !found.estimates.iter().any(is_undetermined) {
        return Ok(found);
    }
    // Noise that is not stated is what calibration leaves.
    let criterion = match request.campaign.sigma {
        Some(_) => Criterion::Noise,
        None => Criterion::NoiseTimes(found.noise_ratio),
    };
    let asked = Settings { criterion, ..settings.clone() };
    let other = calibrate_as_asked(request.with(&asked), progress).ok();
    Ok(other.filter(Calibration::converged).unwrap_or(found))
}
