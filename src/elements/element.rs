//! The interface of an elastic element, and what it is given: a placed configuration, and how that moves.
//!
//! Base axes and SI throughout. *Spatial* wrenches (force, moment) and twists (displacement, rotation vector) are reduced to
//! the origin of the base (Featherstone 2008, ch. 2).

use std::fmt::Debug;

use nalgebra::{IsometryMatrix3, Matrix3, Matrix6, Point3, Vector3, Vector6};

use super::flexibility::Flexibility;
use super::per_length::PerLength;
use crate::description::robot::FrameIndex;
use crate::parameter::Slot;

/// Index of a vertex of the structure; 0 is the ground.
pub type VertexIndex = usize;

/// Frames in the base frame, by index.
pub type Frames = [IsometryMatrix3<f64>];

/// An elastic element between two vertices.
pub trait ElasticElement: Debug + Send + Sync {
    /// How each direction is held: along x, y, z, about x, y, z of the local axes.
    fn directions(&self) -> [Direction; 6];

    /// What each direction is called in reports; `None` where the element is reported as a whole.
    fn symbols(&self) -> Option<[&'static str; 6]> {
        None
    }

    /// Parameters that the element depends on; stiffnesses of released directions are left out, since they are known by
    /// [`ElasticElement::directions`].
    fn parameters(&self) -> Vec<ParameterUse>;

    /// Whether it can deform with these values (by slot), so that it counts in the tree; a spring, whether it holds.
    fn is_active(&self, values: &[f64]) -> bool;

    /// Whether it holds its two vertices rigidly together with these values.
    fn is_rigid(&self, _values: &[f64]) -> bool {
        false
    }

    /// The beam of which it is a released end.
    fn released_end_of(&self) -> Option<&str> {
        None
    }

    /// Whether it closes a loop in the plane normal to its z axis only, that of parallel joints.
    fn closes_in_plane(&self) -> bool {
        false
    }

    /// Of a straight uniform element: what a metre gives and weighs with these values.
    fn per_length(&self, _values: &[f64]) -> Option<PerLength> {
        None
    }

    /// Derivative of [`ElasticElement::per_length`] by a parameter, SI.
    fn per_length_by(&self, _slot: Slot, _values: &[f64]) -> Option<PerLength> {
        None
    }

    /// Local axes and flexibility; `ends` are its vertices, `per_length` what [`ElasticElement::per_length`] returned.
    fn place(&self, at: &Configuration, ends: [VertexIndex; 2], per_length: &PerLength) -> Placed;

    /// The point (m, base frame) about which its second vertex turns against the first, with nothing deflected; `None` if it
    /// holds nothing together.
    fn pivot(&self, _frames: &Frames, undeflected: &[Vector3<f64>], ends: [VertexIndex; 2]) -> Option<Vector3<f64>> {
        Some(undeflected[ends[1]])
    }

    /// What holds the directions that are not [`Direction::Flexible`].
    fn held(&self, _at: &Configuration, _ends: [VertexIndex; 2]) -> Held {
        Held::default()
    }

    /// By how much the wrench on its second vertex has changed with a finite deflection, in the local axes of
    /// [`ElasticElement::place`], for an element that holds nothing together but pulls ([`Direction::Sprung`]).
    fn drawn(&self, _at: &Configuration, _ends: [VertexIndex; 2]) -> Vector6<f64> {
        Vector6::zeros()
    }

    /// Whether it loads the structure of itself.
    fn is_preloaded(&self) -> bool {
        false
    }

    /// Derivative by a parameter, `part` as in [`ParameterUse::part`]; not asked where
    /// [`ElasticElement::per_length_by`] answers.
    fn by_parameter(&self, part: usize, at: &Configuration) -> Rate;

    /// Derivative by a motion of the frames, nothing deflected.
    fn by_motion(&self, at: &Configuration, ends: [VertexIndex; 2], moves: &VertexMotion) -> MotionRate;
}

/// How a direction of an element is held.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Direction {
    /// It deforms by the element's flexibility, which may be zero.
    Flexible,
    /// Free, or held by a soft spring whose stiffness is in this slot.
    Released(Option<Slot>),
    /// By [`Held`], together with the other directions; in closures only.
    Sprung,
}

/// A parameter of an element.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ParameterUse {
    /// Its slot.
    pub slot: Slot,
    /// Where it enters, as the element counts its parts.
    pub part: usize,
}

/// A point that moves with a frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BodyPoint {
    /// The frame.
    pub frame: FrameIndex,
    /// The point in it, m.
    pub point: Vector3<f64>,
}

impl BodyPoint {
    /// Its position, m, base frame.
    pub fn place(&self, frames: &Frames) -> Vector3<f64> {
        (frames[self.frame] * Point3::from(self.point)).coords
    }
}

/// A placed configuration.
#[derive(Debug, Clone, Copy)]
pub struct Configuration<'a> {
    /// Values of all parameters, SI, by slot.
    pub values: &'a [f64],
    /// Frames with nothing deflected.
    pub frames: &'a Frames,
    /// Joint variable of each frame, rad or m.
    pub joints: &'a [f64],
    /// Where the vertices are, m, base frame.
    pub points: &'a [Vector3<f64>],
    /// Where bodies have deflected; `None` where nothing has.
    pub deflected: Option<Deflected<'a>>,
}

/// How bodies have deflected, by vertex.
#[derive(Debug, Clone, Copy)]
pub struct Deflected<'a> {
    /// Positions with nothing deflected, m, base frame.
    pub undeflected: &'a [Vector3<f64>],
    /// Rotation of each vertex's body.
    pub turned: &'a [Matrix3<f64>],
}

impl Configuration<'_> {
    /// Rotation of a vertex's body by deflection.
    pub fn turned(&self, vertex: VertexIndex) -> Matrix3<f64> {
        self.deflected.map_or_else(Matrix3::identity, |by| by.turned[vertex])
    }

    /// Where a point of a vertex's body is, from where it is with nothing deflected (m, base frame).
    pub fn carried(&self, vertex: VertexIndex, undeflected: &Vector3<f64>) -> Vector3<f64> {
        match self.deflected {
            Some(by) => self.points[vertex] + by.turned[vertex] * (undeflected - by.undeflected[vertex]),
            None => *undeflected,
        }
    }
}

/// An element at a configuration.
#[derive(Debug, Clone, Copy)]
pub struct Placed {
    /// Matrix from spatial wrenches to the local axes; its transpose takes local deformations to spatial twists.
    pub local: Matrix6<f64>,
    /// Flexibility.
    pub flexibility: Flexibility,
    /// Length of a straight uniform element, m; zero of others.
    pub length: f64,
}

impl Placed {
    /// Local axes `rotation` (columns) at `origin`.
    pub fn new(rotation: &Matrix3<f64>, origin: &Vector3<f64>, flexibility: Flexibility) -> Self {
        Self { local: reduction(rotation, origin), flexibility, length: 0.0 }
    }
}

impl Default for Placed {
    fn default() -> Self {
        Self { local: Matrix6::zeros(), flexibility: Flexibility::Rigid, length: 0.0 }
    }
}

/// Stiffness of the directions that are held, and the force they carry without deformation, local axes; or a derivative
/// of both.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Held {
    /// Force that resists, by deformation.
    pub stiffness: Matrix6<f64>,
    /// Wrench on the second body.
    pub preload: Vector6<f64>,
}

/// Derivative of an element, in its local axes.
#[derive(Debug, Clone, Copy, PartialEq)]
#[expect(
    clippy::large_enum_variant,
    reason = "one per element and motion in the Jacobian, where a box would be allocated"
)]
pub enum Rate {
    /// Of its flexibility.
    Flexibility(Flexibility),
    /// Of what holds it.
    Held(Held),
}

/// Derivative of an element by a motion.
#[derive(Debug, Clone, Copy)]
pub struct MotionRate {
    /// Spatial twist of the local axes.
    pub twist: Vector6<f64>,
    /// Growth of [`Placed::length`], m.
    pub stretch: f64,
    /// What changes in the local axes beyond that.
    pub rate: Rate,
}

impl MotionRate {
    /// Local axes at a point (m) that is displaced and turned.
    pub fn of(at: &Vector3<f64>, moved: Vector3<f64>, turn: Vector3<f64>) -> Self {
        let v = moved - turn.cross(at);
        let twist = Vector6::new(v.x, v.y, v.z, turn.x, turn.y, turn.z);
        Self { twist, stretch: 0.0, rate: Rate::Flexibility(Flexibility::Rigid) }
    }
}

/// How a robot moves with a geometric parameter or a variable.
pub struct Motion<'a> {
    /// The parameter; none for a variable.
    pub by: Option<Slot>,
    /// Displacement of each frame's origin (m) and its rotation (rad), base axes.
    pub frames: &'a dyn Fn(FrameIndex) -> [f64; 6],
    /// How fast each joint's variable changes.
    pub joints: &'a dyn Fn(FrameIndex) -> f64,
}

/// A motion, with the displacements of the vertices.
pub struct VertexMotion<'a> {
    /// Of the frames and joints.
    pub motion: &'a Motion<'a>,
    /// Frames that move.
    pub frames: &'a Frames,
    /// Displacement of each vertex, m.
    pub vertices: &'a [Vector3<f64>],
}

impl Motion<'_> {
    /// Displacement and rotation of a point (m, base frame) that moves with a frame, base axes.
    pub fn point(&self, frames: &Frames, frame: FrameIndex, at: &Vector3<f64>) -> (Vector3<f64>, Vector3<f64>) {
        let column = (self.frames)(frame);
        let turn = Vector3::new(column[3], column[4], column[5]);
        let origin = frames[frame].translation.vector;
        (Vector3::new(column[0], column[1], column[2]) + turn.cross(&(at - origin)), turn)
    }
}

impl VertexMotion<'_> {
    /// As [`Motion::point`].
    pub fn point(&self, frame: FrameIndex, at: &Vector3<f64>) -> (Vector3<f64>, Vector3<f64>) {
        self.motion.point(self.frames, frame, at)
    }
}

/// Spatial wrench of a force and moment acting at a point (m, base axes).
pub fn spatial(point: &Vector3<f64>, force: &Vector3<f64>, moment: &Vector3<f64>) -> Vector6<f64> {
    let moment = moment + point.cross(force);
    Vector6::new(force.x, force.y, force.z, moment.x, moment.y, moment.z)
}

/// Matrix that takes spatial wrenches to the local axes `rotation` at `origin`; its transpose takes local deformations
/// to spatial twists.
pub fn reduction(rotation: &Matrix3<f64>, origin: &Vector3<f64>) -> Matrix6<f64> {
    let turned = rotation.transpose();
    let arm = turned * origin.cross_matrix();
    let mut matrix = Matrix6::zeros();
    matrix.fixed_view_mut::<3, 3>(0, 0).copy_from(&turned);
    matrix.fixed_view_mut::<3, 3>(3, 0).copy_from(&-arm);
    matrix.fixed_view_mut::<3, 3>(3, 3).copy_from(&turned);
    matrix
}
