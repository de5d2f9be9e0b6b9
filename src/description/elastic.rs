//! Second age of the elastic keys of a description: SI units, names resolved to indices.

use indexmap::IndexMap;
use nalgebra::Vector3;

use super::raw::{BeamTheory, LoadPath, SectionShape, SpringAction, Support};
use super::robot::FrameIndex;

/// What gives under load, and what loads it.
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
    pub base: Option<[Option<Stiffness>; 6]>,
    /// Springs between bodies.
    pub springs: Vec<Spring>,
    /// Axial springs of actuators, by index in [`super::robot::Robot::actuators`].
    pub screws: IndexMap<usize, Screw>,
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
    /// Symbol and value of each number that describes it, in the order of [`section_symbols`].
    pub values: Vec<(&'static str, f64)>,
}

/// Symbols by which a section of a shape is declared.
pub fn section_symbols(shape: Option<SectionShape>) -> &'static [&'static str] {
    match shape {
        Some(SectionShape::Box) => &["width", "height", "wall"],
        Some(SectionShape::Tube) => &["diameter", "wall"],
        Some(SectionShape::Rectangle) => &["width", "height"],
        Some(SectionShape::Rod) => &["diameter"],
        Some(SectionShape::I) => &["width", "height", "wall", "flange"],
        None => &["area", "iy", "iz", "j"],
    }
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

/// Springs ka, kr, kar, krr of a joint.
#[derive(Debug, Clone, PartialEq)]
pub struct JointStiffness {
    /// The joint's frame.
    pub frame: FrameIndex,
    /// Node at which the joint sits on the moving body, if it is not the frame's origin.
    pub at: Option<usize>,
    /// ka, kr, kar, krr; `None` where not given.
    pub springs: [Option<Stiffness>; 4],
}

/// Symbols of [`JointStiffness::springs`].
pub const JOINT_SYMBOLS: [&str; 4] = ["ka", "kr", "kar", "krr"];
/// Symbols of [`Elastic::base`].
pub const BASE_SYMBOLS: [&str; 6] = ["kx", "ky", "kz", "krx", "kry", "krz"];

/// A stiffness as declared, SI.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stiffness {
    /// m/N or rad/(N.m); 0 is rigid, infinite is free.
    pub compliance: f64,
    /// Whether measurements may change it.
    pub identifiable: bool,
    /// Bounds of the compliance.
    pub bounds: [f64; 2],
    /// Declared as a compliance, and reported as one.
    pub as_compliance: bool,
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
