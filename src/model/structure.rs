//! The elastic structure of a robot: vertices (nodes of beams, rigid bodies) and the elements between them, as a tree
//! that hangs from the ground and the elements that close its loops.
//!
//! Nothing is merged or penalised: a rigid direction is a compliance of zero, a passive one is released. What is rigid
//! costs no unknown, because unknowns are only the forces of closures and the motions of releases
//! ([`crate::elastics`]).

use nalgebra::{Isometry3, Vector3};

use crate::description::elastic::Spring;
use crate::description::raw::SectionShape;
use crate::description::robot::FrameIndex;
use crate::parameter::Slot;

/// Index of a vertex in [`Structure::vertices`]; 0 is the ground.
pub type VertexIndex = usize;

/// Elastic structure of a model.
#[derive(Debug, Clone, Default)]
pub struct Structure {
    /// Vertices, each after the one it hangs on.
    pub vertices: Vec<Vertex>,
    /// What each vertex hangs on: its parent, and the element between; entry 0, the ground's, is void.
    pub tree: Vec<Edge>,
    /// Elements that close loops.
    pub closures: Vec<Edge>,
    /// Springs between bodies.
    pub springs: Vec<SpringElement>,
    /// Masses.
    pub masses: Vec<MassElement>,
    /// Acceleration of gravity, base axes, m/s2.
    pub gravity: Vector3<f64>,
    /// Materials, by index.
    pub materials: Vec<MaterialSlots>,
    /// Sections, by index.
    pub sections: Vec<SectionSlots>,
    /// Vertices of the body of each frame.
    pub bodies: Vec<Vec<VertexIndex>>,
    /// Frames with all joints at zero, loops open: where on a body something is attached.
    pub home: Vec<Isometry3<f64>>,
    /// Nodes by name, and the vertex that each is.
    pub nodes: Vec<(String, VertexIndex)>,
    /// Degrees of freedom of the nodes that are not joined rigidly, and of those left when the ground is held.
    pub freedom: [usize; 2],
}

/// A point that moves rigidly with a frame, or lies between two vertices.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Spot {
    /// A point of a frame, m.
    At(FrameIndex, Vector3<f64>),
    /// Between two vertices, at a share of the way.
    Between([VertexIndex; 2], f64),
}

/// A node, or a rigid body.
#[derive(Debug, Clone, PartialEq)]
pub struct Vertex {
    /// Name: of the node, or of the body's frame.
    pub name: String,
    /// Where it is.
    pub spot: Spot,
}

/// An element between two vertices.
#[derive(Debug, Clone, PartialEq)]
pub struct Edge {
    /// `joint:2`, `beam:b1`, `base`, ...
    pub name: String,
    /// Vertices; in the tree: parent, child.
    pub ends: [VertexIndex; 2],
    /// What it is.
    pub element: Element,
}

/// Kinds of element.
#[derive(Debug, Clone, PartialEq)]
#[allow(clippy::large_enum_variant)] // most elements are lumped
pub enum Element {
    /// Springs concentrated at a point.
    Lumped(Lumped),
    /// A beam.
    Beam(BeamElement),
    /// The axial spring of a screw between its two pins.
    Screw(ScrewElement),
}

/// How a direction of a lumped element gives.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Law {
    /// Not at all.
    Rigid,
    /// By a compliance.
    Compliance(Slot),
    /// By the joint's own compliance in series with that of the screw that drives it, seen through its lever.
    Driven {
        /// Joint's own.
        own: Slot,
        /// Screw's axial compliance.
        axial: Slot,
        /// The actuator, by index in [`super::Model::actuators`].
        actuator: usize,
    },
    /// Free, or held by a soft spring of this stiffness.
    Released(Option<Slot>),
}

/// Six springs at a point, along and about the axes of a frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Lumped {
    /// The point.
    pub spot: Spot,
    /// Its axes.
    pub axes: Axes,
    /// Along x, y, z, about x, y, z.
    pub laws: [Law; 6],
    /// What each direction is called.
    pub symbols: [&'static str; 6],
}

/// Whose axes a lumped element has.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Axes {
    /// A frame's.
    Frame(FrameIndex),
    /// A beam's own.
    Beam {
        /// Its vertices.
        ends: [VertexIndex; 2],
        /// As [`BeamElement::normal`].
        normal: FrameIndex,
        /// As [`BeamElement::axis`].
        axis: usize,
    },
}

/// A beam from the edge's first vertex to its second.
#[derive(Debug, Clone, PartialEq)]
pub struct BeamElement {
    /// Frame whose axis is the local z.
    pub normal: FrameIndex,
    /// Which axis of it: z (2), or x (0) where z lies along the beam.
    pub axis: usize,
    /// What resists.
    pub rigidity: Rigidity,
}

/// Rigidity of a beam.
#[derive(Debug, Clone, PartialEq)]
pub enum Rigidity {
    /// By sections and a material.
    Section {
        /// Sections of the whole beam's two ends.
        sections: [usize; 2],
        /// Where this element begins and ends on the beam (0 to 1).
        share: [f64; 2],
        /// Material.
        material: usize,
        /// With shear areas.
        shear: bool,
    },
    /// By the slots of 1/(E Iy), 1/(E Iz), 1/(G J): a link whose give nobody declared.
    Inverse([Slot; 3]),
}

/// A screw that holds its joint through two pins.
#[derive(Debug, Clone, PartialEq)]
pub struct ScrewElement {
    /// By index in [`super::Model::actuators`].
    pub actuator: usize,
    /// The joint's own compliance, in series.
    pub own: Slot,
    /// Axial compliance.
    pub axial: Slot,
}

/// A spring between points of two bodies.
#[derive(Debug, Clone, PartialEq)]
pub struct SpringElement {
    /// Its declaration.
    pub spring: Spring,
    /// Vertices of its two bodies.
    pub ends: [VertexIndex; 2],
    /// Slots of stiffness, free length and the two anchors (x1 y1 z1 x2 y2 z2).
    pub slots: [Slot; 8],
    /// Frame about whose origin the relative motion of the bodies is counted.
    pub pivot: FrameIndex,
}

/// A mass and its four slots (mass, x, y, z).
#[derive(Debug, Clone, PartialEq)]
pub struct MassElement {
    /// The frame it moves with.
    pub frame: FrameIndex,
    /// The vertex that carries it.
    pub vertex: VertexIndex,
    /// First slot.
    pub slot: Slot,
}

/// Slots of a material.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MaterialSlots {
    /// Young's modulus.
    pub young: Slot,
    /// Shear modulus, or Poisson's ratio.
    pub shear: Slot,
    /// Which of them.
    pub is_poisson: bool,
    /// Density.
    pub density: Slot,
}

/// Slots of a section.
#[derive(Debug, Clone, PartialEq)]
pub struct SectionSlots {
    /// Its shape.
    pub shape: Option<SectionShape>,
    /// Symbol and slot of each number.
    pub slots: Vec<(&'static str, Slot)>,
}

impl Edge {
    /// Number of released directions, if this is the released end of a beam.
    pub fn released_end(&self) -> Option<usize> {
        match &self.element {
            Element::Lumped(Lumped { axes: Axes::Beam { .. }, laws, .. }) => {
                Some(laws.iter().filter(|law| matches!(law, Law::Released(_))).count())
            }
            _ => None,
        }
    }
}

impl Structure {
    /// The vertex that carries a point (m) of a frame: of its body's vertices, the nearest.
    pub fn carrier(&self, frame: FrameIndex, point: &Vector3<f64>) -> VertexIndex {
        let at = self.home[frame] * nalgebra::Point3::from(*point);
        nearest(&self.bodies[frame], &at.coords, |vertex| self.at_home(vertex))
    }

    /// Position of a vertex with all joints at zero, m.
    pub fn at_home(&self, vertex: VertexIndex) -> Vector3<f64> {
        match self.vertices[vertex].spot {
            Spot::At(frame, point) => (self.home[frame] * nalgebra::Point3::from(point)).coords,
            Spot::Between([a, b], share) => self.at_home(a).lerp(&self.at_home(b), share),
        }
    }

    /// Vertices from a vertex to the ground, the ground left out.
    pub fn path(&self, vertex: VertexIndex) -> impl Iterator<Item = VertexIndex> {
        std::iter::successors(Some(vertex), |&v| Some(self.tree[v].ends[0])).take_while(|&v| v != 0)
    }
}

/// The nearest of some vertices; of equally near ones the first.
pub(super) fn nearest(
    among: &[VertexIndex],
    at: &Vector3<f64>,
    position: impl Fn(VertexIndex) -> Vector3<f64>,
) -> VertexIndex {
    let mut best = (f64::INFINITY, among.first().copied().unwrap_or(0));
    for &vertex in among {
        let distance = (position(vertex) - at).norm();
        if distance < best.0 - 1e-9 {
            best = (distance, vertex);
        }
    }
    best.1
}

/// Pins of a slider-crank in the frame of its joint, at joint value `joint` (rad): the one on the antecedent body, the
/// one on the moving body, m. `values` are stroke, kappa, lambda, l1, l3.
///
/// Neither paper draws where kappa and lambda are counted from, only their sum enters the stroke: here the moving pin
/// lies at -kappa from the frame's x axis, the other at lambda - 180 deg from where that axis is at joint value zero.
pub fn screw_pins(values: &[f64], joint: f64) -> [Vector3<f64>; 2] {
    let at = |length: f64, angle: f64| Vector3::new(length * angle.cos(), length * angle.sin(), 0.0);
    [at(values[4], values[2] - std::f64::consts::PI - joint), at(values[3], -values[1])]
}
