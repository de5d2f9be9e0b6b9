//! The elastic part of a resolved description: SI units, names resolved to indices.

use indexmap::IndexMap;
use nalgebra::Vector3;

use super::frame::FrameIndex;
use super::raw::{BeamTheory, JointKind, LoadPath, SectionShape, SpringAction, Support};
use crate::parameter::Kind;

/// Compliances, and what loads them.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Elastic {
    /// Acceleration of gravity, base axes, m/s2.
    pub gravity: Vector3<f64>,
    /// Masses.
    pub bodies: Vec<Body>,
    /// Materials by name.
    pub materials: IndexMap<String, Material>,
    /// Cross-sections by name.
    pub sections: IndexMap<String, Section>,
    /// Nodes.
    pub nodes: Vec<Node>,
    /// Beams.
    pub beams: Vec<Beam>,
    /// Springs of joints.
    pub joints: Vec<JointStiffness>,
    /// Springs of the pedestal along and about x, y, z; rigid where absent.
    pub base: [Option<Stiffness>; 6],
    /// Springs between bodies.
    pub springs: Vec<Spring>,
    /// Axial springs of actuators, by index in [`super::robot::Robot::actuators`].
    pub screws: IndexMap<usize, Screw>,
}

/// A body that the tool carries: its weight loads the robot as a wrench does.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Payload {
    /// kg.
    pub mass: f64,
    /// Centre of mass in its frame, m.
    pub com: Vector3<f64>,
    /// The frame, one of the tool's body.
    pub frame: FrameIndex,
}

/// Mass of a body.
#[derive(Debug, Clone, PartialEq)]
pub struct Body {
    /// The frame it moves with.
    pub frame: FrameIndex,
    /// kg
    pub mass: f64,
    /// Centre of mass in the frame, m.
    pub com: Vector3<f64>,
}

/// An isotropic material.
#[derive(Debug, Clone, PartialEq)]
pub struct Material {
    /// Young's modulus, Pa.
    pub young: f64,
    /// Shear modulus, Pa, or Poisson's ratio.
    pub shear: Shear,
    /// kg/m3
    pub density: f64,
    /// Coefficient of thermal expansion, 1/K.
    pub expansion: f64,
}

/// How the shear modulus is given.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Shear {
    /// Pa
    Modulus(f64),
    /// E / (2 (1 + nu))
    Poisson(f64),
}

/// A cross-section: shape, and the symbols and values (m, m2, m4) it is declared by.
#[derive(Debug, Clone, PartialEq)]
pub struct Section {
    /// Shape; by A, Iy, Iz, J where there is none.
    pub shape: Option<SectionShape>,
    /// Symbol and value of each number that describes it, in the order of the file's keys.
    pub values: Vec<(&'static str, f64)>,
}

/// A node: a point of a body.
#[derive(Debug, Clone, PartialEq)]
pub struct Node {
    /// Name.
    pub name: String,
    /// The body, by the frame it moves with.
    pub body: FrameIndex,
    /// The frame in which the point is given.
    pub at: FrameIndex,
    /// The point in that frame, m.
    pub point: Vector3<f64>,
    /// How the ground holds it.
    pub support: Option<Support>,
}

/// A beam between two nodes of one body.
#[derive(Debug, Clone, PartialEq)]
pub struct Beam {
    /// Name.
    pub name: String,
    /// Its nodes, by index in [`Elastic::nodes`].
    pub nodes: [usize; 2],
    /// Sections at its two ends, by index in [`Elastic::sections`].
    pub sections: [usize; 2],
    /// Material, by index.
    pub material: usize,
    /// Frame whose z is the local z.
    pub normal: FrameIndex,
    /// Theory.
    pub theory: BeamTheory,
    /// Number of elements.
    pub elements: usize,
    /// Directions of its own axes (along x, y, z, about x, y, z) in which each end is free of its node.
    pub released: [[bool; 6]; 2],
}

/// Springs ka, kr, kar, krr, krx, kry, krrx, krry of a joint.
#[derive(Debug, Clone, PartialEq)]
pub struct JointStiffness {
    /// The joint's frame.
    pub frame: FrameIndex,
    /// Node at which the joint sits on the moving body, if it is not the frame's origin.
    pub at: Option<usize>,
    /// Along and across the axis, about it and about what lies across it; along and about x and y, where these differ; `None`
    /// where not given.
    pub springs: [Option<Stiffness>; 8],
}

/// Which of [`JointStiffness::springs`] acts along the joint's own motion.
pub fn own_axis(joint: JointKind) -> usize {
    if joint == JointKind::Prismatic { 0 } else { 2 }
}

/// Symbols of [`Elastic::base`].
pub const BASE_SYMBOLS: [&str; 6] = ["kx", "ky", "kz", "krx", "kry", "krz"];

/// A stiffness as declared, held as the model computes with it: a compliance (0 is rigid) where it is in series with
/// others, a stiffness (0 is free) where it acts in parallel with a joint. Inverted here, once.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stiffness {
    /// Whether `nominal` is a stiffness or a compliance, of a translation or a rotation.
    pub kind: Kind,
    /// N/m, N.m/rad, m/N or rad/(N.m).
    pub nominal: f64,
    /// Whether measurements may change it.
    pub identifiable: bool,
    /// Least and greatest value of `nominal`.
    pub bounds: [f64; 2],
    /// Declared, and reported, as the inverse of `nominal`.
    pub inverted: bool,
}

impl Stiffness {
    /// Of what no file declares: a rigid compliance, reported as a stiffness, or a stiffness of zero.
    pub fn undeclared(kind: Kind) -> Self {
        Self { kind, nominal: 0.0, identifiable: false, bounds: [0.0, f64::INFINITY], inverted: kind.is_compliance() }
    }
}

/// A spring between points of two bodies.
#[derive(Debug, Clone, PartialEq)]
pub struct Spring {
    /// Name.
    pub name: String,
    /// The bodies, by the frames they move with.
    pub bodies: [FrameIndex; 2],
    /// Anchor on each, in its frame, m.
    pub anchors: [Vector3<f64>; 2],
    /// Rate.
    pub rate: Stiffness,
    /// Length without force, m; `None` is without force wherever it is.
    pub free_length: Option<f64>,
    /// What of it enters.
    pub acts: SpringAction,
}

/// Axial spring of a ball screw or cylinder.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Screw {
    /// Axial stiffness.
    pub axial: Stiffness,
    /// How its force reaches the bodies.
    pub path: LoadPath,
}
