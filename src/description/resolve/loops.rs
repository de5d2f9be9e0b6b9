//! Closed loops: the frames that meet, and which joints the loop moves.

use nalgebra::Vector3;

use super::super::frame::{Frame, FrameIndex, Motion, NEAR_PARALLEL, branches};
use super::super::raw::{JointKind, LoopKind, Meet, RawLoop, RawRobot};
use super::super::robot::{Loop, Variable};
use super::collector::Collector;
use super::drivers::{find, frame_names};
use crate::description::limits::turned;

/// Loops as declared, every fault reported; then joints that claim a loop and are in none.
pub fn loops(raw: &RawRobot, frames: &[Frame], variables: &[Variable], diagnostics: &mut Collector) -> Vec<Loop> {
    let mut loops = Vec::new();
    // Whether some loop could not be followed, so that nothing is known of its joints.
    let mut unclear = diagnostics.explained(&["loops"])
        || diagnostics.antecedents_failed
        || raw.frames.keys().any(|name| diagnostics.explained(&["frames", name, "antecedent"]));
    let mut in_loop = vec![false; frames.len()];
    for (name, given) in &raw.loops {
        let Some([a, b]) = meeting(name, given, frames, diagnostics) else {
            unclear = true;
            continue;
        };
        if a == b {
            let message = format!("loop `{name}` is cut between a frame and itself");
            let remedy = "name two frames, one on each side of the cut joint";
            diagnostics.reject(&["loops", name, "frames"], message, remedy);
            continue;
        }
        let members = branches(frames, a, b).concat();
        members.iter().for_each(|&member| in_loop[member] = true);
        let passive = members.iter().any(|&i| frames[i].motion == Motion::Passive);
        if !passive && !members.iter().any(|&i| diagnostics.explained(&["frames", &frames[i].name, "passive"])) {
            let message = format!("loop `{name}` has no passive joint, so nothing can close it");
            let remedy = "mark the joints that the loop moves with `passive: true`";
            diagnostics.reject(&["loops", name, "frames"], message, remedy);
        }
        let planar = is_planar(frames, a, b);
        let kind = given.kind.unwrap_or(if planar { LoopKind::Planar } else { LoopKind::Spatial });
        if kind == LoopKind::Planar && !planar {
            let message = format!("loop `{name}` is not planar: its axes are not parallel revolute ones");
            diagnostics.reject(&["loops", name, "kind"], message, "write `kind: spatial`");
        }
        let branch = branch(raw, name, given, &members, frames, diagnostics);
        let at = at(raw, name, given, variables, diagnostics);
        let declared = diagnostics.finite(&["loops", name, "gap"], given.gap, raw.units.length.factor());
        let gap = given.gap.map(|_| declared.max(0.0));
        let meet = given.meet.unwrap_or(Meet::Frame);
        loops.push(Loop { name: name.clone(), frames: [a, b], kind, meet, branch, at, gap });
    }
    for (index, frame) in frames.iter().enumerate().skip(1) {
        if frame.motion == Motion::Passive && !in_loop[index] && !unclear {
            let message = format!("joint `{}` is passive, but no loop holds it", frame.name);
            let remedy = "declare the loop under `loops:`, or give the joint a variable";
            diagnostics.reject(&["frames", &frame.name, "passive"], message, remedy);
        }
    }
    loops
}

/// The two frames that meet.
fn meeting(name: &str, given: &RawLoop, frames: &[Frame], diagnostics: &mut Collector) -> Option<[FrameIndex; 2]> {
    let Some(pair) = &given.frames else {
        let lacking = diagnostics.lacking(&["loops", name], "frames", format!("loop `{name}` lacks `frames`"));
        if let Some(diagnostic) = lacking {
            diagnostic.remedy = Some("name the two frames that meet: `frames: [10, 11]`".into());
        }
        return None;
    };
    let found = [0, 1].map(|k| {
        let index = frames.iter().position(|frame| frame.name == pair[k]);
        if index.is_none() {
            let path = ["loops", name, "frames", &k.to_string()];
            diagnostics.unknown(&path, "frame", &pair[k], frames.iter().map(|frame| frame.name.as_str()));
        }
        index
    });
    Some([found[0]?, found[1]?])
}

/// Rough values of passive joints, SI.
fn branch(
    raw: &RawRobot,
    name: &str,
    given: &RawLoop,
    members: &[FrameIndex],
    frames: &[Frame],
    diagnostics: &mut Collector,
) -> Vec<(FrameIndex, f64)> {
    let mut branch = Vec::new();
    for (joint, value) in &given.branch {
        let path = ["loops", name, "branch", joint];
        match find(frames, joint) {
            Some(index) if members.contains(&index) && frames[index].motion == Motion::Passive => {
                let prismatic = frames[index].joint == JointKind::Prismatic;
                let factor = if prismatic { raw.units.length.factor() } else { raw.units.angle.factor() };
                let found = diagnostics.finite(&path, Some(*value), factor);
                let limits = frames[index].limits.filter(|_| !prismatic);
                whole_turns_off(raw, &path, [*value, found], limits, diagnostics);
                branch.push((index, found));
            }
            Some(_) => {
                let message = format!("`{joint}` is not a passive joint of loop `{name}`");
                let remedy = "name passive joints of the loop here, and what drives it under `at`";
                diagnostics.reject(&path, message, remedy);
            }
            None => diagnostics.unknown(&path, "joint", joint, frame_names(frames)),
        }
    }
    branch
}

/// Values of actuated variables at which the branch was read, SI.
fn at(
    raw: &RawRobot,
    name: &str,
    given: &RawLoop,
    variables: &[Variable],
    diagnostics: &mut Collector,
) -> Vec<(usize, f64)> {
    let mut at = Vec::new();
    for (variable, value) in &given.at {
        let path = ["loops", name, "at", variable];
        match variables.iter().position(|known| known.name == *variable) {
            Some(index) => {
                let angle = variables[index].is_angle;
                let factor = if angle { raw.units.angle.factor() } else { raw.units.length.factor() };
                let found = diagnostics.finite(&path, Some(*value), factor);
                let limits = variables[index].limits.filter(|_| angle);
                whole_turns_off(raw, &path, [*value, found], limits, diagnostics);
                at.push((index, found));
            }
            None => diagnostics.unknown(&path, "variable", variable, variables.iter().map(|v| v.name.as_str())),
        }
    }
    at
}

/// Says of a joint of a loop, at `path`, that its value (as written, and in rad) is whole turns beyond the limits of the joint.
fn whole_turns_off(
    raw: &RawRobot,
    path: &[&str],
    [written, value]: [f64; 2],
    limits: Option<[f64; 2]>,
    diagnostics: &mut Collector,
) {
    let Some(limits) = limits else { return };
    let unit = raw.units.angle;
    let what = format!("`{}` = {written} {} of `{}`", path[path.len() - 1], unit.symbol(), path[path.len() - 2]);
    let place = diagnostics.place(path);
    diagnostics.diagnostics.extend(turned(&what, value, limits, unit).map(|found| found.at(place)));
}

/// Sine of the angle between the first axes of both sides of a loop beyond which they are in different planes, 10 deg: calibration tilts
/// one against the other by a few.
const TILTED: f64 = 0.17;

/// Revolute (or fixed) throughout, with parallel axes: those of the first frames of both branches, and alpha 0 or 180 deg past
/// these.
fn is_planar(frames: &[Frame], a: FrameIndex, b: FrameIndex) -> bool {
    let tilted = |alpha: f64| alpha.sin().abs() > NEAR_PARALLEL;
    let branches = branches(frames, a, b);
    let axis =
        |branch: &Vec<FrameIndex>| branch.first().map(|&first| frames[first].constants.before_joint() * Vector3::z());
    if let [Some(a), Some(b)] = [&branches[0], &branches[1]].map(axis)
        && a.cross(&b).norm() > TILTED
    {
        return false;
    }
    branches.iter().all(|branch| {
        branch.iter().enumerate().all(|(position, &index)| {
            let frame = &frames[index];
            let slides = frame.joint == JointKind::Prismatic;
            !slides && (position == 0 || !(tilted(frame.constants.alpha) || tilted(frame.constants.beta)))
        })
    })
}
