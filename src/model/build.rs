//! Compiles a resolved robot.

use std::sync::Arc;

use super::fault::Fault;
use super::free::{closing_lengths, free_by_rule};
use super::loops::stages;
use super::{Actuator, Catalogue, Frame, Marker, Model};
use crate::description::parameters::{BASE, FRAME, MARKER, Owner, SLIDER_CRANK};
use crate::description::raw::JointKind;
use crate::description::robot::{Motion, Placement, Robot};
use crate::diagnostic::Diagnostic;
use crate::parameter::{Group, Kind, Parameter, Registry, Slot};

/// Compiles a resolved robot, with the effects that its description may switch on.
///
/// # Errors
/// Every fault found: joints that depend on each other in a circle through loops, a loop that has more passive joints
/// than its closure can find, a frame that stands before the frame it is coaxial with; an effect that the catalogue or the
/// robot does not know.
pub fn build(robot: &Robot, catalogue: impl Into<Arc<Catalogue>>) -> Result<Model, Vec<Fault>> {
    let mut registry = Registry::default();
    let mut add = |name: String, kind: Kind, group: Group, nominal: f64| -> Slot {
        let calibration = &robot.calibration;
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
    let base = add_placement(&mut add, Owner::Base, Group::Base, &robot.base);
    let mut frames: Vec<Frame> = Vec::with_capacity(robot.frames.len());
    let mut actuators: Vec<Option<Actuator>> = vec![None; robot.actuators.len()];
    for (index, frame) in robot.frames.iter().enumerate() {
        let mut values = frame.constants.values();
        let moving = if frame.joint == JointKind::Prismatic { super::R } else { super::THETA };
        let home = values[moving];
        if frame.joint != JointKind::Fixed {
            values[moving] += frame.offset;
        }
        let mut slots = [0; 7];
        for (k, row) in FRAME.iter().enumerate() {
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
                _ => add(Owner::Frame(&frame.name).parameter(row.symbol), row.kind, Group::Geometry, values[k]),
            };
        }
        if let Motion::Actuator(which) = frame.motion
            && let Some(actuator) = robot.actuators.get(which)
        {
            let mut slot = 0;
            let owner = Owner::Actuator(&actuator.name);
            for (k, row) in SLIDER_CRANK.iter().enumerate() {
                let added = add(owner.parameter(row.symbol), row.kind, Group::Geometry, actuator.constants[k]);
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
    let tool = (robot.tool.frame, add_placement(&mut add, Owner::Tool, Group::Tool, &robot.tool.placement));
    let markers = robot
        .markers
        .iter()
        .map(|marker| {
            let mut slot = 0;
            let owner = Owner::Marker(&marker.name);
            for (k, row) in MARKER.iter().enumerate() {
                let added = add(owner.parameter(row.symbol), row.kind, Group::Tool, marker.position[k]);
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
        catalogue: catalogue.into(),
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
    let mut faults = Vec::new();
    for (k, raw) in robot.effects.iter().enumerate() {
        match model.resolve_effect(raw) {
            Ok(entry) => model.switch_on(entry),
            Err(fault) => faults.push(fault.within(&["effects", &k.to_string()])),
        }
    }
    if faults.is_empty() { Ok(model) } else { Err(faults) }
}

fn add_placement(
    add: &mut impl FnMut(String, Kind, Group, f64) -> Slot,
    owner: Owner,
    group: Group,
    placement: &Placement,
) -> Slot {
    let values = [placement.position, placement.rotation];
    let mut slot = 0;
    for (k, row) in BASE.iter().enumerate() {
        let added = add(owner.parameter(row.symbol), row.kind, group, values[k / 3][k % 3]);
        slot = if k == 0 { added } else { slot };
    }
    slot
}
