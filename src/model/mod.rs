//! Third age of a robot: an immutable model, compiled from a resolved description.
//!
//! The model holds structure (tree, what moves each joint, loops, order of evaluation) and the parameter registry; it
//! holds no values but nominal ones. Values travel beside it as one vector by slot.

mod assemble;
mod beams;
mod bounds;
mod build;
mod fault;
mod free;
mod loops;
mod rewrite;
mod spanning;
mod structure;

pub use bounds::contradictions;
pub use build::build;
pub use fault::Fault;
pub use loops::{LoopGroup, LoopPlan, Stage};
pub use rewrite::{with_fuzzy, with_values};
pub use structure::{Edge, MassElement, Spot, Structure, Vertex};

use crate::description::fuzzy::Input;
use crate::description::raw::{JointKind, RawEffect};
use crate::description::robot::{FrameIndex, Motion, Variable};
use crate::parameter::{Group, Kind, Parameter, Registry, Slot};
use indexmap::IndexMap;
use nalgebra::Vector3;

/// A compiled robot. Frames are in the order of [`crate::description::robot::Robot::frames`].
#[derive(Debug, Clone)]
pub struct Model {
    /// Display name.
    pub name: String,
    /// Actuated variables in the order of configuration vectors.
    pub variables: Vec<Variable>,
    /// Frames, each after its antecedent; the first is the base.
    pub frames: Vec<Frame>,
    /// Slider-cranks.
    pub actuators: Vec<Actuator>,
    /// Terms of each coupling.
    pub couplings: Vec<Vec<(f64, FrameIndex)>>,
    /// Joints that are not driven by a variable of their own, in the order in which they can be evaluated.
    pub stages: Vec<Stage>,
    /// First of the six slots of the base's pose in the measurement frame.
    pub base: Slot,
    /// Frame of the tool centre point, and the first of its six slots.
    pub tool: (FrameIndex, Slot),
    /// Measured points.
    pub markers: Vec<Marker>,
    /// Fixed points in the measurement frame, m.
    pub anchors: IndexMap<String, Vector3<f64>>,
    /// What gives under load, and what loads it.
    pub structure: Structure,
    /// Effects that have been switched on.
    pub effects: Vec<SwitchedOn>,
    /// Fuzzy compliance of the tool.
    pub fuzzy: Option<crate::description::fuzzy::Fuzzy>,
    /// All parameters.
    pub registry: Registry,
}

/// An effect that has been switched on.
#[derive(Debug, Clone)]
pub struct SwitchedOn {
    /// Name, site, parameters in SI.
    pub entry: RawEffect,
    /// Slots of its parameters by symbol, `effect@site.symbol` in the registry. A parameter that the model has anyway
    /// (`joint2.krr`) is not among them: the entry shifts it.
    pub slots: IndexMap<String, Slot>,
}

/// A frame of the model.
#[derive(Debug, Clone)]
pub struct Frame {
    /// Name.
    pub name: String,
    /// The frame it is placed in.
    pub antecedent: FrameIndex,
    /// Kind of joint.
    pub joint: JointKind,
    /// What moves it.
    pub motion: Motion,
    /// Slots of beta, gamma, b, alpha, d, theta, r; the first five may be shared with a coaxial frame.
    pub slots: [Slot; 7],
    /// Declared constant of the moving coordinate (theta or r): its parameter's value less this is the joint's zero.
    pub home: f64,
    /// Limits of the joint variable.
    pub limits: Option<[f64; 2]>,
}

/// Position of theta in [`Frame::slots`].
pub const THETA: usize = 5;
/// Position of r in [`Frame::slots`].
pub const R: usize = 6;

impl Frame {
    /// Slot of the coordinate that moves: theta, or r of a prismatic joint.
    pub fn moving_slot(&self) -> Slot {
        self.slots[if self.joint == JointKind::Prismatic { R } else { THETA }]
    }

    /// Whether the frame moves in its antecedent.
    pub fn moves(&self) -> bool {
        self.joint != JointKind::Fixed
    }
}

/// A slider-crank: the joint it turns, its variable, and the first of its slots (stroke, kappa, lambda, l1, l3).
#[derive(Debug, Clone)]
pub struct Actuator {
    /// Name.
    pub name: String,
    /// Joint turned.
    pub joint: FrameIndex,
    /// Variable.
    pub variable: usize,
    /// First slot.
    pub slot: Slot,
}

/// A measured point: its frame and the first of its three slots.
#[derive(Debug, Clone)]
pub struct Marker {
    /// Name.
    pub name: String,
    /// Frame.
    pub frame: FrameIndex,
    /// First slot.
    pub slot: Slot,
}

impl Model {
    /// Frames from the first after the base to `frame`.
    pub fn path(&self, frame: FrameIndex) -> Vec<FrameIndex> {
        let mut path = Vec::new();
        let mut index = frame;
        while index != 0 {
            path.push(index);
            index = self.frames[index].antecedent;
        }
        path.reverse();
        path
    }

    /// Frame by name.
    pub fn frame(&self, name: &str) -> Option<FrameIndex> {
        self.frames.iter().position(|frame| frame.name == name)
    }

    /// Marker by name.
    pub fn marker(&self, name: &str) -> Option<usize> {
        self.markers.iter().position(|marker| marker.name == name)
    }

    /// Whether rules stand in the place of what springs and beams give.
    pub fn is_by_rules(&self) -> bool {
        self.fuzzy.as_ref().is_some_and(|fuzzy| !fuzzy.adds)
    }

    /// Name of what a compliance depends on, and whether it is an angle.
    pub fn input(&self, of: Input) -> (&str, bool) {
        match of {
            Input::Variable(k) => (&self.variables[k].name, self.variables[k].is_angle),
            Input::Joint(k) => (&self.frames[k].name, self.frames[k].joint == JointKind::Revolute),
        }
    }

    /// Middle of the limits of each variable, zero where it has none.
    pub fn middle(&self) -> Vec<f64> {
        let middle =
            |limits: [f64; 2]| if limits.iter().all(|l| l.is_finite()) { 0.5 * (limits[0] + limits[1]) } else { 0.0 };
        self.variables.iter().map(|variable| variable.limits.map_or(0.0, middle)).collect()
    }

    /// Switches an effect on: its parameters join the registry.
    pub fn switch_on(&mut self, entry: RawEffect) {
        let text = |text: &Option<String>| text.clone().unwrap_or_default();
        let mut owner = format!("{}@{}", text(&entry.effect), text(&entry.site));
        let alike = |known: &&SwitchedOn| known.entry.effect == entry.effect && known.entry.site == entry.site;
        let before = self.effects.iter().filter(alike).count();
        if before > 0 {
            owner += &format!("#{}", before + 1);
        }
        let own = entry.parameters.iter().filter(|(symbol, _)| self.registry.slot(symbol).is_none());
        let own: Vec<(String, f64)> = own.map(|(symbol, value)| (symbol.clone(), *value)).collect();
        let add = |(symbol, value): (String, f64)| {
            let parameter = Parameter {
                name: format!("{owner}.{symbol}"),
                kind: Kind::Other("SI"),
                group: Group::Effect,
                nominal: value,
                bounds: [f64::NEG_INFINITY, f64::INFINITY],
                tolerance: 1.0,
                free: false,
                closing: false,
                inverted: false,
            };
            (symbol, self.registry.add(parameter))
        };
        let slots = own.into_iter().map(add).collect();
        self.effects.push(SwitchedOn { entry, slots });
    }

    /// Values of this model from those of the model before effects were switched on.
    #[must_use]
    pub fn completed(&self, values: &[f64]) -> Vec<f64> {
        let added = self.registry.all().iter().skip(values.len()).map(|parameter| parameter.nominal);
        values.iter().copied().chain(added).collect()
    }

    /// Slots of the geometry that the description's rule frees.
    pub fn free_slots(&self) -> Vec<Slot> {
        self.free_where(|group| group != Group::Elastic)
    }

    /// Slots of what gives and what loads it that the description declares identifiable.
    pub fn elastic_slots(&self) -> Vec<Slot> {
        self.free_where(|group| group == Group::Elastic)
    }

    fn free_where(&self, of: impl Fn(Group) -> bool) -> Vec<Slot> {
        let all = self.registry.all().iter().enumerate();
        all.filter(|(_, parameter)| parameter.free && of(parameter.group)).map(|(slot, _)| slot).collect()
    }
}
