//! A model's constants with values put in: what closures of loops and placements of frames are computed from.
//!
//! Frames are placed by Khalil and Kleinfinger (1986): Ry(beta) Rz(gamma) Tz(b) Rx(alpha) Tx(d) Rz(theta) Tz(r); m and rad.

use nalgebra::{Rotation3, Translation3, Vector3};

use super::assembly_error::AssemblyError;
use super::slider_crank::slider_crank;
use super::transform::Transform;
use crate::description::raw::JointKind;
use crate::description::robot::{FrameIndex, Motion};
use crate::model::{Frame, Model, Stage};
use crate::parameter::Slot;

/// Constant part of a frame's placement, and the local axes of its constants.
#[derive(Debug, Clone, Copy)]
pub(super) struct FrameConstants {
    /// Ry(beta) Rz(gamma) Tz(b) Rx(alpha) Tx(d), with the part of Rz(theta) Tz(r) that does not move.
    pub transform: Transform,
    /// Axis of gamma and b in the antecedent.
    pub z1: Vector3<f64>,
    /// Axis of alpha and d in the antecedent.
    pub x1: Vector3<f64>,
    /// Point of the axis of alpha in the antecedent.
    pub foot: Vector3<f64>,
    /// r of a revolute joint.
    pub r: f64,
}

impl FrameConstants {
    fn base() -> Self {
        Self { transform: Transform::identity(), z1: Vector3::z(), x1: Vector3::x(), foot: Vector3::zeros(), r: 0.0 }
    }

    /// Of a frame other than the base.
    fn of(frame: &Frame, values: &[f64]) -> Self {
        let [beta, gamma, b, alpha, d, theta, r] = frame.slots.map(|slot| values[slot]);
        let tilt = Rotation3::from_axis_angle(&Vector3::y_axis(), beta);
        let turned = tilt * Rotation3::from_axis_angle(&Vector3::z_axis(), gamma);
        let z1 = tilt * Vector3::z();
        let x1 = turned * Vector3::x();
        let foot = z1 * b;
        let mut rotation = turned * Rotation3::from_axis_angle(&Vector3::x_axis(), alpha);
        let mut origin = foot + x1 * d;
        if frame.joint != JointKind::Revolute {
            rotation *= Rotation3::from_axis_angle(&Vector3::z_axis(), theta);
        }
        if frame.joint == JointKind::Fixed {
            origin += rotation * Vector3::z() * r;
        }
        Self { transform: Transform::from_parts(Translation3::from(origin), rotation), z1, x1, foot, r }
    }

    /// Axis, point and kind (rotation or translation) of beta, gamma, b, alpha, d in the antecedent.
    pub fn twists(&self) -> [(Vector3<f64>, Vector3<f64>, bool); 5] {
        let origin = Vector3::zeros();
        [
            (Vector3::y(), origin, true),
            (self.z1, origin, true),
            (self.z1, origin, false),
            (self.x1, self.foot, true),
            (self.x1, origin, false),
        ]
    }
}

/// A model with one vector of values, loops not yet assembled.
#[derive(Debug, Clone)]
pub(super) struct Constants<'m> {
    /// The model.
    pub model: &'m Model,
    /// By slot, m and rad.
    pub values: Vec<f64>,
    /// By frame.
    pub frames: Vec<FrameConstants>,
}

impl<'m> Constants<'m> {
    /// Puts `values` into the model.
    ///
    /// # Errors
    /// [`AssemblyError::NotFinite`].
    pub fn new(model: &'m Model, values: &[f64]) -> Result<Self, AssemblyError> {
        let known = |slot: usize| values.get(slot).is_some_and(|v| v.is_finite());
        if let Some(slot) = (0..model.registry.all().len()).find(|&slot| !known(slot)) {
            return Err(AssemblyError::NotFinite(model.registry[slot].name.clone()));
        }
        // The first frame is the base itself.
        let placed = model.frames.iter().skip(1).map(|frame| FrameConstants::of(frame, values));
        let frames = std::iter::once(FrameConstants::base()).chain(placed).collect();
        Ok(Self { model, values: values.to_vec(), frames })
    }

    pub fn value(&self, slot: Slot) -> f64 {
        self.values[slot]
    }

    /// The moving coordinate (theta or r) of a frame whose joint variable is `joint`.
    pub fn full(&self, frame: FrameIndex, joint: f64) -> f64 {
        self.model.frames[frame].home + joint
    }

    /// Zero of a joint as calibrated: what its parameter adds to the variable.
    pub fn zero(&self, frame: FrameIndex) -> f64 {
        let frame = &self.model.frames[frame];
        self.values[frame.moving_slot()] - frame.home
    }

    /// What zeros add to a joint, its own and those that mechanical couplings pass on to it: the controller, which adds up what it
    /// commands, does not know of them.
    fn passed_on(&self, frame: FrameIndex) -> f64 {
        let upstream = match self.model.frames[frame].motion {
            Motion::Coupling(which) if !self.model.coupled_by_controller[which] => {
                let terms = self.model.couplings[which].iter();
                terms.map(|(factor, other)| factor * self.passed_on(*other)).sum()
            }
            _ => 0.0,
        };
        upstream + self.zero(frame)
    }

    /// Joints that have a variable of their own.
    pub fn direct_joints(&self, q: &[f64], joints: &mut Vec<f64>) {
        joints.clear();
        joints.resize(self.model.frames.len(), 0.0);
        for (index, frame) in self.model.frames.iter().enumerate() {
            if let Motion::Variable { index: variable, direction } = frame.motion {
                joints[index] = direction * q[variable] + self.zero(index);
            }
        }
    }

    /// A joint that follows an actuator or other joints.
    pub fn follow(&self, stage: &Stage, q: &[f64], joints: &mut [f64]) -> Result<(), AssemblyError> {
        match stage {
            Stage::Actuator(which) => {
                let actuator = &self.model.actuators[*which];
                let stroke = q[actuator.variable];
                let (angle, _) = slider_crank(stroke, &self.values[actuator.slot..actuator.slot + 5])
                    .map_err(|gap| AssemblyError::SliderCrank { name: actuator.name.clone(), stroke, gap })?;
                joints[actuator.joint] = angle + self.zero(actuator.joint);
            }
            Stage::Coupling(which, joint) => {
                let is_of_controller = self.model.coupled_by_controller[*which];
                let followed = |other: FrameIndex| match is_of_controller {
                    true => joints[other] - self.passed_on(other),
                    false => joints[other],
                };
                let terms = self.model.couplings[*which].iter();
                let sum: f64 = terms.map(|(factor, other)| factor * followed(*other)).sum();
                joints[*joint] = sum + self.zero(*joint);
            }
            Stage::Loops(_) => {}
        }
        Ok(())
    }
}
