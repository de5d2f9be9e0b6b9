//! What has moved since an earlier description: the differences of a calibration from it, with their uncertainty.
//!
//! The calibration starts from the earlier description and estimates what that estimated ([`comparable`]), so that what the
//! readings do not determine keeps its values, and an estimate less its nominal value is the change. Both campaigns are independent: variances add. Where the description
//! states no uncertainty of a parameter, its value counts as exact.
//!
//! Many parameters are tried at once. Holm's step-down procedure (S. Holm, *Scand. J. Statist.* 6, 1979) keeps the
//! probability that anything at all is said to have moved that has not below the level, whatever the correlations.

use super::reduction::candidates;
use super::result::{Calibration, CalibrationError, Estimate};
use super::settings::{Settings, What};
use crate::description::campaign::Campaign;
use crate::description::raw::RawRobot;
use crate::math::quantiles::{t95, two_sided_t};
use crate::model::Model;
use crate::parameter::{Group, Parameter, Slot};

/// Probability with which anything is said to have moved although nothing has.
pub const LEVEL: f64 = 0.05;

/// The change of a parameter, in the unit of its kind (SI).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Change {
    /// The parameter.
    pub slot: Slot,
    /// Value of the earlier description.
    pub before: f64,
    /// Value now.
    pub now: f64,
    /// Standard deviation of the difference.
    pub sigma: f64,
    /// Half width of its 95 % interval.
    pub ci95: f64,
    /// Whether the earlier description states an uncertainty of its own, which is in [`Change::sigma`].
    pub both: bool,
    /// Probability of a difference as great by chance, all parameters considered (Holm).
    pub p: f64,
}

impl Change {
    /// The difference in standard deviations; `None` where readings without noise leave no deviation.
    pub fn z(&self) -> Option<f64> {
        (self.sigma > 0.0).then(|| (self.now - self.before) / self.sigma)
    }

    /// Whether the parameter has moved, at [`LEVEL`].
    pub fn moved(&self) -> bool {
        self.p < LEVEL
    }
}

/// Settings for a comparison with the earlier description `raw`: of the candidates those are estimated whose uncertainty it
/// states. Which of several nearly dependent parameters a reduction keeps differs from campaign to campaign, and the change
/// of one would appear in another. A base, tool or marker of which it states nothing was not estimated then, and is now as the
/// campaign asks. Unchanged where it states no uncertainty of any candidate.
///
/// # Errors
/// As [`candidates`].
pub fn comparable(
    raw: &RawRobot,
    model: &Model,
    campaign: &Campaign,
    mut settings: Settings,
) -> Result<Settings, CalibrationError> {
    let slots = candidates(model, campaign, settings.what.unwrap_or_else(|| What::usual(model, campaign)))?;
    let is_stated = |slot: &Slot| raw.calibration.uncertainties.contains_key(&model.registry[*slot].name);
    let stated: Vec<Slot> = slots.iter().copied().filter(is_stated).collect();
    if stated.is_empty() {
        return Ok(settings);
    }
    let markers = model.markers.iter().map(|marker| marker.slot..marker.slot + 3);
    for place in [model.base..model.base + 6, model.tool.1..model.tool.1 + 6].into_iter().chain(markers) {
        if stated.iter().any(|slot| place.contains(slot)) {
            let held = place.filter(|slot| !stated.contains(slot));
            settings.hold.extend(held.map(|slot| model.registry[slot].name.clone()));
        }
    }
    settings.only = Some(stated);
    Ok(settings)
}

/// The changes of all parameters that a calibration of the earlier description `raw` (its model is `model`) estimated, in
/// the calibration's order, but for those that are [`not_stated`].
pub fn changes(raw: &RawRobot, model: &Model, found: &Calibration) -> Vec<Change> {
    differences(raw, model, found, |estimate| {
        let is_stated = !is_not_stated(raw, model, estimate);
        is_stated.then(|| (&model.registry[estimate.slot], estimate.nominal))
    })
}

/// What a calibration estimated and the earlier description does not state: base, tool and instrument where neither an uncertainty nor a
/// place of them is written, and those of sessions. There is nothing to compare them with.
pub fn not_stated(raw: &RawRobot, model: &Model, found: &Calibration) -> Vec<Slot> {
    let estimated = found.estimates.iter().filter(|estimate| estimate.identifiable());
    estimated.filter(|estimate| is_not_stated(raw, model, estimate)).map(|estimate| estimate.slot).collect()
}

fn is_not_stated(raw: &RawRobot, model: &Model, estimate: &Estimate) -> bool {
    let (slot, uncertainties) = (estimate.slot, &raw.calibration.uncertainties);
    let parameter = &model.registry[slot];
    if model.is_of_a_session(slot) {
        return true;
    }
    if matches!(parameter.group, Group::Geometry | Group::Elastic | Group::Effect)
        || uncertainties.contains_key(&parameter.name)
    {
        return false;
    }
    let is_base = (model.base..model.base + 6).contains(&slot);
    let is_tool = (model.tool.1..model.tool.1 + 6).contains(&slot);
    let is_marker = model.markers.iter().any(|marker| (marker.slot..marker.slot + 3).contains(&slot));
    let is_written = is_base && (raw.base.at.is_some() || raw.base.rotation.is_some())
        || is_tool && (raw.tool.at.is_some() || raw.tool.rotation.is_some())
        || is_marker;
    !(is_written && uncertainties.is_empty())
}

/// The differences of what a calibration estimated from the values of another description `other`; `its` gives the parameter
/// there and its value, where there is one.
pub(super) fn differences<'m>(
    other: &RawRobot,
    model: &Model,
    found: &Calibration,
    its: impl Fn(&Estimate) -> Option<(&'m Parameter, f64)>,
) -> Vec<Change> {
    let change = |estimate: &Estimate| {
        let (parameter, before) = its(estimate)?;
        let (now, degrees_of_freedom) = estimate.repeatability()?;
        let stated = other.calibration.uncertainties.get(&model.registry[estimate.slot].name);
        let own = stated.map_or(0.0, |stated| width_in_si(other, parameter, before, *stated));
        let sigma = now.hypot(own);
        // Welch and Satterthwaite, the earlier deviation as good as known.
        let degrees_of_freedom = degrees_of_freedom * (sigma / now).powi(4);
        let ci95 = t95(degrees_of_freedom) * sigma;
        let now = estimate.value;
        let mut change = Change { slot: estimate.slot, before, now, sigma, ci95, both: stated.is_some(), p: 0.0 };
        change.p = match change.z() {
            Some(z) => two_sided_t(z, degrees_of_freedom),
            None => f64::from(u8::from(now == before)),
        };
        Some(change)
    };
    let mut changes: Vec<Change> = found.estimates.iter().filter_map(change).collect();
    let adjusted = holm(&changes.iter().map(|change| change.p).collect::<Vec<_>>());
    changes.iter_mut().zip(adjusted).for_each(|(change, p)| change.p = p);
    changes
}

/// The description with the standard deviations of what a calibration estimated put in, in the file's units.
#[must_use]
pub fn with_uncertainties(raw: &RawRobot, model: &Model, found: &Calibration) -> RawRobot {
    let mut raw = raw.clone();
    for estimate in &found.estimates {
        let parameter = &model.registry[estimate.slot];
        let Some((sigma, _)) = estimate.repeatability().filter(|(sigma, _)| sigma.is_finite()) else { continue };
        let width = parameter.shown_width(estimate.value, sigma) / size(&raw, parameter);
        raw.calibration.uncertainties.insert(parameter.name.clone(), width);
    }
    raw.calibration.fit = Some(found.fit.clone());
    raw
}

/// A stated standard deviation, of a stiffness that is computed with as a compliance that of the compliance.
fn width_in_si(raw: &RawRobot, parameter: &Parameter, value: f64, stated: f64) -> f64 {
    parameter.shown_width(parameter.shown(value), stated * size(raw, parameter))
}

/// The unit of a parameter in the file, in SI; effects are in SI.
fn size(raw: &RawRobot, parameter: &Parameter) -> f64 {
    if parameter.group == Group::Effect { 1.0 } else { raw.units.of(parameter.shown_kind()) }
}

/// Holm's adjusted probabilities of a family of tests: one below the level is significant with the family-wise error at most
/// that level.
///
/// ```
/// use elastogeo::estimation::holm;
///
/// let adjusted = holm(&[0.01, 0.04, 0.03, 0.005]);
/// let expected = [0.03, 0.06, 0.06, 0.02]; // 3 * 0.01, max(0.06, 1 * 0.04), 2 * 0.03, 4 * 0.005
/// assert!(adjusted.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-15));
/// ```
pub fn holm(p: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..p.len()).collect();
    order.sort_by(|&a, &b| p[a].total_cmp(&p[b]));
    let mut adjusted = vec![1.0; p.len()];
    let mut greatest: f64 = 0.0;
    for (rank, &index) in order.iter().enumerate() {
        greatest = greatest.max((p.len() - rank) as f64 * p[index]).min(1.0);
        adjusted[index] = greatest;
    }
    adjusted
}
