//! What moves each joint: variables, actuators, couplings, closed loops. Exactly one for every joint that moves.

use super::super::columns::is_reserved;
use super::super::frame::{Frame, Motion};
use super::super::parameters::SLIDER_CRANK;
use super::super::raw::{JointKind, RawActuator, RawRobot};
use super::super::robot::{Coupling, Loop, SliderCrank, Variable};
use super::collector::Collector;
use super::couplings::{coupling_circles, couplings, followed_first};
use super::drivers::{Drivers, find, frame_names, one_driver_each};
use super::loops::loops;
use crate::diagnostic::nearest;

pub struct Motions {
    pub variables: Vec<Variable>,
    pub couplings: Vec<Coupling>,
    pub loops: Vec<Loop>,
    pub actuators: Vec<SliderCrank>,
}

pub fn resolve(raw: &RawRobot, frames: &mut [Frame], diagnostics: &mut Collector) -> Motions {
    let mut drivers = Drivers(frames.iter().map(|_| Vec::new()).collect());
    let mut variables = ordered_variables(raw, frames, diagnostics);
    for (index, resolved) in frames.iter().enumerate().skip(1) {
        let name = resolved.name.clone();
        let Some(frame) = raw.frames.get(&name) else { continue };
        let direction = frame.direction.unwrap_or(1.0);
        if direction.abs() != 1.0 {
            diagnostics.reject(
                &["frames", &name, "direction"],
                format!("direction `{direction}` is neither 1 nor -1"),
                "a gear ratio is no direction: declare it as an effect or in `couplings`",
            );
        }
        if let Some(variable) = &frame.variable
            && let Some(at) = variables.iter().position(|known| known.name == *variable)
        {
            variables[at].is_angle = resolved.joint != JointKind::Prismatic;
            variables[at].limits = resolved.limits;
            drivers.add(index, Motion::Variable { index: at, direction }, &["frames", &name, "variable"]);
        }
        if frame.passive {
            drivers.add(index, Motion::Passive, &["frames", &name, "passive"]);
        }
    }
    let actuators = actuators(raw, frames, &mut variables, &mut drivers, diagnostics);
    let couplings = couplings(raw, frames, &mut drivers, diagnostics);
    one_driver_each(raw, frames, &drivers, diagnostics);
    for (frame, drivers) in frames.iter_mut().zip(&drivers.0) {
        if let Some(driver) = drivers.first() {
            frame.motion = driver.motion;
        }
    }
    coupling_circles(&couplings, frames, diagnostics);
    let loops = loops(raw, frames, &variables, diagnostics);
    let couplings = followed_first(couplings, frames);
    Motions { variables, couplings, loops, actuators }
}

/// The names of all variables, in the declared order where there is one.
fn ordered_variables(raw: &RawRobot, frames: &[Frame], diagnostics: &mut Collector) -> Vec<Variable> {
    let mut users: Vec<(&String, [&str; 3])> = Vec::new();
    for frame in frames.iter().skip(1) {
        if let Some(variable) = raw.frames.get(&frame.name).and_then(|raw| raw.variable.as_ref()) {
            users.push((variable, ["frames", &frame.name, "variable"]));
        }
    }
    for (name, actuator) in &raw.actuators {
        if let Some(variable) = &actuator.variable {
            users.push((variable, ["actuators", name, "variable"]));
        }
    }
    for (at, (variable, path)) in users.iter().enumerate() {
        if is_reserved(variable) {
            let message = format!("variable `{variable}` has the name of a column of measurements, or of a parameter");
            let other = format!("q{}", variable.replace('.', "_"));
            diagnostics.reject(path, message, format!("call it `{other}`, say, here and in the tables"));
        }
        if let Some((_, first)) = users[..at].iter().find(|(known, _)| known == variable) {
            let message = format!("variable `{variable}` moves two joints");
            let remedy = "let the second joint follow the first by a coupling, or name another variable";
            diagnostics.conflict(path, message, first, "already used here", remedy);
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
            let free =
                users.iter().map(|(known, _)| known.as_str()).filter(|known| !raw.variables.iter().any(|v| v == known));
            let message = format!("no joint and no actuator has the variable `{variable}`");
            let remedy = match nearest(variable, free) {
                Some(near) => format!("did you mean `{near}`?"),
                None => {
                    "give it to a joint (`frames: {..: {variable: ..}}`) or an actuator, or remove it here".to_owned()
                }
            };
            diagnostics.reject(&path, message, remedy);
        } else {
            names.push(variable);
        }
    }
    for (variable, _) in &users {
        if !names.contains(variable) {
            names.push(variable);
        }
    }
    names
        .into_iter()
        .map(|name| Variable { name: name.clone(), is_angle: true, limits: None, gear_ratio: None })
        .collect()
}

fn actuators(
    raw: &RawRobot,
    frames: &[Frame],
    variables: &mut [Variable],
    drivers: &mut Drivers,
    diagnostics: &mut Collector,
) -> Vec<SliderCrank> {
    let mut actuators = Vec::new();
    for (name, actuator) in &raw.actuators {
        let path = |key: &'static str| ["actuators", name.as_str(), key];
        let lacks = |key: &str| format!("actuator `{name}` lacks `{key}`");
        let (constants, limits) = triangle(raw, name, actuator, diagnostics);
        let Some(joint) = actuator.joint.as_deref() else {
            diagnostics.lacking(&["actuators", name], "joint", lacks("joint"));
            continue;
        };
        let Some(index) = find(frames, joint) else {
            diagnostics.unknown(&path("joint"), "frame", joint, frame_names(frames));
            continue;
        };
        if frames[index].joint != JointKind::Revolute && !diagnostics.explained(&["frames", joint, "joint"]) {
            let message = format!("a slider-crank turns a revolute joint, and `{joint}` is not one");
            diagnostics.error(&path("joint"), message);
        }
        let variable = actuator.variable.as_deref();
        let Some(variable) = variable.and_then(|v| variables.iter().position(|known| known.name == v)) else {
            diagnostics.lacking(&["actuators", name], "variable", lacks("variable"));
            continue;
        };
        variables[variable].is_angle = false;
        variables[variable].limits = limits;
        drivers.add(index, Motion::Actuator(actuators.len()), &path("joint"));
        actuators.push(SliderCrank { name: name.clone(), joint: index, variable, constants });
    }
    actuators
}

/// Constants and limits of a slider-crank, SI; its triangle must close within its limits.
fn triangle(
    raw: &RawRobot,
    name: &str,
    actuator: &RawActuator,
    diagnostics: &mut Collector,
) -> ([f64; 5], Option<[f64; 2]>) {
    if actuator.kind.is_none()
        && let Some(diagnostic) =
            diagnostics.lacking(&["actuators", name], "kind", format!("actuator `{name}` has no kind"))
    {
        diagnostic.remedy = Some("add `kind: slider-crank`".into());
    }
    let mut complete = true;
    let constants = SLIDER_CRANK.map(|row| {
        let (symbol, given) = (row.symbol, (row.get)(actuator));
        let path = ["actuators", name, symbol];
        if given.is_none() && symbol != "stroke" {
            diagnostics.lacking(&["actuators", name], symbol, format!("actuator `{name}` lacks `{symbol}`"));
            complete = false;
        }
        let value = diagnostics.finite(&path, given, raw.units.of(row.kind));
        if matches!(symbol, "l1" | "l3") && given.is_some_and(|l| l <= 0.0) {
            diagnostics.error(&path, format!("length `{symbol}` of actuator `{name}` must be above 0"));
        }
        value
    });
    let length = raw.units.length.factor();
    let limits = diagnostics.limits(&["actuators", name, "limits"], actuator.limits, length);
    let [zero, _, _, l1, l3] = constants;
    if let Some([low, high]) = limits
        && complete
        && low.is_finite()
        && high.is_finite()
        && (low + zero <= (l1 - l3).abs() || high + zero >= l1 + l3)
    {
        let (least, greatest) = ((l1 - l3).abs() / length, (l1 + l3) / length);
        let message = format!("the triangle of actuator `{name}` does not close at one of its limits");
        let remedy = format!("its length must stay within ({least}, {greatest})");
        diagnostics.reject(&["actuators", name, "limits"], message, remedy);
    }
    (constants, limits)
}
