//! Constants that end far from the description.
//!
//! What readings can tell apart is judged where a fit begins. A linkage whose description is a parallelogram hides constants that it
//! tells apart once a zero has moved by a few degrees; merged into others, they are then missed in the residuals. Where a constant has
//! moved that far, or a robot with closed loops leaves more than the stated noise, the calibration is begun and reduced once more where the first one ended.
//!
//! So it is where contacts and anchors, placed anew by the calibrated robot, are elsewhere than the fit has them: begun from an uncalibrated
//! robot, a small sphere may end as a plane.

use super::calibration::{calibrate_as_asked, calibrate_from};
use super::problem::row_sigmas;
use super::registration::placed_anew;
use super::result::{Calibration, CalibrationError, Estimate};
use super::settings::Scheme;
use super::task::Request;
use crate::description::campaign::Campaign;
use crate::least_squares::{Loss, Progress};
use crate::math::quantiles::f_tail;
use crate::model::Stage;
use crate::parameter::Group;

/// Change of a constant over its tolerance from which the reduction is looked at again: tolerances say how far its columns are expected
/// to hold.
const FAR: f64 = 10.0;

/// Probability, by chance alone, of what the second calibration must explain in addition.
const CHANCE: f64 = 1e-3;

/// Probability of as much noise as is left below which something is missed: a second calibration is then made in one of twenty campaigns
/// in which nothing is missed.
const MISSED: f64 = 0.05;

/// Degrees of freedom of a noise that is stated.
const KNOWN: f64 = 1e9;

/// A calibration, or one that begins from where contacts and anchors are by what it found, if that leaves less.
fn with_targets_placed(
    request: Request,
    found: Calibration,
    progress: &mut dyn FnMut(&Progress),
) -> Result<Calibration, CalibrationError> {
    let Request { model, campaign, held_out, .. } = request;
    let fitted = campaign.select(|index, _| held_out.get(index) != Some(&true));
    let Some(anew) = placed_anew(model, &fitted, &found.values)? else { return Ok(found) };
    let is_better = |other: &Calibration| {
        other.converged() && (!found.converged() || squares(campaign, other) < squares(campaign, &found))
    };
    Ok(calibrate_from(Some(&anew), request, progress).ok().filter(is_better).unwrap_or(found))
}

/// Calibrates as asked, and once more from there where constants moved far, if that leaves certainly less.
///
/// # Errors
/// As [`super::calibrate`].
pub(super) fn calibrate_far(
    request: Request,
    progress: &mut dyn FnMut(&Progress),
) -> Result<Calibration, CalibrationError> {
    let Request { model, campaign, settings, .. } = request;
    let found = with_targets_placed(request, calibrate_as_asked(request, progress)?, progress)?;
    let is_plain = settings.loss == Loss::Squares && settings.scheme == Scheme::Batch && !settings.prior;
    let is_far = |own: &Estimate| {
        let parameter = &model.registry[own.slot];
        parameter.group == Group::Geometry && (own.value - own.nominal).abs() > FAR * parameter.tolerance
    };
    let looks_again = found.estimates.iter().any(is_far) || is_closed_and_missed(request, &found);
    if !is_plain || !found.converged() || !looks_again {
        return Ok(found);
    }
    let again = calibrate_from(Some(&found.values), request, progress);
    let better = |other: &Calibration| {
        let [before, after] = [&found, other].map(|of| squares(campaign, of));
        let [fewer, more] = [&found, other].map(|of| of.identifiability.kept.len());
        let added = more.saturating_sub(fewer).max(1) as f64;
        let left = found.degrees_of_freedom - added;
        f_tail((before - after) / added / (after / left), added, left) < CHANCE
    };
    let again = again.ok().filter(|other| other.converged() && better(other));
    Ok(match again {
        Some(other) => Calibration { iterations: found.iterations + other.iterations, ..other },
        None => found,
    })
}

/// Whether a robot with closed loops leaves certainly more than the stated noise: a parallelogram need not be far from its description
/// to show, by its lengths, what the described one hides.
fn is_closed_and_missed(request: Request, found: &Calibration) -> bool {
    let is_closed = request.model.stages.iter().any(|stage| matches!(stage, Stage::Loops(_)));
    is_closed && request.campaign.sigma.is_some() && !describes(request.campaign, found)
}

/// Whether no more than the noise is left, which is stated.
pub fn describes(campaign: &Campaign, found: &Calibration) -> bool {
    campaign.sigma.is_some() && f_tail(found.noise_ratio.powi(2), found.degrees_of_freedom, KNOWN) >= MISSED
}

/// Weighted squares of the residuals of the readings that were fitted.
pub(super) fn squares(campaign: &Campaign, of: &Calibration) -> f64 {
    let sigmas = row_sigmas(campaign);
    let weighted: Vec<f64> = of.residual.iter().zip(&sigmas).map(|(left, sigma)| left / sigma).collect();
    let fitted = campaign.by_reading(&weighted, 1).zip(&of.held_out).filter(|(_, held_out)| !**held_out);
    fitted.flat_map(|((_, own), _)| own).map(|own| own * own).sum()
}
