//! Deflections of a robot whose lengths are not those of the description: springs are then fitted to levers that are not there, and
//! take up most of it.

use nalgebra::DMatrix;

use super::evidence::{Evidence, Limits};
use super::fitted::Fitted;
use super::shown::{mm, number};
use crate::diagnostic::{Code, Diagnostic};
use crate::estimation::{Calibration, Settings, calibrate};
use crate::math::project_off;
use crate::math::quantiles::{f_tail, normal95};
use crate::parameter::{Group, Kind, Slot};
use crate::prediction::Predictor;

/// Share of what is above the noise that one constant must explain. A judgement: what gives elsewhere explains less in place of a length.
const EXPLAINED: f64 = 0.9;
/// Constants that are fitted: those that leave least in first order.
const FITTED: usize = 3;

/// Where springs fitted to deflections leave more than the stated noise, the same with one length or angle of the description fitted too.
pub(super) fn as_described(evidence: &Evidence, limits: &Limits) -> Vec<Diagnostic> {
    let is_asked = evidence.campaign.is_difference() && evidence.campaign.sigma.is_some();
    let found = evidence.found.filter(|found| is_asked && found.converged());
    found.and_then(|found| another_length(evidence, found, limits)).into_iter().collect()
}

fn another_length(evidence: &Evidence, found: &Calibration, limits: &Limits) -> Option<Diagnostic> {
    let (model, campaign) = (evidence.model, evidence.campaign);
    let kept = found.kept_slots();
    if kept.iter().any(|&slot| model.registry[slot].group == Group::Geometry) {
        return None;
    }
    let before = found.noise_ratio;
    let refitted = |slot: Slot| {
        let only = Some(kept.iter().copied().chain([slot]).collect());
        let asked = Settings { only, second_order: false, ..Settings::default() };
        let other = calibrate(model, campaign, &found.held_out, &asked, &mut |_| {}).ok()?;
        let parameter = &model.registry[slot];
        let moved = other.values[slot] - parameter.nominal;
        let is_far = moved.abs() > limits.moved * parameter.tolerance;
        // Noise alone leaves so much more than its variance once in forty times.
        let by_noise = normal95() * (2.0 / other.degrees_of_freedom.max(1.0)).sqrt();
        let most = by_noise.max((1.0 - EXPLAINED) * (before.powi(2) - 1.0));
        let is_explained = other.noise_ratio.powi(2) - 1.0 <= most;
        (other.converged() && is_far && is_explained).then_some((slot, moved, other.noise_ratio))
    };
    let all = promising(evidence, found, limits)?.into_iter().filter_map(refitted);
    let (slot, moved, after) = all.min_by(|a, b| a.2.total_cmp(&b.2))?;
    let parameter = &model.registry[slot];
    let shown = |value: f64| match parameter.kind {
        Kind::Length => format!("{} mm", mm(value)),
        _ => format!("{} deg", number(value.to_degrees())),
    };
    let message = format!(
        "with `{}` of {} instead of {} the fitted springs leave {after:.2} times the stated noise, and {before:.2} times as described: is that \
         length or angle right? Springs that are fitted to another arm are wrong",
        parameter.name,
        shown(parameter.nominal + moved),
        shown(parameter.nominal)
    );
    let remedy = "compare the description with the drawing of this robot (another variant of it, another tool?); if it is right, something gives that it \
                  does not declare: `diagnose` looks for that";
    let diagnostic = Diagnostic::warning(message).code(Code::UnlikeDescription).remedy(remedy);
    Some(diagnostic.figure("ratio", before).figure("ratio_with", after))
}

/// Constants that take away most of what is left in first order, where that is no chance.
fn promising(evidence: &Evidence, found: &Calibration, limits: &Limits) -> Option<Vec<Slot>> {
    let model = evidence.model;
    let fit = Fitted::of(evidence)?;
    let is_constant = |slot: &Slot| {
        let parameter = &model.registry[*slot];
        parameter.group == Group::Geometry && parameter.tolerance > 0.0
    };
    let slots: Vec<Slot> = (0..model.registry.all().len()).filter(is_constant).collect();
    let campaign = found.fitted(evidence.campaign);
    let linear = Predictor::new(model, &campaign, slots.clone()).ok()?.linearised(&found.values).ok()?;
    let (rows, width) = (fit.residual.len(), slots.len());
    let columns = DMatrix::from_fn(rows, width, |row, k| linear.jacobian[row * width + k] / fit.sigma(row));
    let free = project_off(&columns, &fit.basis);
    let total = fit.residual.norm_squared();
    let freedom = fit.freedom() - 1.0;
    let gain = |k: usize| {
        let column = free.column(k);
        // What springs take up entirely leaves rounding.
        let is_own = column.norm_squared() > 1e-12 * columns.column(k).norm_squared();
        let gain = column.dot(&fit.residual).powi(2) / column.norm_squared();
        let chance = width as f64 * f_tail(gain / ((total - gain).max(f64::MIN_POSITIVE) / freedom), 1.0, freedom);
        (is_own && gain.is_finite() && chance < limits.chance).then_some((slots[k], gain))
    };
    let mut gains: Vec<(Slot, f64)> = (0..width).filter_map(gain).collect();
    gains.sort_by(|a, b| b.1.total_cmp(&a.1));
    (freedom > limits.noise_freedom).then(|| gains.into_iter().take(FITTED).map(|(slot, _)| slot).collect())
}
