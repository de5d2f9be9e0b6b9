//! Compiles a resolved robot.

use std::sync::Arc;

use super::fault::Fault;
use super::free::{closing_lengths, free_by_rule};
use super::loops::stages;
use super::{Actuator, Catalogue, Frame, Marker, Model};
use crate::description::parameters::{BASE, FRAME, MARKER, Number, Owner, SLIDER_CRANK};
use crate::description::raw::JointKind;
use crate::description::robot::{self, Motion, Placement, Robot};
use crate::diagnostic::Diagnostic;
use crate::parameter::{Group, Kind, Parameter, Registry, Slot};

/// Compiles a resolved robot, with the effects that its description may switch on.
///
/// # Errors
/// Every fault found: joints that depend on each other in a circle through loops, a loop that has more passive joints
/// than its closure can find, a frame that stands before the frame it is coaxial with; an effect that the catalogue or the
/// robot does not know.
pub fn build(robot: &Robot, catalogue: impl Into<Arc<Catalogue>>) -> Result<Model, Vec<Fault>> {
    let mut parts = Parts::new(robot);
    let base = parts.placement(Owner::Base, Group::Base, &robot.base);
    for index in 0..robot.frames.len() {
        parts.frame(index, base).map_err(|fault| vec![fault])?;
    }
    let tool = (robot.tool.frame, parts.placement(Owner::Tool, Group::Tool, &robot.tool.placement));
    let markers = parts.markers();
    let mut model = Model {
        name: robot.name.clone(),
        variables: robot.variables.clone(),
        frames: parts.frames,
        actuators: parts.actuators.into_iter().flatten().collect(),
        couplings: robot.couplings.iter().map(|coupling| coupling.terms.clone()).collect(),
        coupled_by_controller: robot.couplings.iter().map(|coupling| coupling.is_of_controller).collect(),
        limits: robot.limits.clone(),
        keep_out: robot.keep_out.clone(),
        stages: Vec::new(),
        base,
        tool,
        markers,
        anchors: robot.anchors.clone(),
        structure: super::Structure::default(),
        catalogue: catalogue.into(),
        effects: Vec::new(),
        arrangement: super::Arrangement::default(),
        fuzzy: robot.fuzzy.clone(),
        local_springs: None,
        registry: parts.registry,
    };
    model.stages = stages(&model, robot)?;
    for slot in free_by_rule(&model, robot) {
        model.registry.all_mut()[slot].free = true;
    }
    for slot in closing_lengths(&model, robot) {
        model.registry.all_mut()[slot].closing = true;
    }
    model.structure = super::assemble::assemble(robot, &mut model)?;
    if let Some(declared) = &robot.spring_rules {
        super::local_springs::put(&mut model, declared)?;
    }
    switch_on(&mut model, robot)?;
    Ok(model)
}

/// Switches on the effects of the description.
fn switch_on(model: &mut Model, robot: &Robot) -> Result<(), Vec<Fault>> {
    let mut faults = Vec::new();
    for (k, raw) in robot.effects.iter().enumerate() {
        match model.resolve_effect(raw) {
            Ok(entry) => model.switch_on(entry),
            Err(fault) => faults.extend(fault.within(&["effects", &k.to_string()]).each()),
        }
    }
    if faults.is_empty() { Ok(()) } else { Err(faults) }
}

/// What is compiled so far: the parameters, and the parts whose parameters are in the registry.
struct Parts<'a> {
    robot: &'a Robot,
    registry: Registry,
    frames: Vec<Frame>,
    /// By position in the description.
    actuators: Vec<Option<Actuator>>,
}

impl<'a> Parts<'a> {
    fn new(robot: &'a Robot) -> Self {
        let frames = Vec::with_capacity(robot.frames.len());
        Self { robot, registry: Registry::default(), frames, actuators: vec![None; robot.actuators.len()] }
    }

    /// Adds a parameter, with the tolerance and the bounds of the description.
    fn add(&mut self, name: String, kind: Kind, group: Group, nominal: f64) -> Slot {
        let calibration = &self.robot.calibration;
        let common = if kind == Kind::Angle { calibration.angle_tolerance } else { calibration.length_tolerance };
        let tolerance = calibration.tolerances.get(&name).copied().unwrap_or(common);
        let bounds = calibration.bounds.get(&name).copied().unwrap_or([f64::NEG_INFINITY, f64::INFINITY]);
        self.registry.add(Parameter {
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
    }

    /// Adds the parameters of an owner; the first slot.
    fn add_all<R>(&mut self, owner: Owner, rows: &[Number<R>], group: Group, values: &[f64]) -> Slot {
        let first = self.registry.all().len();
        for (row, &value) in rows.iter().zip(values) {
            self.add(owner.parameter(row.symbol), row.kind, group, value);
        }
        first
    }

    fn placement(&mut self, owner: Owner, group: Group, placement: &Placement) -> Slot {
        let ([x, y, z], [rx, ry, rz]): ([f64; 3], [f64; 3]) = (placement.position.into(), placement.rotation.into());
        self.add_all(owner, &BASE, group, &[x, y, z, rx, ry, rz])
    }

    /// Adds a frame, and the actuator that drives it.
    fn frame(&mut self, index: usize, base: Slot) -> Result<(), Fault> {
        let frame = &self.robot.frames[index];
        let mut values = frame.constants.values();
        let moving = if frame.joint == JointKind::Prismatic { super::R } else { super::THETA };
        let home = values[moving];
        if frame.joint != JointKind::Fixed {
            values[moving] += frame.offset;
        }
        let mut slots = [0; 7];
        for (k, row) in FRAME.iter().enumerate() {
            slots[k] = match frame.coaxial {
                Some(other) if k < super::THETA => self.frames.get(other).ok_or_else(|| not_yet(frame))?.slots[k],
                // The base's constants are nominally and always zero.
                _ if index == 0 => base,
                _ => self.add(Owner::Frame(&frame.name).parameter(row.symbol), row.kind, Group::Geometry, values[k]),
            };
        }
        if let Motion::Actuator(which) = frame.motion
            && let Some(actuator) = self.robot.actuators.get(which)
        {
            let owner = Owner::Actuator(&actuator.name);
            let slot = self.add_all(owner, &SLIDER_CRANK, Group::Geometry, &actuator.constants);
            self.actuators[which] =
                Some(Actuator { name: actuator.name.clone(), joint: index, variable: actuator.variable, slot });
        }
        self.frames.push(Frame {
            name: frame.name.clone(),
            antecedent: frame.antecedent,
            joint: frame.joint,
            motion: frame.motion,
            slots,
            home,
            limits: frame.limits,
        });
        Ok(())
    }

    fn markers(&mut self) -> Vec<Marker> {
        let markers = self.robot.markers.iter().map(|marker| {
            let position: [f64; 3] = marker.position.into();
            let slot = self.add_all(Owner::Marker(&marker.name), &MARKER, Group::Tool, &position);
            Marker { name: marker.name.clone(), frame: marker.frame, slot }
        });
        markers.collect()
    }
}

/// The fault of a frame whose coaxial frame is not compiled yet.
fn not_yet(frame: &robot::Frame) -> Fault {
    let message = format!("frame `{}` stands before the frame it is coaxial with", frame.name);
    let diagnostic = Diagnostic::error(message).remedy("declare it after that frame");
    Fault::new(&["frames", &frame.name, "coaxial"], diagnostic)
}
