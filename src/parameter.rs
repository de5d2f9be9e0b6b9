//! Named parameters: everything about a robot that could be off, with its nominal value, bounds and tolerance.

use std::collections::HashMap;

/// Position of a parameter in its [`Registry`], and of its value in a vector of values.
pub type Slot = usize;

/// What a parameter measures; values are in the SI unit named here.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// m
    Length,
    /// rad
    Angle,
    /// m/N: of a translational spring; 0 is rigid.
    LinearCompliance,
    /// rad/(N.m): of a rotational spring; 0 is rigid.
    RotationalCompliance,
    /// N/m
    LinearStiffness,
    /// N.m/rad
    RotationalStiffness,
    /// Pa
    Pressure,
    /// kg
    Mass,
    /// Anything else, with its SI unit.
    Other(&'static str),
}

impl Kind {
    /// SI unit of a value.
    pub fn unit(self) -> &'static str {
        match self {
            Self::Length => "m",
            Self::Angle => "rad",
            Self::LinearCompliance => "m/N",
            Self::RotationalCompliance => "rad/(N.m)",
            Self::LinearStiffness => "N/m",
            Self::RotationalStiffness => "N.m/rad",
            Self::Pressure => "Pa",
            Self::Mass => "kg",
            Self::Other(unit) => unit,
        }
    }

    /// Whether it is a compliance.
    pub fn is_compliance(self) -> bool {
        matches!(self, Self::LinearCompliance | Self::RotationalCompliance)
    }

    /// Whether it is a stiffness.
    pub fn is_stiffness(self) -> bool {
        matches!(self, Self::LinearStiffness | Self::RotationalStiffness)
    }

    /// Whether it is that of a spring.
    pub fn is_spring(self) -> bool {
        self.is_compliance() || self.is_stiffness()
    }

    /// What the inverse of such a value measures.
    pub fn inverse(self) -> Self {
        match self {
            Self::LinearCompliance => Self::LinearStiffness,
            Self::RotationalCompliance => Self::RotationalStiffness,
            Self::LinearStiffness => Self::LinearCompliance,
            Self::RotationalStiffness => Self::RotationalCompliance,
            other => other,
        }
    }
}

/// What a parameter describes: calibration keeps the instrument's frame and the tool apart from the robot itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Group {
    /// Pose of the base in the measurement frame.
    Base,
    /// Tool centre point and markers.
    Tool,
    /// What readings refer to in addition to the robot: fixed points, zeros, scales.
    Arrangement,
    /// The robot's own constants.
    Geometry,
    /// Compliance and what loads it: springs, beams, masses.
    Elastic,
    /// Amounts of the effects that have been switched on.
    Effect,
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
    /// Value in the description, SI.
    pub nominal: f64,
    /// Least and greatest value, infinite where unbounded.
    pub bounds: [f64; 2],
    /// How far it is commonly off (one sigma), SI.
    pub tolerance: f64,
    /// Whether calibration of its group frees it.
    pub free: bool,
    /// A length of a linkage that only closes a loop: given up first where it and others are nearly dependent.
    pub closing: bool,
    /// Written and reported as its inverse: a stiffness that is computed with as a compliance, or the reverse.
    pub inverted: bool,
}

impl Parameter {
    /// A value as it is reported: its inverse where it is [`Parameter::inverted`].
    ///
    /// ```
    /// let model = elastogeo::files::load_robot("kuka-ir663")?.model;
    /// let spring = &model.registry[model.registry.slot("joint2.kar").expect("a spring")];
    /// // Declared as a stiffness, computed with as a compliance.
    /// assert!((spring.shown(spring.nominal) - 1.72e6).abs() < 1.0); // N.m/rad
    /// assert_eq!(spring.shown_kind().unit(), "N.m/rad");
    /// # Ok::<(), elastogeo::Error>(())
    /// ```
    pub fn shown(&self, value: f64) -> f64 {
        if self.inverted { 1.0 / value } else { value }
    }

    /// Half width of an interval of a reported value, from that of the value itself (first order).
    pub fn shown_width(&self, value: f64, width: f64) -> f64 {
        if self.inverted { width / (value * value) } else { width }
    }

    /// Whether a value is a bound that the description wants: of a spring neither rigid nor free.
    pub fn is_own_bound(&self, value: f64) -> bool {
        self.bounds.contains(&value) && (self.group != Group::Elastic || value != 0.0)
    }

    /// What reported values measure.
    pub fn shown_kind(&self) -> Kind {
        if self.inverted { self.kind.inverse() } else { self.kind }
    }
}

/// All parameters of a model, in a fixed order: base, frames with the actuators that turn them, tool, markers, what is
/// elastic, and effects that are switched on.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Registry {
    parameters: Vec<Parameter>,
    slots: HashMap<String, Slot>,
}

impl Registry {
    /// Adds a parameter; returns its slot.
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
    ///
    /// ```
    /// let model = elastogeo::files::load_robot("kuka-kr270")?.model;
    /// let slot = model.registry.slot("3.d").expect("the length of the lower arm");
    /// assert!((model.registry[slot].nominal - 1.25).abs() < 1e-12); // m
    /// assert_eq!(model.registry.nominal()[slot], model.registry[slot].nominal);
    /// # Ok::<(), elastogeo::Error>(())
    /// ```
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
