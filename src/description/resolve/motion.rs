//! What moves each joint: variables, actuators, couplings, closed loops. Exactly one for every joint that moves.

use super::super::coupling::parse_coupling;
use super::super::parameters::SLIDER_CRANK;
use super::super::raw::{JointKind, LoopKind, Meet, RawRobot};
use super::super::robot::{Coupling, Frame, FrameIndex, Loop, Motion, SliderCrank, Variable, branches};
use super::collector::Collector;
use crate::diagnostic::Diagnostic;

pub struct Motions {
    pub variables: Vec<Variable>,
    pub couplings: Vec<Coupling>,
    pub loops: Vec<Loop>,
    pub actuators: Vec<SliderCrank>,
}

/// Who drives a joint, and the path that says so.
struct Drivers {
    of_frame: Vec<Vec<(Motion, Vec<String>)>>,
}

pub fn resolve(raw: &RawRobot, frames: &mut [Frame], diagnostics: &mut Collector) -> Motions {
    let mut drivers = Drivers { of_frame: vec![Vec::new(); frames.len()] };
    let mut variables = ordered_variables(raw, frames, diagnostics);
    for (index, resolved) in frames.iter().enumerate().skip(1) {
        let name = resolved.name.clone();
        let Some(frame) = raw.frames.get(&name) else { continue };
        let direction = frame.direction.unwrap_or(1.0);
        if direction.abs() != 1.0 {
            diagnostics
                .error(&["frames", &name, "direction"], format!("direction `{direction}` is neither 1 nor -1"))
                .remedy = Some("a gear ratio is no direction: declare it as an effect or in `couplings`".into());
        }
        if let Some(variable) = &frame.variable
            && let Some(at) = variables.iter().position(|known| known.name == *variable)
        {
            let path = vec!["frames".into(), name.clone(), "variable".into()];
            variables[at].is_angle = resolved.joint != JointKind::Prismatic;
            variables[at].limits = resolved.limits;
            drivers.of_frame[index].push((Motion::Variable { index: at, direction }, path));
        }
        if frame.passive {
            drivers.of_frame[index].push((Motion::Passive, vec!["frames".into(), name, "passive".into()]));
        }
    }
    let actuators = actuators(raw, frames, &mut variables, &mut drivers, diagnostics);
    let couplings = couplings(raw, frames, &mut drivers, diagnostics);
    one_driver_each(raw, frames, &drivers, diagnostics);
    for (frame, drivers) in frames.iter_mut().zip(&drivers.of_frame) {
        if let Some((motion, _)) = drivers.first() {
            frame.motion = *motion;
        }
    }
    coupling_circles(&couplings, frames, diagnostics);
    let loops = loops(raw, frames, &variables, diagnostics);
    let couplings = followed_first(couplings, frames);
    Motions { variables, couplings, loops, actuators }
}

/// The names of all variables, in the declared order where there is one.
fn ordered_variables(raw: &RawRobot, frames: &[Frame], diagnostics: &mut Collector) -> Vec<Variable> {
    let mut users: Vec<(&String, Vec<String>)> = Vec::new();
    for frame in frames.iter().skip(1) {
        if let Some(variable) = raw.frames.get(&frame.name).and_then(|raw| raw.variable.as_ref()) {
            users.push((variable, vec!["frames".into(), frame.name.clone(), "variable".into()]));
        }
    }
    for (name, actuator) in &raw.actuators {
        if let Some(variable) = &actuator.variable {
            users.push((variable, vec!["actuators".into(), name.clone(), "variable".into()]));
        }
    }
    for (at, (variable, path)) in users.iter().enumerate() {
        if let Some((_, first)) = users[..at].iter().find(|(known, _)| known == variable) {
            let first: Vec<&str> = first.iter().map(String::as_str).collect();
            let path: Vec<&str> = path.iter().map(String::as_str).collect();
            let diagnostic = Diagnostic::error(format!("variable `{variable}` moves two joints"))
                .at(diagnostics.place(&path))
                .related(diagnostics.place(&first), "already used here")
                .remedy("let the second joint follow the first by a coupling, or name another variable");
            diagnostics.diagnostics.push(diagnostic);
        }
    }
    let mut names: Vec<&String> = Vec::new();
    for (position, variable) in raw.variables.iter().enumerate() {
        let path = ["variables", &position.to_string()];
        if names.contains(&variable) {
            diagnostics.error(&path, format!("variable `{variable}` is listed twice"));
        } else if !users.iter().any(|(known, _)| *known == variable) {
            let frames = raw.frames.keys().map(|name| ["frames", name.as_str(), "variable"]);
            let actuators = raw.actuators.keys().map(|name| ["actuators", name.as_str(), "variable"]);
            if frames.chain(actuators).any(|path| diagnostics.explained(&path)) {
                continue;
            }
            diagnostics.unknown(&path, "variable", variable, users.iter().map(|(known, _)| known.as_str()));
        } else {
            names.push(variable);
        }
    }
    for (variable, _) in &users {
        if !names.contains(variable) {
            names.push(variable);
        }
    }
    names.into_iter().map(|name| Variable { name: name.clone(), is_angle: true, limits: None }).collect()
}

fn find(frames: &[Frame], name: &str) -> Option<FrameIndex> {
    frames.iter().position(|frame| frame.name == name).filter(|&index| index != 0)
}

fn frame_names(frames: &[Frame]) -> impl Iterator<Item = &str> {
    frames.iter().skip(1).map(|frame| frame.name.as_str())
}

fn actuators(
    raw: &RawRobot,
    frames: &[Frame],
    variables: &mut [Variable],
    drivers: &mut Drivers,
    diagnostics: &mut Collector,
) -> Vec<SliderCrank> {
    let length = raw.units.length.factor();
    let mut actuators = Vec::new();
    for (name, actuator) in &raw.actuators {
        let path = |key: &'static str| ["actuators", name.as_str(), key];
        if actuator.kind.is_none()
            && let Some(diagnostic) =
                diagnostics.lacking(&["actuators", name], "kind", format!("actuator `{name}` has no kind"))
        {
            diagnostic.remedy = Some("add `kind: slider-crank`".into());
        }
        let mut complete = true;
        let constants = SLIDER_CRANK.map(|row| {
            let (symbol, given) = (row.symbol, (row.get)(actuator));
            if given.is_none() && symbol != "stroke" {
                diagnostics.lacking(&["actuators", name], symbol, format!("actuator `{name}` lacks `{symbol}`"));
                complete = false;
            }
            if matches!(symbol, "l1" | "l3") && given.is_some_and(|l| l <= 0.0) {
                diagnostics.error(&path(symbol), format!("length `{symbol}` of actuator `{name}` must be above 0"));
            }
            diagnostics.finite(&path(symbol), given, raw.units.of(row.kind))
        });
        let limits = diagnostics.limits(&path("limits"), actuator.limits, length);
        let [zero, _, _, l1, l3] = constants;
        if let Some([low, high]) = limits
            && complete
            && low.is_finite()
            && high.is_finite()
            && (low + zero <= (l1 - l3).abs() || high + zero >= l1 + l3)
        {
            let (least, greatest) = ((l1 - l3).abs() / length, (l1 + l3) / length);
            diagnostics
                .error(
                    &path("limits"),
                    format!("the triangle of actuator `{name}` does not close at one of its limits"),
                )
                .remedy = Some(format!("its length must stay within ({least}, {greatest})"));
        }
        let Some(joint) = actuator.joint.as_deref() else {
            diagnostics.lacking(&["actuators", name], "joint", format!("actuator `{name}` lacks `joint`"));
            continue;
        };
        let Some(joint_index) = find(frames, joint) else {
            diagnostics.unknown(&path("joint"), "frame", joint, frame_names(frames));
            continue;
        };
        if frames[joint_index].joint != JointKind::Revolute && !diagnostics.explained(&["frames", joint, "joint"]) {
            diagnostics
                .error(&path("joint"), format!("a slider-crank turns a revolute joint, and `{joint}` is not one"));
        }
        let Some(variable) =
            actuator.variable.as_deref().and_then(|v| variables.iter().position(|known| known.name == v))
        else {
            diagnostics.lacking(&["actuators", name], "variable", format!("actuator `{name}` lacks `variable`"));
            continue;
        };
        variables[variable].is_angle = false;
        variables[variable].limits = limits;
        let driver = (Motion::Actuator(actuators.len()), vec!["actuators".into(), name.clone(), "joint".into()]);
        drivers.of_frame[joint_index].push(driver);
        actuators.push(SliderCrank { name: name.clone(), joint: joint_index, variable, constants });
    }
    actuators
}

fn couplings(raw: &RawRobot, frames: &[Frame], drivers: &mut Drivers, diagnostics: &mut Collector) -> Vec<Coupling> {
    let mut couplings = Vec::new();
    for (position, text) in raw.couplings.iter().enumerate() {
        let position = position.to_string();
        let path = ["couplings", position.as_str()];
        let (joint, terms) = match parse_coupling(text) {
            Ok(parsed) => parsed,
            Err(why) => {
                diagnostics.couplings_failed = true;
                diagnostics.error(&path, format!("coupling `{text}`: {why}")).remedy =
                    Some("write `joint = factor * joint`, as in `6 = -1 * 5` or `3 = 1 * 2 - 0.5 * 4`".into());
                continue;
            }
        };
        let mut known = |name: &str| {
            let index = find(frames, name);
            match index {
                None => diagnostics.unknown(&path, "joint", name, frame_names(frames)),
                Some(index)
                    if frames[index].joint == JointKind::Fixed && diagnostics.explained(&["frames", name, "joint"]) => {
                }
                Some(index) if frames[index].joint == JointKind::Fixed => {
                    diagnostics.error(&path, format!("`{name}` is fixed and can neither follow nor lead")).remedy =
                        Some("give it `joint: revolute` or `joint: prismatic`".into());
                    return None;
                }
                Some(_) => {}
            }
            index
        };
        let joint = known(joint);
        let terms: Vec<Option<(f64, FrameIndex)>> =
            terms.iter().map(|(f, name)| known(name).map(|i| (*f, i))).collect();
        let (Some(joint), Some(terms)) = (joint, terms.into_iter().collect::<Option<Vec<_>>>()) else { continue };
        // A factor between a slide and a turn is in the file's units (mm per deg).
        let unit = |joint: FrameIndex| {
            if frames[joint].joint == JointKind::Prismatic {
                raw.units.length.factor()
            } else {
                raw.units.angle.factor()
            }
        };
        let terms: Vec<_> = terms
            .into_iter()
            .map(|(f, other)| {
                if frames[other].joint == frames[joint].joint {
                    (f, other)
                } else {
                    (f * unit(joint) / unit(other), other)
                }
            })
            .collect();
        if let Some((Motion::Coupling(_), first)) =
            drivers.of_frame[joint].iter().find(|(motion, _)| matches!(motion, Motion::Coupling(_)))
        {
            let first: Vec<&str> = first.iter().map(String::as_str).collect();
            let diagnostic = Diagnostic::error(format!("joint `{}` is in two couplings", frames[joint].name))
                .at(diagnostics.place(&path))
                .related(diagnostics.place(&first), "it already follows here")
                .remedy("keep one of them");
            diagnostics.diagnostics.push(diagnostic);
            continue;
        }
        drivers.of_frame[joint].push((Motion::Coupling(couplings.len()), vec!["couplings".into(), position.clone()]));
        couplings.push(Coupling { joint, terms });
    }
    couplings
}

/// Every joint that moves has one driver, a fixed one none.
fn one_driver_each(raw: &RawRobot, frames: &[Frame], drivers: &Drivers, diagnostics: &mut Collector) {
    let mut positions = 0..raw.couplings.len() + 1;
    let driver_faulty = diagnostics.explained(&["actuators"])
        || diagnostics.explained(&["couplings"])
        || positions.any(|k| diagnostics.explained(&["couplings", &k.to_string()]))
        || diagnostics.couplings_failed
        || raw
            .actuators
            .keys()
            .any(|name| ["joint", "variable"].iter().any(|key| diagnostics.explained(&["actuators", name, key])));
    for (frame, drivers) in frames.iter().zip(&drivers.of_frame).skip(1) {
        let name = &frame.name;
        let path_of = |driver: &(Motion, Vec<String>)| driver.1.clone();
        match drivers.as_slice() {
            [] if driver_faulty
                || ["variable", "passive"].iter().any(|key| diagnostics.explained(&["frames", name, key])) => {}
            [_] if frame.joint == JointKind::Fixed && diagnostics.explained(&["frames", name, "joint"]) => {}
            [] if frame.joint != JointKind::Fixed && raw.frames.contains_key(name) => {
                diagnostics.error(&["frames", name], format!("nothing moves joint `{name}`")).remedy = Some(
                    "give it a `variable`, an actuator, a coupling, or `passive: true` within a closed loop (or `joint: fixed`)".into(),
                );
            }
            [driver] if frame.joint == JointKind::Fixed => {
                let path = path_of(driver);
                let path: Vec<&str> = path.iter().map(String::as_str).collect();
                diagnostics.error(&path, format!("`{name}` is fixed, and yet something moves it")).remedy =
                    Some(format!("add `joint: revolute` (or `prismatic`) to frame `{name}`"));
            }
            [first, second, ..] => {
                let (first, second) = (path_of(first), path_of(second));
                let first: Vec<&str> = first.iter().map(String::as_str).collect();
                let second: Vec<&str> = second.iter().map(String::as_str).collect();
                let diagnostic = Diagnostic::error(format!("joint `{name}` is moved by two things"))
                    .at(diagnostics.place(&second))
                    .related(diagnostics.place(&first), "it is already moved here")
                    .remedy("keep one of: variable, actuator, coupling, passive");
                diagnostics.diagnostics.push(diagnostic);
            }
            _ => {}
        }
    }
}

fn coupling_circles(couplings: &[Coupling], frames: &[Frame], diagnostics: &mut Collector) {
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
            diagnostics
                .error(&["couplings", &index.to_string()], format!("joint `{name}` follows itself through couplings"))
                .remedy = Some("one joint of the circle needs a variable".into());
        }
    }
}

/// Orders couplings so that each comes after those it depends on, and renumbers the motions that name them.
fn followed_first(couplings: Vec<Coupling>, frames: &mut [Frame]) -> Vec<Coupling> {
    let mut ordered: Vec<Coupling> = Vec::new();
    let mut waiting = couplings;
    while !waiting.is_empty() {
        let joints: Vec<FrameIndex> = waiting.iter().map(|c| c.joint).collect();
        let (ready, rest): (Vec<_>, Vec<_>) =
            waiting.into_iter().partition(|c| c.terms.iter().all(|(_, joint)| !joints.contains(joint)));
        if ready.is_empty() {
            ordered.extend(rest); // a circle, already told
            break;
        }
        ordered.extend(ready);
        waiting = rest;
    }
    for (index, coupling) in ordered.iter().enumerate() {
        if matches!(frames[coupling.joint].motion, Motion::Coupling(_)) {
            frames[coupling.joint].motion = Motion::Coupling(index);
        }
    }
    ordered
}

fn loops(raw: &RawRobot, frames: &[Frame], variables: &[Variable], diagnostics: &mut Collector) -> Vec<Loop> {
    let (length, angle) = (raw.units.length.factor(), raw.units.angle.factor());
    let mut loops = Vec::new();
    // Whether some loop could not be followed, so that nothing is known of its joints.
    let mut unclear = diagnostics.explained(&["loops"]);
    let faulty_tree = diagnostics.antecedents_failed
        || raw.frames.keys().any(|name| diagnostics.explained(&["frames", name, "antecedent"]));
    let mut in_loop = vec![false; frames.len()];
    for (name, raw_loop) in &raw.loops {
        let path = |key: &'static str| ["loops", name.as_str(), key];
        let Some(pair) = &raw_loop.frames else {
            if let Some(diagnostic) =
                diagnostics.lacking(&["loops", name], "frames", format!("loop `{name}` lacks `frames`"))
            {
                diagnostic.remedy = Some("name the two frames that meet: `frames: [10, 11]`".into());
            }
            unclear = true;
            continue;
        };
        let found = [0, 1].map(|k| {
            let index = frames.iter().position(|frame| frame.name == pair[k]);
            if index.is_none() {
                let position = k.to_string();
                diagnostics.unknown(
                    &["loops", name, "frames", &position],
                    "frame",
                    &pair[k],
                    frames.iter().map(|f| f.name.as_str()),
                );
            }
            index
        });
        let [Some(a), Some(b)] = found else {
            unclear = true;
            continue;
        };
        if a == b {
            diagnostics.error(&path("frames"), format!("loop `{name}` is cut between a frame and itself")).remedy =
                Some("name two frames, one on each side of the cut joint".into());
            continue;
        }
        let members = members(frames, a, b);
        for &member in &members {
            in_loop[member] = true;
        }
        let untold =
            |key: &str| members.iter().any(|&i| diagnostics.explained(&["frames", frames[i].name.as_str(), key]));
        if !members.iter().any(|&i| frames[i].motion == Motion::Passive) && !untold("passive") {
            diagnostics
                .error(&path("frames"), format!("loop `{name}` has no passive joint, so nothing can close it"))
                .remedy = Some("mark the joints that the loop moves with `passive: true`".into());
        }
        let kind =
            raw_loop.kind.unwrap_or_else(|| if is_planar(frames, a, b) { LoopKind::Planar } else { LoopKind::Spatial });
        if kind == LoopKind::Planar && !is_planar(frames, a, b) {
            diagnostics
                .error(&path("kind"), format!("loop `{name}` is not planar: its axes are not parallel revolute ones"))
                .remedy = Some("write `kind: spatial`".into());
        }
        let mut branch = Vec::new();
        for (joint, value) in &raw_loop.branch {
            let path = ["loops", name, "branch", joint];
            match find(frames, joint) {
                Some(index) if members.contains(&index) && frames[index].motion == Motion::Passive => {
                    let factor = if frames[index].joint == JointKind::Prismatic { length } else { angle };
                    branch.push((index, diagnostics.finite(&path, Some(*value), factor)));
                }
                Some(_) => {
                    diagnostics.error(&path, format!("`{joint}` is not a passive joint of loop `{name}`"));
                }
                None => diagnostics.unknown(&path, "joint", joint, frame_names(frames)),
            }
        }
        let mut at = Vec::new();
        for (variable, value) in &raw_loop.at {
            let path = ["loops", name, "at", variable];
            match variables.iter().position(|known| known.name == *variable) {
                Some(index) => {
                    let factor = if variables[index].is_angle { angle } else { length };
                    at.push((index, diagnostics.finite(&path, Some(*value), factor)));
                }
                None => diagnostics.unknown(&path, "variable", variable, variables.iter().map(|v| v.name.as_str())),
            }
        }
        let gap = diagnostics.finite(&path("gap"), raw_loop.gap, length).max(0.0);
        let meet = raw_loop.meet.unwrap_or(Meet::Frame);
        loops.push(Loop { name: name.clone(), frames: [a, b], kind, meet, branch, at, gap });
    }
    for (index, frame) in frames.iter().enumerate().skip(1) {
        if frame.motion == Motion::Passive && !in_loop[index] && !unclear && !faulty_tree {
            let name = &frame.name;
            diagnostics
                .error(&["frames", name, "passive"], format!("joint `{name}` is passive, but no loop holds it"))
                .remedy = Some("declare the loop under `loops:`, or give the joint a variable".into());
        }
    }
    loops
}

fn members(frames: &[Frame], a: FrameIndex, b: FrameIndex) -> Vec<FrameIndex> {
    branches(frames, a, b).concat()
}

/// Revolute (or fixed) throughout, with parallel axes: alpha 0 or 180 deg past the first frame of each branch.
fn is_planar(frames: &[Frame], a: FrameIndex, b: FrameIndex) -> bool {
    let tilted = |alpha: f64| alpha.sin().abs() > NEAR_PARALLEL;
    branches(frames, a, b).iter().all(|branch| {
        branch.iter().enumerate().all(|(position, &index)| {
            let frame = &frames[index];
            let slides = frame.joint == JointKind::Prismatic;
            !slides && (position == 0 || !(tilted(frame.constants.alpha) || tilted(frame.constants.beta)))
        })
    })
}

/// Sine below which axes count as parallel: 1 deg, well above what calibration changes.
const NEAR_PARALLEL: f64 = 0.017;
