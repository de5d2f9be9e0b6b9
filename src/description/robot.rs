//! Second age of a robot description: SI units, names resolved to indices, every fault already told.

use indexmap::IndexMap;
use nalgebra::Vector3;

use super::elastic::Elastic;
use super::raw::{JointKind, LoopKind, Meet, RawEffect};

/// Index of a frame in [`Robot::frames`]; 0 is the base.
pub type FrameIndex = usize;

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
    /// What gives under load, and what loads it.
    pub elastic: Elastic,
    /// Effects that have been switched on.
    pub effects: Vec<RawEffect>,
    /// Fuzzy compliance of the tool.
    pub fuzzy: Option<super::fuzzy::Fuzzy>,
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
}

/// A frame in its antecedent.
#[derive(Debug, Clone, PartialEq)]
pub struct Frame {
    /// Name.
    pub name: String,
    /// The frame it is placed in (meaningless for the base).
    pub antecedent: FrameIndex,
    /// Kind of joint.
    pub joint: JointKind,
    /// What moves the joint.
    pub motion: Motion,
    /// Constants.
    pub constants: Constants,
    /// The frame whose beta, gamma, b, alpha and d it shares.
    pub coaxial: Option<FrameIndex>,
    /// Calibrated zero of the joint variable, rad or m.
    pub offset: f64,
    /// Limits of the joint variable.
    pub limits: Option<[f64; 2]>,
}

/// What moves a joint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Motion {
    /// Nothing.
    Fixed,
    /// An actuated variable, counted in a direction of +1 or -1.
    Variable {
        /// Index in [`Robot::variables`].
        index: usize,
        /// +1 or -1.
        direction: f64,
    },
    /// An actuator, by index in [`Robot::actuators`].
    Actuator(usize),
    /// A coupling, by index in [`Robot::couplings`].
    Coupling(usize),
    /// The closed loop it belongs to.
    Passive,
}

/// Constants that place a frame in its antecedent: Ry(beta) Rz(gamma) Tz(b) Rx(alpha) Tx(d) Rz(theta) Tz(r). Angles in
/// radians, lengths in metres.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Constants {
    /// Rotation about the antecedent's y, applied first.
    pub beta: f64,
    /// Rotation about z.
    pub gamma: f64,
    /// Translation along z.
    pub b: f64,
    /// Rotation about x.
    pub alpha: f64,
    /// Translation along x.
    pub d: f64,
    /// Rotation about the new z.
    pub theta: f64,
    /// Translation along the new z.
    pub r: f64,
}

/// `joint = sum of factor * joint`.
#[derive(Debug, Clone, PartialEq)]
pub struct Coupling {
    /// The joint that follows.
    pub joint: FrameIndex,
    /// The joints followed, with their factors.
    pub terms: Vec<(f64, FrameIndex)>,
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
    /// Gap allowed in an over-constrained loop, m.
    pub gap: f64,
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

/// Symbols of [`SliderCrank::constants`], in their order.
pub const SLIDER_CRANK_SYMBOLS: [&str; 5] = ["stroke", "kappa", "lambda", "l1", "l3"];

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
    /// Common error of single parameters, SI.
    pub tolerances: IndexMap<String, f64>,
    /// Bounds of single parameters, SI.
    pub bounds: IndexMap<String, [f64; 2]>,
}

/// Symbols of a frame's constants, in the order of their transforms.
pub const FRAME_SYMBOLS: [&str; 7] = ["beta", "gamma", "b", "alpha", "d", "theta", "r"];
/// Symbols of a pose.
pub const PLACEMENT_SYMBOLS: [&str; 6] = ["x", "y", "z", "rx", "ry", "rz"];

/// Whether a symbol of a frame, a slider-crank or a pose is an angle (else a length).
pub fn is_angle(symbol: &str) -> bool {
    matches!(symbol, "beta" | "gamma" | "alpha" | "theta" | "kappa" | "lambda" | "rx" | "ry" | "rz")
}

impl Robot {
    /// Index of a frame by name.
    pub fn frame(&self, name: &str) -> Option<FrameIndex> {
        self.frames.iter().position(|frame| frame.name == name)
    }
}

/// Frames between two frames and their common ancestor (itself apart), from the ancestor on: those towards `a`, then
/// those towards `b`.
pub fn branches(frames: &[Frame], a: FrameIndex, b: FrameIndex) -> [Vec<FrameIndex>; 2] {
    let up = |mut index: FrameIndex| {
        let mut path = vec![index];
        while index != 0 {
            index = frames[index].antecedent;
            path.push(index);
        }
        path
    };
    let (up_a, up_b) = (up(a), up(b));
    let side = |own: &[FrameIndex], other: &[FrameIndex]| {
        let mut side: Vec<FrameIndex> = own.iter().copied().take_while(|index| !other.contains(index)).collect();
        side.reverse();
        side
    };
    [side(&up_a, &up_b), side(&up_b, &up_a)]
}
