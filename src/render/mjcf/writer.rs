//! The text of a model, and what several of its parts are written with.

use std::fmt::Write;

use nalgebra::{UnitQuaternion, Vector3};

use super::scale::Scale;
use crate::description::frame::{Frame, FrameIndex};
use crate::description::khalil_kleinfinger::Isometry;
use crate::description::robot::Robot;
use crate::kinematics::Placements;
use crate::render::diagnostics::is_active;

/// A model as far as it is written.
pub(super) struct Writer<'a> {
    pub robot: &'a Robot,
    pub scale: Scale,
    /// Where it starts, with loops closed.
    pub start: &'a Placements,
    pub out: String,
    /// What is not written.
    pub lost: Vec<String>,
    /// Start of each joint written, springs included, in the order of MuJoCo's `qpos`.
    pub qpos: Vec<f64>,
}

impl<'a> Writer<'a> {
    pub fn new(robot: &'a Robot, start: &'a Placements) -> Self {
        let scale = Scale::of(robot);
        Self { robot, scale, start, out: String::new(), lost: Vec::new(), qpos: Vec::new() }
    }

    pub fn line(&mut self, depth: usize, text: impl AsRef<str>) {
        let _ = writeln!(self.out, "{:1$}{2}", "", 2 * depth, text.as_ref());
    }

    pub fn name(&self, frame: FrameIndex) -> String {
        escaped(&self.robot.frames[frame].name)
    }

    /// Constants of a frame in its antecedent, of which it may share some.
    pub fn constants(&self, frame: &Frame) -> Isometry {
        let mut constants = frame.constants;
        if let Some(shared) = frame.coaxial.and_then(|index| self.robot.frames.get(index)) {
            let (theta, r) = (constants.theta, constants.r);
            constants = shared.constants;
            (constants.theta, constants.r) = (theta, r);
        }
        constants.isometry()
    }
}

/// Numbers of an attribute.
pub(super) fn numbers(all: &[f64]) -> String {
    all.iter().map(f64::to_string).collect::<Vec<_>>().join(" ")
}

pub(super) fn triple(vector: &Vector3<f64>) -> String {
    numbers(vector.as_slice())
}

/// `pos` and `quat` of a displacement.
pub(super) fn placed(at: &Isometry) -> String {
    let q = UnitQuaternion::from_rotation_matrix(&at.rotation);
    format!("pos=\"{}\" quat=\"{} {} {} {}\"", triple(&at.translation.vector), q.w, q.i, q.j, q.k)
}

/// Text as it stands within an attribute; what XML cannot hold is replaced.
pub(super) fn escaped(text: &str) -> String {
    let text: String = text.chars().map(|c| if is_active(c) { '_' } else { c }).collect();
    crate::description::urdf::escaped(&text)
}
