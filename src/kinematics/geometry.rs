//! A model with values put in, and the placement of its frames (base frame, m and rad).

use nalgebra::{Point3, Rotation3, Translation3, Vector3};

use super::assembly_error::{AssemblyError, Gap};
use super::closure::{ClosedLoops, Scratch};
use super::constants::Constants;
use super::transform::Transform;
use crate::description::raw::JointKind;
use crate::description::robot::FrameIndex;
use crate::model::{Model, Stage};
use crate::parameter::Slot;

/// A model with one vector of values; immutable, shared between threads.
#[derive(Debug, Clone)]
pub struct Geometry<'m> {
    /// The model.
    pub model: &'m Model,
    pub(super) constants: Constants<'m>,
    pub(super) loops: Vec<ClosedLoops>,
}

/// Joint values and frames of one configuration. Reused between configurations: placing allocates nothing.
#[derive(Debug, Clone, Default)]
pub struct Placements {
    /// Actuated variables as asked for, rad or m.
    pub variables: Vec<f64>,
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
        let constants = Constants::new(model, values)?;
        let mut loops: Vec<ClosedLoops> = Vec::new();
        for stage in &model.stages {
            if let Stage::Loops(group) = stage {
                loops.push(ClosedLoops::assemble(&constants, &loops, group)?);
            }
        }
        Ok(Self { model, constants, loops })
    }

    /// The model with its nominal values.
    ///
    /// # Errors
    /// As [`Geometry::new`].
    pub fn nominal(model: &'m Model) -> Result<Self, AssemblyError> {
        Self::new(model, &model.registry.nominal())
    }

    /// The gap that each loop keeps where its branch is declared, with its name: over-constrained loops are closed
    /// in the least-squares sense.
    pub fn open_loops(&self) -> impl Iterator<Item = (&str, Gap)> {
        self.loops.iter().map(ClosedLoops::open)
    }

    /// Passive joints of loops: the first loop that holds each, its frame, where its branch is declared and where it was then assembled, rad
    /// or m.
    pub fn assembled(&self) -> impl Iterator<Item = (&str, FrameIndex, [f64; 2])> {
        self.loops.iter().flat_map(ClosedLoops::assembled)
    }

    /// Values by slot.
    pub fn values(&self) -> &[f64] {
        &self.constants.values
    }

    /// Places all frames for the variables `q` (rad and m, in the model's order).
    ///
    /// # Errors
    /// [`AssemblyError`] if a loop or an actuator cannot close there, or `q` is not finite.
    ///
    /// ```
    /// use elastogeo::kinematics::{Geometry, Placements};
    ///
    /// let robot = elastogeo::files::load_robot("kuka-ir663")?;
    /// let geometry = Geometry::nominal(&robot.model)?;
    /// let mut placements = Placements::default();
    /// // q1, stroke2, stroke8, q4, q5, q7: rad and m. The loop is closed on its declared branch.
    /// geometry.place(&[0.0, 0.8, 0.75, 0.0, 90f64.to_radians(), 0.0], &mut placements)?;
    /// let tool = placements.frames[robot.model.tool.0] * geometry.tool();
    /// assert!((tool.translation.x - 1.6190831).abs() < 1e-7);
    /// # Ok::<(), elastogeo::Error>(())
    /// ```
    pub fn place(&self, q: &[f64], out: &mut Placements) -> Result<(), AssemblyError> {
        self.joints(q, out)?;
        let frames = &self.model.frames;
        out.frames.resize(frames.len(), Transform::identity());
        for (index, frame) in frames.iter().enumerate().skip(1) {
            let fixed = &self.constants.frames[index];
            let antecedent = &out.frames[frame.antecedent];
            let mut rotation = antecedent.rotation.matrix() * fixed.transform.rotation.matrix();
            let mut origin =
                antecedent.rotation.matrix() * fixed.transform.translation.vector + antecedent.translation.vector;
            match frame.joint {
                JointKind::Revolute => {
                    let (sine, cosine) = self.constants.full(index, out.joints[index]).sin_cos();
                    let (x, y) = (rotation.column(0).into_owned(), rotation.column(1).into_owned());
                    rotation.set_column(0, &(x * cosine + y * sine));
                    rotation.set_column(1, &(y * cosine - x * sine));
                    origin += rotation.column(2) * fixed.r;
                }
                JointKind::Prismatic => origin += rotation.column(2) * self.constants.full(index, out.joints[index]),
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
        out.variables.clear();
        out.variables.extend_from_slice(q);
        self.constants.direct_joints(q, &mut out.joints);
        let mut group = 0;
        for stage in &model.stages {
            match stage {
                Stage::Loops(_) => {
                    self.loops[group].close(&self.constants, &mut out.joints, &mut out.scratch)?;
                    group += 1;
                }
                stage => self.constants.follow(stage, q, &mut out.joints)?,
            }
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
        self.point(self.model.markers[marker].slot)
    }

    /// The point that three values from a slot describe, m.
    pub fn point(&self, slot: Slot) -> Point3<f64> {
        Point3::new(self.constants.values[slot], self.constants.values[slot + 1], self.constants.values[slot + 2])
    }

    /// The pose that six values from a slot describe: position (m) and rotation vector.
    pub fn placement(&self, slot: Slot) -> Transform {
        let v = &self.constants.values[slot..slot + 6];
        Transform::from_parts(Translation3::new(v[0], v[1], v[2]), Rotation3::new(Vector3::new(v[3], v[4], v[5])))
    }
}
