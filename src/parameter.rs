//! Named parameters: everything about a robot that could be off, with its nominal value, bounds and tolerance.

use std::collections::HashMap;

/// Position of a parameter in its [`Registry`], and of its value in a vector of values.
pub type Slot = usize;

/// What a parameter measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// m
    Length,
    /// rad
    Angle,
}

/// What a parameter describes: calibration keeps the instrument's frame and the tool apart from the robot itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Group {
    /// Pose of the base in the measurement frame.
    Base,
    /// Tool centre point and markers.
    Tool,
    /// The robot's own constants.
    Geometry,
}

/// A named parameter.
#[derive(Debug, Clone, PartialEq)]
pub struct Parameter {
    /// `<owner>.<symbol>`.
    pub name: String,
    /// What it measures.
    pub kind: Kind,
    /// What it describes.
    pub group: Group,
    /// Value in the description, m or rad.
    pub nominal: f64,
    /// Least and greatest value, infinite where unbounded.
    pub bounds: [f64; 2],
    /// How far it is commonly off (one sigma), m or rad.
    pub tolerance: f64,
    /// Whether calibration of the geometry frees it.
    pub free: bool,
    /// A length of a linkage that only closes a loop: given up first where it and others are nearly dependent.
    pub closing: bool,
}

/// All parameters of a model, in a fixed order: base, frames with the actuators that turn them, tool, markers.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Registry {
    parameters: Vec<Parameter>,
    slots: HashMap<String, Slot>,
}

impl Registry {
    /// Adds a parameter and tells its slot.
    pub fn add(&mut self, parameter: Parameter) -> Slot {
        let slot = self.parameters.len();
        self.slots.insert(parameter.name.clone(), slot);
        self.parameters.push(parameter);
        slot
    }

    /// All parameters by slot.
    pub fn all(&self) -> &[Parameter] {
        &self.parameters
    }

    /// All parameters by slot, to be changed while the model is built.
    pub fn all_mut(&mut self) -> &mut [Parameter] {
        &mut self.parameters
    }

    /// Slot of a name.
    pub fn slot(&self, name: &str) -> Option<Slot> {
        self.slots.get(name).copied()
    }

    /// Nominal values by slot.
    pub fn nominal(&self) -> Vec<f64> {
        self.parameters.iter().map(|parameter| parameter.nominal).collect()
    }
}

impl std::ops::Index<Slot> for Registry {
    type Output = Parameter;
    fn index(&self, slot: Slot) -> &Parameter {
        &self.parameters[slot]
    }
}
