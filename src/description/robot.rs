//! A resolved robot description: SI units, names resolved to indices, every fault already reported.

use indexmap::IndexMap;
use nalgebra::Vector3;

use super::elastic::{Elastic, Payload};
pub use super::frame::{Constants, Frame, FrameIndex, Motion, NEAR_PARALLEL, branches};
use super::fuzzy::Input;
use super::parameters::{self, symbols};
use super::raw::{JointKind, LoopKind, Meet, RawEffect};
use crate::parameter::Kind;

/// Symbols of a frame's constants, in the order of their transforms.
pub const FRAME_SYMBOLS: [&str; 7] = symbols(&parameters::FRAME);
/// Symbols of a pose.
pub const PLACEMENT_SYMBOLS: [&str; 6] = symbols(&parameters::BASE);

/// A robot as declared. Lengths in m, angles in rad.
#[derive(Debug, Clone, PartialEq)]
pub struct Robot {
    /// Display name.
    pub name: String,
    /// Actuated variables, in the order of configuration vectors.
    pub variables: Vec<Variable>,
    /// Frames, each after its antecedent; the first is the base `0`.
    pub frames: Vec<Frame>,
    /// Joints that follow others, each after those it follows.
    pub couplings: Vec<Coupling>,
    /// Closed loops.
    pub loops: Vec<Loop>,
    /// Limits of sums of joints.
    pub limits: Vec<SumLimit>,
    /// Boxes through which no link may pass.
    pub keep_out: Vec<KeepOut>,
    /// Actuators away from their joint.
    pub actuators: Vec<SliderCrank>,
    /// Pose of the base frame in the measurement frame.
    pub base: Placement,
    /// Tool centre point.
    pub tool: Tool,
    /// Measured points.
    pub markers: Vec<Marker>,
    /// Fixed points in the measurement frame.
    pub anchors: IndexMap<String, Vector3<f64>>,
    /// Compliances, and what loads them.
    pub elastic: Elastic,
    /// Bodies that the tool can carry, by name.
    pub payloads: Vec<(String, Payload)>,
    /// Effects that have been switched on.
    pub effects: Vec<RawEffect>,
    /// Fuzzy compliance of the tool.
    pub fuzzy: Option<super::fuzzy::Fuzzy>,
    /// Springs whose stiffness depends on the configuration by fuzzy rules.
    pub spring_rules: Option<super::fuzzy::SpringRules>,
    /// What calibration may change.
    pub calibration: Calibration,
}

/// An actuated variable.
#[derive(Debug, Clone, PartialEq)]
pub struct Variable {
    /// Name.
    pub name: String,
    /// Angle of a revolute joint, or length of a prismatic joint or a stroke.
    pub is_angle: bool,
    /// Least and greatest value, rad or m.
    pub limits: Option<[f64; 2]>,
    /// Turns of the motor in a turn of the joint, where given.
    pub gear_ratio: Option<f64>,
}

impl Variable {
    /// What it measures.
    pub fn kind(&self) -> Kind {
        if self.is_angle { Kind::Angle } else { Kind::Length }
    }
}

/// `joint = sum of factor * joint`.
#[derive(Debug, Clone, PartialEq)]
pub struct Coupling {
    /// The joint that follows.
    pub joint: FrameIndex,
    /// The joints followed, with their factors.
    pub terms: Vec<(f64, FrameIndex)>,
    /// Whether the controller computes it from the joints it commands, so that errors of these do not pass on.
    pub is_of_controller: bool,
}

/// Limits of a sum of joints.
#[derive(Debug, Clone, PartialEq)]
pub struct SumLimit {
    /// The sum as written.
    pub name: String,
    /// Its terms with their factors.
    pub terms: Vec<(f64, Input)>,
    /// Angles, or lengths.
    pub is_angle: bool,
    /// Least and greatest value, rad or m.
    pub limits: [f64; 2],
}

/// A box through which no link may pass.
#[derive(Debug, Clone, PartialEq)]
pub struct KeepOut {
    /// Name.
    pub name: String,
    /// From and to along x, y, z of the base frame, m; infinite where open.
    pub space: [[f64; 2]; 3],
}

/// A closed loop.
#[derive(Debug, Clone, PartialEq)]
pub struct Loop {
    /// Name.
    pub name: String,
    /// The frames that meet.
    pub frames: [FrameIndex; 2],
    /// In the plane or in space.
    pub kind: LoopKind,
    /// What coincides.
    pub meet: Meet,
    /// Rough values of passive joints, rad or m.
    pub branch: Vec<(FrameIndex, f64)>,
    /// Values of actuated variables at which `branch` was read.
    pub at: Vec<(usize, f64)>,
    /// Gap allowed in an over-constrained loop, m; `None` where nothing is declared.
    pub gap: Option<f64>,
}

/// A linear actuator turning a joint through a triangle; see [`super::raw::RawActuator`] for the law.
#[derive(Debug, Clone, PartialEq)]
pub struct SliderCrank {
    /// Name.
    pub name: String,
    /// The joint it turns.
    pub joint: FrameIndex,
    /// The variable that is its length.
    pub variable: usize,
    /// Zero of the stroke, kappa, lambda, l1, l3.
    pub constants: [f64; 5],
}

/// A pose: position (m) and rotation vector (rad).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Placement {
    /// Position.
    pub position: Vector3<f64>,
    /// Rotation vector.
    pub rotation: Vector3<f64>,
}

/// The tool centre point.
#[derive(Debug, Clone, PartialEq)]
pub struct Tool {
    /// The frame it moves with.
    pub frame: FrameIndex,
    /// Its pose in that frame.
    pub placement: Placement,
}

/// A measured point.
#[derive(Debug, Clone, PartialEq)]
pub struct Marker {
    /// Name.
    pub name: String,
    /// The frame it moves with.
    pub frame: FrameIndex,
    /// Position in that frame, m.
    pub position: Vector3<f64>,
}

/// A sum of changes of parameters.
#[derive(Debug, Clone, PartialEq)]
pub struct Combination {
    /// What it measures.
    pub kind: Kind,
    /// Parameters by name, and their factors, SI.
    pub of: Vec<(String, f64)>,
}

/// What calibration may change; parameters by name.
#[derive(Debug, Clone, PartialEq)]
pub struct Calibration {
    /// Freed beyond the rule.
    pub free: Vec<String>,
    /// Held although the rule frees them.
    pub fixed: Vec<String>,
    /// Common error of a length, one sigma, m.
    pub length_tolerance: f64,
    /// Common error of an angle, one sigma, rad.
    pub angle_tolerance: f64,
    /// Sums of changes in which results are reported too, by convention.
    pub combinations: IndexMap<String, IndexMap<String, Combination>>,
    /// Common error of single parameters, SI.
    pub tolerances: IndexMap<String, f64>,
    /// Bounds of single parameters, SI.
    pub bounds: IndexMap<String, [f64; 2]>,
}

impl Robot {
    /// Index of a frame by name.
    pub fn frame(&self, name: &str) -> Option<FrameIndex> {
        self.frames.iter().position(|frame| frame.name == name)
    }

    /// The body of a frame: the frame to which it is fixed.
    pub fn body(&self, mut frame: FrameIndex) -> FrameIndex {
        while frame != 0 && self.frames[frame].joint == JointKind::Fixed {
            frame = self.frames[frame].antecedent;
        }
        frame
    }
}
