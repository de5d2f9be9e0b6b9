//! Frames of a resolved robot and what moves them. Lengths in m, angles in rad.

use nalgebra::{Rotation3, Vector3};

use super::raw::JointKind;

/// Index of a frame in [`super::robot::Robot::frames`]; 0 is the base.
pub type FrameIndex = usize;

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
        /// Index in [`super::robot::Robot::variables`].
        index: usize,
        /// +1 or -1.
        direction: f64,
    },
    /// An actuator, by index in [`super::robot::Robot::actuators`].
    Actuator(usize),
    /// A coupling, by index in [`super::robot::Robot::couplings`].
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

impl Constants {
    /// From their values, in the order of their transforms.
    pub fn from_values([beta, gamma, b, alpha, d, theta, r]: [f64; 7]) -> Self {
        Self { beta, gamma, b, alpha, d, theta, r }
    }

    /// Rotation from the antecedent up to the frame's own z axis: Ry(beta) Rz(gamma) Rx(alpha).
    pub fn before_joint(&self) -> Rotation3<f64> {
        Rotation3::from_axis_angle(&Vector3::y_axis(), self.beta)
            * Rotation3::from_axis_angle(&Vector3::z_axis(), self.gamma)
            * Rotation3::from_axis_angle(&Vector3::x_axis(), self.alpha)
    }

    /// Their values, in the order of their transforms.
    pub fn values(&self) -> [f64; 7] {
        [self.beta, self.gamma, self.b, self.alpha, self.d, self.theta, self.r]
    }
}

/// Sine below which two axes count as parallel: 1 deg, well above what calibration changes.
pub const NEAR_PARALLEL: f64 = 0.017;

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
