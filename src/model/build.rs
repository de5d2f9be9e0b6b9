//! Compiles a resolved robot.

use super::fault::Fault;
use super::free::{closing_lengths, free_by_rule};
use super::loops::stages;
use super::{Actuator, Frame, Marker, Model};
use crate::description::raw::JointKind;
use crate::description::robot::{
    FRAME_SYMBOLS, Motion, PLACEMENT_SYMBOLS, Placement, Robot, SLIDER_CRANK_SYMBOLS, is_angle,
};
use crate::diagnostic::Diagnostic;
use crate::parameter::{Group, Kind, Parameter, Registry, Slot};

/// Compiles a resolved robot.
///
/// # Errors
/// Every fault found: joints that depend on each other in a circle through loops, a loop that has more passive joints
/// than its closure can find, a frame that stands before the frame it is coaxial with.
pub fn build(robot: &Robot) -> Result<Model, Vec<Fault>> {
    let mut registry = Registry::default();
    let mut add = |robot: &Robot, owner: &str, symbol: &str, group: Group, nominal: f64| -> Slot {
        let name = format!("{owner}.{symbol}");
        let calibration = &robot.calibration;
        let kind = if is_angle(symbol) { Kind::Angle } else { Kind::Length };
        let common = if kind == Kind::Angle { calibration.angle_tolerance } else { calibration.length_tolerance };
        let tolerance = calibration.tolerances.get(&name).copied().unwrap_or(common);
        let bounds = calibration.bounds.get(&name).copied().unwrap_or([f64::NEG_INFINITY, f64::INFINITY]);
        registry.add(Parameter {
            name,
            kind,
            group,
            nominal,
            bounds,
            tolerance,
            free: false,
            closing: false,
            inverted: false,
        })
    };
    let base = add_placement(&mut add, robot, "base", Group::Base, &robot.base);
    let mut frames: Vec<Frame> = Vec::with_capacity(robot.frames.len());
    let mut actuators: Vec<Option<Actuator>> = vec![None; robot.actuators.len()];
    for (index, frame) in robot.frames.iter().enumerate() {
        let c = &frame.constants;
        let mut values = [c.beta, c.gamma, c.b, c.alpha, c.d, c.theta, c.r];
        let moving = if frame.joint == JointKind::Prismatic { super::R } else { super::THETA };
        let home = values[moving];
        if frame.joint != JointKind::Fixed {
            values[moving] += frame.offset;
        }
        let mut slots = [0; 7];
        for (k, symbol) in FRAME_SYMBOLS.into_iter().enumerate() {
            slots[k] = match frame.coaxial {
                Some(other) if k < super::THETA => match frames.get(other) {
                    Some(other) => other.slots[k],
                    None => {
                        let diagnostic = Diagnostic::error(format!(
                            "frame `{}` stands before the frame it is coaxial with",
                            frame.name
                        ))
                        .remedy("declare it after that frame");
                        return Err(vec![Fault::new(&["frames", &frame.name, "coaxial"], diagnostic)]);
                    }
                },
                // The base's constants are nominally and always zero.
                _ if index == 0 => base,
                _ => add(robot, &frame.name, symbol, Group::Geometry, values[k]),
            };
        }
        if let Motion::Actuator(which) = frame.motion
            && let Some(actuator) = robot.actuators.get(which)
        {
            let mut slot = 0;
            for (k, symbol) in SLIDER_CRANK_SYMBOLS.into_iter().enumerate() {
                let added = add(robot, &actuator.name, symbol, Group::Geometry, actuator.constants[k]);
                slot = if k == 0 { added } else { slot };
            }
            actuators[which] =
                Some(Actuator { name: actuator.name.clone(), joint: index, variable: actuator.variable, slot });
        }
        frames.push(Frame {
            name: frame.name.clone(),
            antecedent: frame.antecedent,
            joint: frame.joint,
            motion: frame.motion,
            slots,
            home,
            limits: frame.limits,
        });
    }
    let tool = (robot.tool.frame, add_placement(&mut add, robot, "tool", Group::Tool, &robot.tool.placement));
    let markers = robot
        .markers
        .iter()
        .map(|marker| {
            let mut slot = 0;
            for (k, symbol) in PLACEMENT_SYMBOLS.into_iter().take(3).enumerate() {
                let added = add(robot, &marker.name, symbol, Group::Tool, marker.position[k]);
                slot = if k == 0 { added } else { slot };
            }
            Marker { name: marker.name.clone(), frame: marker.frame, slot }
        })
        .collect();
    let mut model = Model {
        name: robot.name.clone(),
        variables: robot.variables.clone(),
        frames,
        actuators: actuators.into_iter().flatten().collect(),
        couplings: robot.couplings.iter().map(|coupling| coupling.terms.clone()).collect(),
        stages: Vec::new(),
        base,
        tool,
        markers,
        anchors: robot.anchors.clone(),
        structure: super::Structure::default(),
        effects: Vec::new(),
        fuzzy: robot.fuzzy.clone(),
        registry,
    };
    model.stages = stages(&model, robot)?;
    for slot in free_by_rule(&model, robot) {
        model.registry.all_mut()[slot].free = true;
    }
    for slot in closing_lengths(&model, robot) {
        model.registry.all_mut()[slot].closing = true;
    }
    model.structure = super::assemble::assemble(robot, &mut model)?;
    robot.effects.iter().for_each(|entry| model.switch_on(entry.clone()));
    Ok(model)
}

fn add_placement(
    add: &mut impl FnMut(&Robot, &str, &str, Group, f64) -> Slot,
    robot: &Robot,
    owner: &str,
    group: Group,
    placement: &Placement,
) -> Slot {
    let values = [placement.position, placement.rotation];
    let mut slot = 0;
    for (k, symbol) in PLACEMENT_SYMBOLS.into_iter().enumerate() {
        let added = add(robot, owner, symbol, group, values[k / 3][k % 3]);
        slot = if k == 0 { added } else { slot };
    }
    slot
}
