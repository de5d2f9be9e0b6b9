//! What `check` finds: a description, resolved and compiled. SI.

use indexmap::IndexMap;
use serde::Serialize;

use crate::description::raw::{JointKind, RawBody, RawRobot};
use crate::description::robot::{FRAME_SYMBOLS, Motion, Variable};
use crate::model::{Model, Stage};
use crate::parameter::Parameter;

/// A variable.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct VariableSummary {
    /// Name.
    pub name: String,
    /// `rad` or `m`: of the limits.
    pub unit: &'static str,
    /// Least and greatest value; `None` where none are given.
    pub limits: Option<[f64; 2]>,
}

/// A frame.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FrameSummary {
    /// Name.
    pub name: String,
    /// The frame from which it is placed.
    pub antecedent: String,
    /// Kind of its joint.
    pub joint: JointKind,
    /// Variable, actuator, coupling, `passive` or `fixed`.
    pub moved_by: String,
    /// Khalil-Kleinfinger constants.
    pub constants: IndexMap<&'static str, f64>,
}

/// A parameter of the registry.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ParameterSummary {
    /// Name.
    pub name: String,
    /// `rad` of angles, `m` of everything else.
    pub unit: &'static str,
    /// Value of the description as it is computed with, in the SI unit of what it measures.
    pub nominal: f64,
    /// Whether calibration of its group estimates it.
    pub free: bool,
    /// How far it is commonly off, one sigma, in the same unit as the value.
    pub tolerance: f64,
}

/// Mass of a body.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct BodySummary {
    /// Mass, kg; 0 where none is given.
    pub mass: f64,
    /// Centre of mass, m; at the origin where none is given.
    pub com: [f64; 3],
}

/// What the description declares as elastic, by name.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ElasticSummary {
    /// Bodies declared under `bodies:`, the keys of `masses`.
    pub bodies_with_mass: Vec<String>,
    /// Mass and centre of mass of each, kg and m, in the frame it moves with.
    pub masses: IndexMap<String, BodySummary>,
    /// Beams.
    pub beams: Vec<String>,
    /// Joints with springs.
    pub joint_stiffness: Vec<String>,
    /// Springs between bodies.
    pub springs: Vec<String>,
    /// Effects of the catalogue that are switched on, by entry under `effects:`.
    pub effects_switched_on: Vec<String>,
}

/// A fuzzy compliance.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FuzzySummary {
    /// Joints and variables on which it depends.
    pub inputs: Vec<String>,
    /// Marker whose displacement it gives; `None` is the tool centre point.
    pub at: Option<String>,
    /// Frame whose axes the components have; `None` is the base.
    pub axes: Option<String>,
    /// Whether it adds to springs and beams; else it stands in their place.
    pub adds: bool,
    /// Number of rules by component.
    pub rules: IndexMap<String, usize>,
    /// Number of rules by spring.
    pub springs: IndexMap<String, usize>,
}

/// A robot.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RobotSummary {
    /// Name of the robot.
    pub robot: String,
    /// Number of actuated variables.
    pub degrees_of_freedom: usize,
    /// Actuated variables, in the order of configurations.
    pub variables: Vec<VariableSummary>,
    /// Frames but the base, each after its antecedent.
    pub frames: Vec<FrameSummary>,
    /// Names of the closed loops.
    pub loops: Vec<String>,
    /// Limits of passive joints, of those that follow others, and of sums of joints.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub other_limits: Vec<VariableSummary>,
    /// Frame that carries the tool.
    pub tool: String,
    /// Tool centre point in the tool's frame, m, then the rotation vector of its axes, rad.
    pub tool_offset: [f64; 6],
    /// Acceleration of gravity, base axes, m/s2.
    pub gravity: [f64; 3],
    /// Names of the markers.
    pub markers: Vec<String>,
    /// All parameters of the model.
    pub parameters: Vec<ParameterSummary>,
    /// Compliances, and what loads them.
    pub elastic: ElasticSummary,
    /// The fuzzy compliance, where the description has one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fuzzy: Option<FuzzySummary>,
    /// Agreement with a file of the same meaning.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub snapshot: Option<SnapshotAgreement>,
}

/// Agreement with a snapshot.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SnapshotAgreement {
    /// Path of the snapshot.
    pub file: String,
    /// Whether the snapshot says what the description does now.
    pub agrees: bool,
}

fn moved_by(model: &Model, index: usize) -> String {
    let frame = &model.frames[index];
    match frame.motion {
        Motion::Fixed => "fixed".into(),
        Motion::Variable { index, direction } => {
            format!("{}{}", if direction < 0.0 { "-" } else { "" }, model.variables[index].name)
        }
        Motion::Actuator(which) => {
            let actuator = &model.actuators[which];
            format!("{} ({})", actuator.name, model.variables[actuator.variable].name)
        }
        Motion::Coupling(which) => {
            let terms: Vec<String> = model.couplings[which]
                .iter()
                .map(|(factor, joint)| format!("{factor} * {}", model.frames[*joint].name))
                .collect();
            terms.join(" + ")
        }
        Motion::Passive => "passive".into(),
    }
}

/// Limits that are not those of a variable.
fn other_limits(model: &Model) -> Vec<VariableSummary> {
    let summary = |name: &str, is_angle: bool, limits: [f64; 2]| VariableSummary {
        name: name.into(),
        unit: if is_angle { "rad" } else { "m" },
        limits: Some(limits),
    };
    let joints = model.frames.iter().filter(|frame| !matches!(frame.motion, Motion::Variable { .. } | Motion::Fixed));
    let joints =
        joints.filter_map(|frame| Some(summary(&frame.name, frame.joint == JointKind::Revolute, frame.limits?)));
    joints.chain(model.limits.iter().map(|sum| summary(&sum.name, sum.is_angle, sum.limits))).collect()
}

/// Masses of the bodies, kg and m.
fn masses(raw: &RawRobot) -> IndexMap<String, BodySummary> {
    let (length, mass) = (raw.units.length.factor(), raw.units.mass.factor());
    let summary = |(name, body): (&String, &RawBody)| {
        let com = body.com.unwrap_or_default().map(|value| value * length);
        (name.clone(), BodySummary { mass: body.mass.unwrap_or_default() * mass, com })
    };
    raw.bodies.iter().map(summary).collect()
}

impl RobotSummary {
    /// Of a description and its model.
    pub fn new(model: &Model, raw: &RawRobot) -> Self {
        let si = |is_angle: bool| if is_angle { "rad" } else { "m" };
        let variable = |v: &Variable| VariableSummary { name: v.name.clone(), unit: si(v.is_angle), limits: v.limits };
        let frame = |index: usize| {
            let frame = &model.frames[index];
            let constants = FRAME_SYMBOLS.into_iter().zip(frame.slots);
            FrameSummary {
                name: frame.name.clone(),
                antecedent: model.frames[frame.antecedent].name.clone(),
                joint: frame.joint,
                moved_by: moved_by(model, index),
                constants: constants.map(|(symbol, slot)| (symbol, model.registry[slot].nominal)).collect(),
            }
        };
        let loops = model.stages.iter().filter_map(|s| if let Stage::Loops(g) = s { Some(&g.loops) } else { None });
        let parameter = |p: &Parameter| ParameterSummary {
            name: p.name.clone(),
            unit: p.kind.unit(),
            nominal: p.nominal,
            free: p.free,
            tolerance: p.tolerance,
        };
        Self {
            robot: model.name.clone(),
            degrees_of_freedom: model.variables.len(),
            variables: model.variables.iter().map(variable).collect(),
            frames: (1..model.frames.len()).map(frame).collect(),
            loops: loops.flatten().map(|l| l.name.clone()).collect(),
            other_limits: other_limits(model),
            tool: model.frames[model.tool.0].name.clone(),
            tool_offset: std::array::from_fn(|k| model.registry[model.tool.1 + k].nominal),
            gravity: model.structure.gravity.into(),
            markers: model.markers.iter().map(|m| m.name.clone()).collect(),
            parameters: model.registry.all().iter().map(parameter).collect(),
            elastic: ElasticSummary {
                bodies_with_mass: raw.bodies.keys().cloned().collect(),
                masses: masses(raw),
                beams: raw.beams.keys().cloned().collect(),
                joint_stiffness: raw.joint_stiffness.keys().cloned().collect(),
                springs: raw.springs.keys().cloned().collect(),
                effects_switched_on: raw.effects.iter().filter_map(|e| e.effect.clone()).collect(),
            },
            fuzzy: raw.fuzzy.as_ref().map(|fuzzy| FuzzySummary {
                inputs: fuzzy.inputs.clone(),
                at: fuzzy.at.clone(),
                adds: fuzzy.adds,
                axes: fuzzy.axes.clone(),
                rules: fuzzy.components.iter().map(|(name, own)| (name.clone(), own.rules())).collect(),
                springs: fuzzy.springs.iter().map(|(name, own)| (name.clone(), own.rules())).collect(),
            }),
            snapshot: None,
        }
    }
}
