//! Elements that a campaign leaves out of a description before it is resolved.

use std::collections::HashSet;

use crate::description::parameters::parameters;
use crate::description::raw::{RawEffect, RawFit, RawRobot};

/// Names that `without:` may hold.
pub(super) fn elements(raw: &RawRobot) -> Vec<String> {
    let named = raw.springs.keys().chain(raw.beams.keys()).chain(raw.bodies.keys()).cloned();
    let joints = raw.joint_stiffness.keys().map(|joint| format!("joint:{joint}"));
    named.chain(joints).chain(raw.effects.iter().filter_map(|effect| effect.effect.clone())).collect()
}

/// Leaves a named element (spring, beam, joint stiffness `joint:2`, body, effect) out of a description, what calibration
/// says of it too; of effects only those of `own`, if given. Whether there was one.
pub(super) fn leave_out(raw: &mut RawRobot, name: &str, own: Option<&RawRobot>) -> bool {
    let before = declared(raw);
    let joint = name.strip_prefix("joint:").unwrap_or(name).to_string();
    let stiffness = raw.joint_stiffness.shift_remove(&joint).is_some();
    let spring = raw.springs.shift_remove(name).is_some();
    let other = raw.beams.shift_remove(name).is_some() || raw.bodies.shift_remove(name).is_some();
    let effects = raw.effects.len();
    let is_own = |effect: &RawEffect| own.is_none_or(|own| own.effects.contains(effect));
    raw.effects.retain(|effect| effect.effect.as_deref() != Some(name) || !is_own(effect));
    let is_found = stiffness || spring || other || raw.effects.len() < effects;
    let after = declared(raw);
    let of_effect = format!("{name}@");
    let stays = |parameter: &str| {
        !parameter.starts_with(&of_effect) && (after.contains(parameter) || !before.contains(parameter))
    };
    for sums in raw.combinations.values_mut() {
        sums.retain(|_, of| of.keys().all(|parameter| stays(parameter)));
    }
    let calibration = &mut raw.calibration;
    calibration.free.retain(|parameter| stays(parameter));
    calibration.fixed.retain(|parameter| stays(parameter));
    calibration.tolerances.retain(|parameter, _| stays(parameter));
    calibration.uncertainties.retain(|parameter, _| stays(parameter));
    calibration.bounds.retain(|parameter, _| stays(parameter));
    if let Some(fit) = &mut calibration.fit {
        retain(fit, stays);
    }
    is_found
}

/// Names of the parameters that a description declares.
fn declared(raw: &RawRobot) -> HashSet<String> {
    parameters(raw).into_iter().filter(|key| key.declared).map(|key| key.name).collect()
}

/// Keeps the covariance of some parameters, where it is a triangle; else it is refused as it stands.
fn retain(fit: &mut RawFit, stays: impl Fn(&str) -> bool) {
    if fit.covariance.iter().enumerate().any(|(row, own)| own.len() != row + 1) {
        return;
    }
    let kept: Vec<bool> = fit.parameters.iter().map(|name| stays(name)).collect();
    let held = |k: usize| kept.get(k).copied().unwrap_or(true);
    let rows = std::mem::take(&mut fit.covariance).into_iter().enumerate().filter(|(row, _)| held(*row));
    let columns = |own: Vec<f64>| own.into_iter().enumerate().filter(|(k, _)| held(*k)).map(|(_, v)| v).collect();
    fit.covariance = rows.map(|(_, own)| columns(own)).collect();
    fit.parameters.retain(|name| stays(name));
}
