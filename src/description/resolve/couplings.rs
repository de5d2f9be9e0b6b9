//! Joints that follow others.

use super::super::coupling::{is_of_controller, parse_coupling};
use super::super::frame::{Frame, FrameIndex, Motion};
use super::super::raw::{JointKind, RawRobot};
use super::super::robot::Coupling;
use super::collector::Collector;
use super::drivers::{Drivers, find, frame_names};

/// Couplings as declared; those that cannot be read are reported.
pub fn couplings(
    raw: &RawRobot,
    frames: &[Frame],
    drivers: &mut Drivers,
    diagnostics: &mut Collector,
) -> Vec<Coupling> {
    let mut couplings = Vec::new();
    for (position, text) in raw.couplings.iter().enumerate() {
        let position = position.to_string();
        let path = ["couplings", position.as_str()];
        let (joint, terms) = match parse_coupling(text) {
            Ok(parsed) => parsed,
            Err(why) => {
                diagnostics.couplings_failed = true;
                diagnostics.reject(
                    &path,
                    format!("coupling `{text}`: {why}"),
                    "write `joint = factor * joint`, as in `6 = -1 * 5` or `3 = 1 * 2 - 0.5 * 4`; behind it `(controller)`, where no mechanism but the controller couples them",
                );
                continue;
            }
        };
        let mut known = |name: &str| movable(frames, name, &path, diagnostics);
        let joint = known(joint);
        let terms: Vec<Option<(f64, FrameIndex)>> =
            terms.iter().map(|(f, name)| known(name).map(|i| (*f, i))).collect();
        let (Some(joint), Some(terms)) = (joint, terms.into_iter().collect::<Option<Vec<_>>>()) else { continue };
        // A factor between a slide and a turn is in the file's units (mm per deg).
        let unit = |joint: FrameIndex| {
            let prismatic = frames[joint].joint == JointKind::Prismatic;
            if prismatic { raw.units.length.factor() } else { raw.units.angle.factor() }
        };
        let terms: Vec<_> = terms
            .into_iter()
            .map(|(f, other)| {
                let alike = frames[other].joint == frames[joint].joint;
                (if alike { f } else { f * unit(joint) / unit(other) }, other)
            })
            .collect();
        if let Some(first) = drivers.0[joint].iter().find(|driver| matches!(driver.motion, Motion::Coupling(_))) {
            let message = format!("joint `{}` is in two couplings", frames[joint].name);
            diagnostics.conflict(&path, message, &first.path(), "it already follows here", "keep one of them");
            continue;
        }
        drivers.add(joint, Motion::Coupling(couplings.len()), &path);
        couplings.push(Coupling { joint, terms, is_of_controller: is_of_controller(text) });
    }
    couplings
}

/// The frame of a joint that can follow or lead.
fn movable(frames: &[Frame], name: &str, path: &[&str], diagnostics: &mut Collector) -> Option<FrameIndex> {
    let Some(index) = find(frames, name) else {
        diagnostics.unknown(path, "joint", name, frame_names(frames));
        return None;
    };
    if frames[index].joint == JointKind::Fixed && !diagnostics.explained(&["frames", name, "joint"]) {
        let remedy = "give it `joint: revolute` or `joint: prismatic`";
        diagnostics.reject(path, format!("`{name}` is fixed and can neither follow nor lead"), remedy);
        return None;
    }
    Some(index)
}

/// Joints that follow themselves through couplings.
pub fn coupling_circles(couplings: &[Coupling], frames: &[Frame], diagnostics: &mut Collector) {
    for (index, coupling) in couplings.iter().enumerate() {
        let mut reached: Vec<FrameIndex> = coupling.terms.iter().map(|term| term.1).collect();
        let mut next = 0;
        while next < reached.len() {
            if let Motion::Coupling(c) = frames[reached[next]].motion
                && let Some(coupling) = couplings.get(c)
            {
                for (_, joint) in &coupling.terms {
                    if !reached.contains(joint) {
                        reached.push(*joint);
                    }
                }
            }
            next += 1;
        }
        if reached.contains(&coupling.joint) {
            let name = &frames[coupling.joint].name;
            diagnostics.reject(
                &["couplings", &index.to_string()],
                format!("joint `{name}` follows itself through couplings"),
                "one joint of the circle needs a variable",
            );
        }
    }
}

/// Orders couplings so that each comes after those it depends on, and renumbers the motions that name them.
pub fn followed_first(couplings: Vec<Coupling>, frames: &mut [Frame]) -> Vec<Coupling> {
    let mut ordered: Vec<Coupling> = Vec::new();
    let mut waiting = couplings;
    while !waiting.is_empty() {
        let joints: Vec<FrameIndex> = waiting.iter().map(|c| c.joint).collect();
        let (ready, later): (Vec<_>, Vec<_>) =
            waiting.into_iter().partition(|c| c.terms.iter().all(|(_, joint)| !joints.contains(joint)));
        if ready.is_empty() {
            ordered.extend(later); // a circle, already reported
            break;
        }
        ordered.extend(ready);
        waiting = later;
    }
    for (index, coupling) in ordered.iter().enumerate() {
        if matches!(frames[coupling.joint].motion, Motion::Coupling(_)) {
            frames[coupling.joint].motion = Motion::Coupling(index);
        }
    }
    ordered
}
