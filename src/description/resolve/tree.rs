//! Frames, their antecedents, and what hangs between them.

use super::super::parameters::FRAME;
use super::super::raw::{JointKind, RawFrame, RawRobot};
use super::super::robot::{Constants, Coupling, Frame, Loop, Motion, SliderCrank, Variable};
use super::collector::Collector;
use super::motion;

/// The kinematic part of a resolved robot.
pub struct Tree {
    pub variables: Vec<Variable>,
    pub frames: Vec<Frame>,
    pub couplings: Vec<Coupling>,
    pub loops: Vec<Loop>,
    pub actuators: Vec<SliderCrank>,
}

pub fn resolve(raw: &RawRobot, diagnostics: &mut Collector) -> Tree {
    if raw.frames.is_empty() && !diagnostics.explained(&["frames"]) && !diagnostics.explained(&["urdf"]) {
        diagnostics.reject(
            &["frames"],
            "the description declares no frame",
            "add `frames:` (or `urdf:`), see `elastogeo schema robot`",
        );
    }
    if raw.frames.contains_key("0") {
        diagnostics.reject(
            &["frames", "0"],
            "frame `0` is the base and cannot be declared",
            "rename it; place the base in the measurement frame with `base:`",
        );
    }
    let order = antecedents_first(raw, diagnostics);
    let mut frames = vec![base_frame()];
    for name in &order {
        let Some(frame) = raw.frames.get(name) else { continue };
        let antecedent = frame.antecedent.as_deref().unwrap_or("0");
        let antecedent = frames.iter().position(|known| known.name == antecedent).unwrap_or(0);
        let frame = resolve_frame(raw, name, frame, antecedent, diagnostics);
        frames.push(frame);
    }
    coaxial_frames(raw, &mut frames, diagnostics);
    let motions = motion::resolve(raw, &mut frames, diagnostics);
    Tree {
        variables: motions.variables,
        couplings: motions.couplings,
        loops: motions.loops,
        actuators: motions.actuators,
        frames,
    }
}

fn base_frame() -> Frame {
    Frame {
        name: "0".into(),
        antecedent: 0,
        joint: JointKind::Fixed,
        motion: Motion::Fixed,
        constants: Constants::default(),
        coaxial: None,
        offset: 0.0,
        limits: None,
    }
}

/// Names of the frames, each after its antecedent, otherwise in the file's order; circles and unknown names reported.
fn antecedents_first(raw: &RawRobot, diagnostics: &mut Collector) -> Vec<String> {
    for (name, frame) in &raw.frames {
        match frame.antecedent.as_deref() {
            None => {
                diagnostics.antecedents_failed = true;
                if let Some(diagnostic) =
                    diagnostics.lacking(&["frames", name], "antecedent", format!("frame `{name}` has no antecedent"))
                {
                    diagnostic.remedy = Some("add `antecedent:`; `0` is the base".into());
                }
            }
            Some("0") => {}
            Some(antecedent) if !raw.frames.contains_key(antecedent) => {
                let valid = std::iter::once("0").chain(raw.frames.keys().map(String::as_str));
                diagnostics.unknown(&["frames", name, "antecedent"], "frame", antecedent, valid);
            }
            Some(_) => {}
        }
    }
    let mut placed: Vec<String> = Vec::new();
    let mut is_placed = std::collections::HashSet::from(["0".to_string()]);
    let mut waiting: Vec<&String> = raw.frames.keys().filter(|name| *name != "0").collect();
    loop {
        let before = waiting.len();
        waiting.retain(|name| {
            let antecedent = raw.frames[*name].antecedent.as_deref().unwrap_or("0");
            let ready = is_placed.contains(antecedent) || !raw.frames.contains_key(antecedent);
            if ready {
                placed.push((*name).clone());
                is_placed.insert((*name).clone());
            }
            !ready
        });
        if waiting.is_empty() {
            return placed;
        }
        if waiting.len() == before {
            diagnostics.antecedents_failed = true;
            report_circles(raw, &waiting, diagnostics);
            // They are kept, in the base, so that nothing that names them is reported as unknown.
            placed.extend(waiting.into_iter().cloned());
            return placed;
        }
    }
}

/// Each circle among the frames that wait for each other, once.
fn report_circles(raw: &RawRobot, waiting: &[&String], diagnostics: &mut Collector) {
    let mut reported: Vec<String> = Vec::new();
    for start in waiting {
        let mut walk: Vec<&str> = vec![start];
        while let Some(next) = raw.frames[walk[walk.len() - 1]].antecedent.as_deref() {
            if let Some(at) = walk.iter().position(|name| *name == next) {
                let circle = &walk[at..];
                if !reported.iter().any(|name| name == next) {
                    let shown: Vec<&str> = circle.iter().copied().chain([next]).take(12).collect();
                    diagnostics.reject(
                        &["frames", circle[0], "antecedent"],
                        format!("antecedents go in a circle: {}", shown.join(" <- ")),
                        "one frame of the chain must be placed in `0` or in a frame that is",
                    );
                    reported.extend(circle.iter().map(ToString::to_string));
                }
                break;
            }
            if !raw.frames.contains_key(next) {
                break;
            }
            walk.push(next);
        }
    }
}

fn resolve_frame(
    raw: &RawRobot,
    name: &str,
    frame: &RawFrame,
    antecedent: usize,
    diagnostics: &mut Collector,
) -> Frame {
    let (length, angle) = (raw.units.length.factor(), raw.units.angle.factor());
    let joint = frame.joint.unwrap_or(JointKind::Fixed);
    let joint_unit = if joint == JointKind::Prismatic { length } else { angle };
    let constants =
        FRAME.map(|row| diagnostics.finite(&["frames", name, row.symbol], (row.get)(frame), raw.units.of(row.kind)));
    let constants = Constants::from_values(constants);
    let offset = diagnostics.finite(&["frames", name, "offset"], frame.offset, joint_unit);
    let limits = diagnostics.limits(&["frames", name, "limits"], frame.limits, joint_unit);
    Frame { name: name.into(), antecedent, joint, motion: Motion::Fixed, constants, coaxial: None, offset, limits }
}

/// A coaxial frame takes over the shared constants; it must have the same antecedent and none of its own.
fn coaxial_frames(raw: &RawRobot, frames: &mut [Frame], diagnostics: &mut Collector) {
    for index in 1..frames.len() {
        let name = frames[index].name.clone();
        let Some(frame) = raw.frames.get(&name) else { continue };
        let Some(other) = frame.coaxial.as_deref() else { continue };
        let path = ["frames", &name, "coaxial"];
        let Some(shared) = frames.iter().position(|known| known.name == other).filter(|&i| i != 0 && i != index) else {
            diagnostics.unknown(
                &path,
                "frame",
                other,
                raw.frames.keys().map(String::as_str).filter(|known| *known != name),
            );
            continue;
        };
        if frames[shared].antecedent != frames[index].antecedent {
            let (theirs, ours) = (frames[shared].antecedent, frames[index].antecedent);
            let message =
                format!("`{name}` is placed in `{}`, but `{other}` in `{}`", frames[ours].name, frames[theirs].name);
            diagnostics.reject(&path, message, "coaxial frames have the same antecedent");
        } else if shared > index {
            diagnostics.reject(
                &path,
                format!("frame `{name}` stands before `{other}`, with which it is coaxial"),
                format!("declare `{name}` after `{other}`"),
            );
        } else if raw.frames.get(other).is_some_and(|f| f.coaxial.is_some()) {
            diagnostics.reject(
                &path,
                format!("`{other}` is itself coaxial with another frame"),
                "name the frame that holds the constants",
            );
        } else {
            // All but theta and r.
            for row in FRAME.iter().take(5).filter(|row| (row.get)(frame).is_some()) {
                let key = row.symbol;
                diagnostics.reject(
                    &["frames", &name, key],
                    format!("`{key}` is shared with frame `{other}`"),
                    format!("leave it out, or leave out `coaxial: {other}`"),
                );
            }
            let shared_constants = frames[shared].constants;
            let constants = &mut frames[index].constants;
            *constants = Constants { theta: constants.theta, r: constants.r, ..shared_constants };
            frames[index].coaxial = Some(shared);
        }
    }
}
