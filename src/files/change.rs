//! What may change a description before it is resolved: a URDF beneath it, and elements that a campaign leaves out.

use crate::description::raw::{JointKind, RawEffect, RawRobot};

/// A description in YAML laid over what a URDF gave: single keys of a frame override, whole entries elsewhere.
pub(super) fn merge(imported: RawRobot, over: RawRobot) -> RawRobot {
    let (length, angle) = (over.units.length.factor(), over.units.angle.factor());
    let mut merged = over.clone();
    let mut frames = imported.frames;
    for frame in frames.values_mut() {
        // From SI into the units of the file that is merged in.
        let joint_unit = if frame.joint == Some(JointKind::Prismatic) { length } else { angle };
        for value in [&mut frame.beta, &mut frame.gamma, &mut frame.alpha, &mut frame.theta].into_iter().flatten() {
            *value /= angle;
        }
        for value in [&mut frame.b, &mut frame.d, &mut frame.r].into_iter().flatten() {
            *value /= length;
        }
        frame.offset = frame.offset.map(|v| v / joint_unit);
        frame.limits = frame.limits.map(|limits| limits.map(|v| v / joint_unit));
    }
    for (name, given) in over.frames {
        let frame = frames.entry(name).or_default();
        macro_rules! take { ($($key:ident),*) => { $(if given.$key.is_some() { frame.$key = given.$key; })* } }
        take!(antecedent, joint, variable, direction, coaxial, beta, gamma, b, alpha, d, theta, r, offset, limits);
        frame.passive |= given.passive;
    }
    merged.frames = frames;
    merged.robot = over.robot.or(imported.robot);
    if over.tool == Default::default() {
        merged.tool = imported.tool;
        merged.tool.at = merged.tool.at.map(|at| at.map(|v| v / length));
        merged.tool.rotation = merged.tool.rotation.map(|r| r.map(|v| v / angle));
    }
    let mut couplings = imported.couplings;
    couplings.extend(over.couplings);
    merged.couplings = couplings;
    for (name, mut body) in imported.bodies {
        body.mass = body.mass.map(|mass| mass / over.units.mass.factor());
        body.com = body.com.map(|com| com.map(|v| v / length));
        merged.bodies.entry(name).or_insert(body);
    }
    merged
}

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
        let symbols = ["ka", "kr", "kar", "krr", "stiffness"];
        parameter
            .rsplit_once('.')
            .is_none_or(|(owner, symbol)| !(symbols.contains(&symbol) && owners.iter().any(|gone| gone == owner)))
    };
    raw.calibration.free.retain(|parameter| stays(parameter));
    raw.calibration.fixed.retain(|parameter| stays(parameter));
    raw.calibration.tolerances.retain(|parameter, _| stays(parameter));
    raw.calibration.bounds.retain(|parameter, _| stays(parameter));
    stiffness || spring || other || raw.effects.len() < before
}
