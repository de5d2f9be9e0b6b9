//! Elements that a campaign leaves out of a description before it is resolved.

use crate::description::parameters::{JOINT, RATE};
use crate::description::raw::{RawEffect, RawRobot};

/// Names that `without:` may hold.
pub(super) fn elements(raw: &RawRobot) -> Vec<String> {
    let named = raw.springs.keys().chain(raw.beams.keys()).chain(raw.bodies.keys()).cloned();
    let joints = raw.joint_stiffness.keys().map(|joint| format!("joint:{joint}"));
    named.chain(joints).chain(raw.effects.iter().filter_map(|effect| effect.effect.clone())).collect()
}

/// Leaves a named element (spring, beam, joint stiffness `joint:2`, body, effect) out of a description, what calibration
/// says of it too; of effects only those of `own`, if given. Whether there was one.
pub(super) fn leave_out(raw: &mut RawRobot, name: &str, own: Option<&RawRobot>) -> bool {
    let joint = name.strip_prefix("joint:").unwrap_or(name).to_string();
    let stiffness = raw.joint_stiffness.shift_remove(&joint).is_some();
    let spring = raw.springs.shift_remove(name).is_some();
    let other = raw.beams.shift_remove(name).is_some() || raw.bodies.shift_remove(name).is_some();
    let before = raw.effects.len();
    let is_own = |effect: &RawEffect| own.is_none_or(|own| own.effects.contains(effect));
    raw.effects.retain(|effect| effect.effect.as_deref() != Some(name) || !is_own(effect));
    let owners: Vec<String> = [(stiffness, format!("joint{joint}")), (spring, name.to_string())]
        .into_iter()
        .filter(|o| o.0)
        .map(|o| o.1)
        .collect();
    let stays = |parameter: &str| {
        let symbols: Vec<&str> = JOINT.iter().map(|row| row.symbol).chain([RATE.symbol]).collect();
        parameter
            .rsplit_once('.')
            .is_none_or(|(owner, symbol)| !(symbols.contains(&symbol) && owners.iter().any(|gone| gone == owner)))
    };
    raw.calibration.free.retain(|parameter| stays(parameter));
    raw.calibration.fixed.retain(|parameter| stays(parameter));
    raw.calibration.tolerances.retain(|parameter, _| stays(parameter));
    raw.calibration.uncertainties.retain(|parameter, _| stays(parameter));
    raw.calibration.bounds.retain(|parameter, _| stays(parameter));
    stiffness || spring || other || raw.effects.len() < before
}
