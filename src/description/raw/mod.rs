//! A raw robot description: the image of the YAML file, in the file's own units, nothing checked beyond its
//! shape. Every field may be absent, so that one fault does not hide the next; [`super::resolve`] says what is missing.

use indexmap::IndexMap;
#[cfg(feature = "cli")]
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::Error;
use serde::{Deserialize, Deserializer, Serialize};

use super::units::Units;

fn absent<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}

/// A name in YAML may be written as a number (`1`).
#[cfg(feature = "cli")]
fn name(_: &mut SchemaGenerator) -> Schema {
    json_schema!({"type": ["string", "integer", "null"]})
}

#[cfg(feature = "cli")]
fn names(_: &mut SchemaGenerator) -> Schema {
    json_schema!({"type": ["array", "null"], "items": {"type": ["string", "integer"]}})
}

macro_rules! raw {
    ($(#[$meta:meta])* pub struct $name:ident { $($(#[$field_meta:meta])* $field:ident: $type:ty,)* }) => {
        $(#[$meta])*
        #[derive(Debug, Clone, Default, PartialEq, Deserialize, Serialize)]
        #[cfg_attr(feature = "cli", derive(JsonSchema))]
        #[serde(deny_unknown_fields, default)]
        pub struct $name { $($(#[$field_meta])* #[serde(skip_serializing_if = "absent")] pub $field: $type,)* }
    };
}

// After the macro, which they use.
mod elastic;
mod motion;
mod start;

pub use elastic::*;
pub use motion::*;
pub use start::*;

/// The version of a format that can be read: 1 or 2.
///
/// # Errors
/// Another number.
pub fn format_version<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<u32>, D::Error> {
    match Option::<u32>::deserialize(deserializer)? {
        Some(other) if !(1..=2).contains(&other) => {
            Err(D::Error::custom(format!("format {other} is not known: 1 and 2 are read here")))
        }
        version => Ok(version),
    }
}

raw! {
    /// A robot: what is declared of it. Everything else (kinematics, closure, error Jacobian, identifiable set) is derived.
    pub struct RawRobot {
        /// Version of this format: 2 where it is stated.
        #[serde(deserialize_with = "format_version")]
        #[cfg_attr(feature = "cli", schemars(range(min = 1, max = 2)))]
        format: Option<u32>,
        /// Display name.
        robot: Option<String>,
        /// Where the numbers come from; say here what is assumed.
        source: Option<String>,
        /// Units of every number in this file; SI where absent.
        units: Units,
        /// URDF file to start from, relative to this file, or a chain of it. Its joints become frames of the same names;
        /// `frames` below adds to them or overrides single keys. A URDF is always SI.
        #[serde(deserialize_with = "start::file_or_mapping")]
        #[cfg_attr(feature = "cli", schemars(schema_with = "start::file_or::<RawUrdf>"))]
        urdf: Option<RawUrdf>,
        /// File of kinematics as the Universal Robots driver of ROS reads and `ur_calibration` writes them, relative to this
        /// file, to start from. Its joints become frames of the names that they have there; the file is always SI.
        #[serde(deserialize_with = "start::file_or_mapping")]
        #[cfg_attr(feature = "cli", schemars(schema_with = "start::file_or::<RawUrKinematics>"))]
        ur_kinematics: Option<RawUrKinematics>,
        /// How the constants of `frames` are read; `khalil-kleinfinger` where absent.
        convention: Option<Convention>,
        /// The convention in which it was declared and is to be written; known to the program alone.
        #[serde(skip)]
        declared: Option<Convention>,
        /// Order of the actuated variables; by default the order in which frames and actuators name them.
        #[cfg_attr(feature = "cli", schemars(schema_with = "names"))]
        variables: Vec<String>,
        /// Frames by name. `0` is the base and is not declared.
        frames: IndexMap<String, RawFrame>,
        /// Joints that follow others: `6 = -1 * 5`, several terms joined by `+` or `-`. Behind it `(controller)` where no mechanism
        /// couples them, but the controller computes it: an error of the joint followed does then not pass on.
        couplings: Vec<String>,
        /// Closed loops by name.
        loops: IndexMap<String, RawLoop>,
        /// Limits of sums of joints: `q3 - q2: [-60, 90]`. A name is that of a variable, or else of a joint (by its frame),
        /// which may be passive or follow others.
        limits: IndexMap<String, [f64; 2]>,
        /// Boxes through which no link may pass, by name.
        keep_out: IndexMap<String, RawKeepOut>,
        /// Turns of the motor in a turn of its joint, by variable: what its motor does to a joint comes back with each of them.
        gear_ratios: IndexMap<String, f64>,
        /// Actuators that do not sit at their joint, by name.
        actuators: IndexMap<String, RawActuator>,
        /// Pose of the robot's base frame 0 in the measurement frame.
        base: RawPlacement,
        /// Tool centre point. By default the origin of the only frame that carries nothing.
        tool: RawTool,
        /// Measured points by name.
        markers: IndexMap<String, RawMarker>,
        /// Fixed points of the cell, in the measurement frame, from which distances are measured, by name.
        anchors: IndexMap<String, [f64; 3]>,
        /// Acceleration of gravity in base axes, m/s2 whatever the units; by default (0, 0, -9.81).
        gravity: Option<[f64; 3]>,
        /// Mass of each body, by the frame it moves with.
        bodies: IndexMap<String, RawBody>,
        /// Bodies that the tool can carry, by name: a column `payload` of the measurements says which it does. Campaigns can declare
        /// more.
        payloads: IndexMap<String, RawPayload>,
        /// Materials by name.
        materials: IndexMap<String, RawMaterial>,
        /// Beam cross-sections by name.
        sections: IndexMap<String, RawSection>,
        /// Elastic nodes by name: a point of a body. A frame's name stands for its origin on its own body.
        nodes: IndexMap<String, RawNode>,
        /// Beams by name, from node to node.
        beams: IndexMap<String, RawBeam>,
        /// Stiffness of joints, by the joint's frame.
        joint_stiffness: IndexMap<String, RawJointStiffness>,
        /// Stiffness of the pedestal under frame 0; rigid where absent.
        base_stiffness: Option<RawBaseStiffness>,
        /// Springs and gravity compensators between two bodies, by name.
        springs: IndexMap<String, RawSpring>,
        /// Effects that have been switched on.
        effects: Vec<RawEffect>,
        /// The range in which these were found, SI whatever the units.
        validity: Option<RawValidity>,
        /// Takagi-Sugeno compliance of the tool, in place of what gives above or added to it.
        fuzzy: Option<RawFuzzy>,
        /// Which parameters are free in calibration, how far they may be off.
        calibration: RawCalibration,
        /// Other parameters in which results are reported too, by the name of their convention and their own: each a sum of changes of
        /// the description's, `{2.r: 1, 4.alpha: 1100}`. Where lengths and angles go together it is a length, and the factor of an
        /// angle is its lever, in the file's unit of length for one rad.
        combinations: IndexMap<String, IndexMap<String, IndexMap<String, f64>>>,
    }
}

raw! {
    /// An effect that has been switched on.
    pub struct RawEffect {
        /// Its name in the catalogue of effects.
        effect: Option<String>,
        /// Where it sits: `joint:2`, `link:3`, `actuator:screw2`, `frame:4`, `base`, `tool`, `marker:m1`, `instrument`.
        site: Option<String>,
        /// Its parameters: amounts in SI, and what it is not linear in by name or number.
        parameters: IndexMap<String, RawAmount>,
        /// What a free curve goes with: `q3`, `own-load.q3`, `load.q3`, `move.q3`, `time`, `session-time`, `temperature`; of the instrument `range` and `height`.
        follows: Option<String>,
        /// A free curve of a joint.
        curve: Option<RawCurve>,
        /// Which of several effects that the readings could not tell apart this is.
        applied: Option<RawApplied>,
    }
}

raw! {
    /// A free curve: a natural cubic spline, constant beyond its ends.
    pub struct RawCurve {
        /// Increasing values of what it follows, SI.
        at: Vec<f64>,
        /// Amounts there, rad or m.
        amount: Vec<f64>,
    }
}

raw! {
    /// An effect that a diagnosis wrote in place of others which did as well.
    pub struct RawApplied {
        /// The effect written, `effect@site`.
        member: Option<String>,
        /// All that could not be told apart, itself included.
        tied: Vec<String>,
    }
}

raw! {
    /// Covariance of fitted parameters of the robot, base and sessions left out.
    pub struct RawFit {
        /// Their names.
        parameters: Vec<String>,
        /// Lower triangle of their covariance by rows, SI.
        covariance: Vec<Vec<f64>>,
        /// Standard deviation along x, y, z of what the fit left above the stated noise, m, in the axes of the measurements; of all
        /// that it left where no noise is stated.
        unexplained: [f64; 3],
    }
}

raw! {
    /// The range of the readings by which a description was fitted, and its effects found; outside it they are extrapolated.
    pub struct RawValidity {
        /// Least and greatest value of each variable, rad or m.
        joints: IndexMap<String, [f64; 2]>,
        /// Least and greatest size of the applied `force`, N, and `moment`, N.m, and mass of the `payload`, kg.
        loads: IndexMap<String, [f64; 2]>,
        /// From and to, s.
        time: Option<[f64; 2]>,
        /// From and to, as the campaign had it.
        temperature: Option<[f64; 2]>,
    }
}

/// A value of an effect's parameter.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
#[cfg_attr(feature = "cli", derive(JsonSchema))]
#[serde(
    untagged,
    expecting = "the value fits none of the forms that are accepted here; write a number, numbers as `[0.1, 0.2]`, or a word"
)]
pub enum RawAmount {
    /// A number, SI.
    Number(f64),
    /// Numbers, SI.
    Numbers(Vec<f64>),
    /// A word.
    Name(String),
}

impl RawAmount {
    /// The number, where it is one.
    pub fn number(&self) -> Option<f64> {
        match self {
            Self::Number(value) => Some(*value),
            Self::Numbers(_) | Self::Name(_) => None,
        }
    }
}

impl From<f64> for RawAmount {
    fn from(value: f64) -> Self {
        Self::Number(value)
    }
}

impl From<&str> for RawAmount {
    fn from(name: &str) -> Self {
        Self::Name(name.into())
    }
}

impl std::fmt::Display for RawAmount {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Number(value) => write!(f, "{value}"),
            Self::Numbers(values) => write!(f, "{values:?}"),
            Self::Name(name) => f.write_str(name),
        }
    }
}

raw! {
    /// Which parameters are free in calibration and how far they may be off. Parameters are named `<owner>.<symbol>`.
    pub struct RawCalibration {
        /// Parameters to free beyond the rule (`3.theta`).
        free: Vec<String>,
        /// Parameters to hold although the rule frees them.
        fixed: Vec<String>,
        /// How far a length is commonly off (one sigma); 1 mm where absent.
        length_tolerance: Option<f64>,
        /// How far an angle is commonly off (one sigma); 1 mrad where absent.
        angle_tolerance: Option<f64>,
        /// The same for single parameters.
        tolerances: IndexMap<String, f64>,
        /// Standard deviations of single parameters as an identification left them, in the file's units (of effects SI):
        /// `identify --save` writes them, and `identify --since` reads them.
        uncertainties: IndexMap<String, f64>,
        /// How well the fitted parameters were determined together, SI: `identify --save` writes it; `pose`, `solve`, `residuals` and
        /// `compensate` give the standard uncertainty of positions by it. Leave it out where values are changed by hand.
        fit: Option<RawFit>,
        /// Bounds of single parameters, in the file's units; the declared value lies within them.
        bounds: IndexMap<String, [f64; 2]>,
    }
}
