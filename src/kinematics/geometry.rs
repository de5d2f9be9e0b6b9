//! A model with values put in, and the placement of its frames.

use nalgebra::{Point3, Rotation3, Translation3, Vector3};

use super::closure::{ClosedLoops, Scratch};
use super::{Transform, slider_crank};
use crate::description::raw::JointKind;
use crate::description::robot::{FrameIndex, Motion};
use crate::model::{Frame, Model, Stage};
use crate::parameter::Slot;

/// The mechanism cannot be put together.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum AssemblyError {
    /// A closed loop does not close.
    #[error(
        "loop {} cannot close{branch}: the frames that should meet stay {gap:.3e} m (or rad) apart",
        quoted(name, others)
    )]
    Loop {
        /// The loop, or the first of those that are closed together.
        name: String,
        /// The others that are closed together with it.
        others: Vec<String>,
        /// Smallest gap reached, m or rad.
        gap: f64,
        /// What was said about the branch.
        branch: &'static str,
    },
    /// A slider-crank's triangle does not close.
    #[error(
        "the triangle of actuator `{name}` cannot close at stroke {stroke:.6} m: its length is {gap:.3e} m out of reach"
    )]
    SliderCrank {
        /// The actuator.
        name: String,
        /// Commanded stroke, m.
        stroke: f64,
        /// Missing length, m.
        gap: f64,
    },
    /// A value or joint is not a finite number.
    #[error("`{0}` is not a finite number")]
    NotFinite(String),
    /// A configuration has the wrong number of joints.
    #[error("a configuration of {expected} variables was expected, and {found} given")]
    WrongLength {
        /// Number of variables of the model.
        expected: usize,
        /// Number given.
        found: usize,
    },
}

fn quoted(name: &str, others: &[String]) -> String {
    let names = std::iter::once(name).chain(others.iter().map(String::as_str));
    names.map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ")
}

/// Constant part of a frame's placement, and the local axes of its constants.
#[derive(Debug, Clone, Copy)]
pub(super) struct Constant {
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

impl Constant {
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
}

/// A model with one vector of values; immutable, shared between threads.
#[derive(Debug, Clone)]
pub struct Geometry<'m> {
    /// The model.
    pub model: &'m Model,
    pub(super) values: Vec<f64>,
    pub(super) constants: Vec<Constant>,
    pub(super) loops: Vec<ClosedLoops>,
}

/// Joint values and frames of one configuration. Reused between configurations: placing allocates nothing.
#[derive(Debug, Clone, Default)]
pub struct Placements {
    /// Joint variable of each frame, rad or m (0 for fixed frames): as commanded, plus the joint's zero.
    pub joints: Vec<f64>,
    /// Each frame in the base frame.
    pub frames: Vec<Transform>,
    pub(super) scratch: Scratch,
}

impl<'m> Geometry<'m> {
    /// Puts `values` (by slot, m and rad) into the model and assembles its loops on the declared branch.
    ///
    /// # Errors
    /// [`AssemblyError`] if a loop cannot close at the configuration at which its branch was declared.
    pub fn new(model: &'m Model, values: &[f64]) -> Result<Self, AssemblyError> {
        if let Some(slot) =
            (0..model.registry.all().len()).find(|&slot| !values.get(slot).is_some_and(|v| v.is_finite()))
        {
            return Err(AssemblyError::NotFinite(model.registry[slot].name.clone()));
        }
        // The first frame is the base itself.
        let placed = model.frames.iter().skip(1).map(|frame| Constant::of(frame, values));
        let constants = std::iter::once(Constant::base()).chain(placed).collect();
        let mut geometry = Self { model, values: values.to_vec(), constants, loops: Vec::new() };
        for stage in &model.stages {
            if let Stage::Loops(group) = stage {
                let closed = ClosedLoops::assemble(&geometry, group)?;
                geometry.loops.push(closed);
            }
        }
        Ok(geometry)
    }

    /// The model with its nominal values.
    ///
    /// # Errors
    /// As [`Geometry::new`].
    pub fn nominal(model: &'m Model) -> Result<Self, AssemblyError> {
        Self::new(model, &model.registry.nominal())
    }

    /// Values by slot.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    pub(super) fn value(&self, slot: Slot) -> f64 {
        self.values[slot]
    }

    /// The moving coordinate (theta or r) of a frame whose joint variable is `joint`.
    pub(super) fn full(&self, frame: FrameIndex, joint: f64) -> f64 {
        self.model.frames[frame].home + joint
    }

    /// Zero of a joint as calibrated: what its parameter adds to the variable.
    pub(super) fn zero(&self, frame: FrameIndex) -> f64 {
        let frame = &self.model.frames[frame];
        self.values[frame.moving_slot()] - frame.home
    }

    /// Places all frames for the variables `q` (rad and m, in the model's order).
    ///
    /// # Errors
    /// [`AssemblyError`] if a loop or an actuator cannot close there, or `q` is not finite.
    pub fn place(&self, q: &[f64], out: &mut Placements) -> Result<(), AssemblyError> {
        self.joints(q, out)?;
        let frames = &self.model.frames;
        out.frames.resize(frames.len(), Transform::identity());
        for (index, frame) in frames.iter().enumerate().skip(1) {
            let fixed = &self.constants[index];
            let antecedent = &out.frames[frame.antecedent];
            let mut rotation = antecedent.rotation.matrix() * fixed.transform.rotation.matrix();
            let mut origin =
                antecedent.rotation.matrix() * fixed.transform.translation.vector + antecedent.translation.vector;
            match frame.joint {
                JointKind::Revolute => {
                    let (sine, cosine) = self.full(index, out.joints[index]).sin_cos();
                    let (x, y) = (rotation.column(0).into_owned(), rotation.column(1).into_owned());
                    rotation.set_column(0, &(x * cosine + y * sine));
                    rotation.set_column(1, &(y * cosine - x * sine));
                    origin += rotation.column(2) * fixed.r;
                }
                JointKind::Prismatic => origin += rotation.column(2) * self.full(index, out.joints[index]),
                JointKind::Fixed => {}
            }
            out.frames[index] =
                Transform::from_parts(Translation3::from(origin), Rotation3::from_matrix_unchecked(rotation));
        }
        Ok(())
    }

    /// Joint variables of all frames for the variables `q`.
    fn joints(&self, q: &[f64], out: &mut Placements) -> Result<(), AssemblyError> {
        let model = self.model;
        if q.len() != model.variables.len() {
            return Err(AssemblyError::WrongLength { expected: model.variables.len(), found: q.len() });
        }
        if let Some(k) = q.iter().position(|value| !value.is_finite()) {
            return Err(AssemblyError::NotFinite(model.variables[k].name.clone()));
        }
        self.direct_joints(q, &mut out.joints);
        let mut group = 0;
        for stage in &model.stages {
            match stage {
                Stage::Loops(_) => {
                    self.loops[group].close(self, &mut out.joints, &mut out.scratch)?;
                    group += 1;
                }
                stage => self.follow(stage, q, &mut out.joints)?,
            }
        }
        Ok(())
    }

    /// Joints that have a variable of their own.
    pub(super) fn direct_joints(&self, q: &[f64], joints: &mut Vec<f64>) {
        joints.clear();
        joints.resize(self.model.frames.len(), 0.0);
        for (index, frame) in self.model.frames.iter().enumerate() {
            if let Motion::Variable { index: variable, direction } = frame.motion {
                joints[index] = direction * q[variable] + self.zero(index);
            }
        }
    }

    /// A joint that follows an actuator or other joints.
    pub(super) fn follow(&self, stage: &Stage, q: &[f64], joints: &mut [f64]) -> Result<(), AssemblyError> {
        match stage {
            Stage::Actuator(which) => {
                let actuator = &self.model.actuators[*which];
                let stroke = q[actuator.variable];
                let (angle, _) = slider_crank(stroke, &self.values[actuator.slot..actuator.slot + 5])
                    .map_err(|gap| AssemblyError::SliderCrank { name: actuator.name.clone(), stroke, gap })?;
                joints[actuator.joint] = angle + self.zero(actuator.joint);
            }
            Stage::Coupling(which, joint) => {
                let sum: f64 = self.model.couplings[*which].iter().map(|(factor, other)| factor * joints[*other]).sum();
                joints[*joint] = sum + self.zero(*joint);
            }
            Stage::Loops(_) => {}
        }
        Ok(())
    }

    /// Pose of the base in the measurement frame.
    pub fn base(&self) -> Transform {
        self.placement(self.model.base)
    }

    /// Pose of the tool centre point in its frame.
    pub fn tool(&self) -> Transform {
        self.placement(self.model.tool.1)
    }

    /// Position of a marker in its frame.
    pub fn marker(&self, marker: usize) -> Point3<f64> {
        let slot = self.model.markers[marker].slot;
        Point3::new(self.values[slot], self.values[slot + 1], self.values[slot + 2])
    }

    fn placement(&self, slot: Slot) -> Transform {
        let v = &self.values[slot..slot + 6];
        Transform::from_parts(Translation3::new(v[0], v[1], v[2]), Rotation3::new(Vector3::new(v[3], v[4], v[5])))
    }
}
