//! The elastic structure of a robot: vertices (nodes of beams, rigid bodies) and the elements between them, as a tree
//! that hangs from the ground and the elements that close its loops.
//!
//! Nothing is merged or penalised: a rigid direction is a compliance of zero, a passive one is released. What is rigid
//! costs no unknown, because unknowns are only the forces of closures and the motions of releases
//! ([`crate::elastics`]).

use std::sync::Arc;

use nalgebra::{Isometry3, Vector3};

use crate::description::robot::FrameIndex;
use crate::elements::{ElasticElement, Material, Section, Spring, VertexIndex};
use crate::parameter::Slot;

/// Elastic structure of a model.
#[derive(Debug, Clone, Default)]
pub struct Structure {
    /// Vertices, each after the one it hangs on.
    pub vertices: Vec<Vertex>,
    /// What each vertex hangs on: its parent, and the element between; entry 0, the ground's, is void.
    pub tree: Vec<Edge>,
    /// Elements that close loops, and springs between bodies.
    pub closures: Vec<Edge>,
    /// Springs between bodies as declared; they are among the closures too.
    pub springs: Vec<Arc<Spring>>,
    /// Masses.
    pub masses: Vec<MassElement>,
    /// Acceleration of gravity, base axes, m/s2.
    pub gravity: Vector3<f64>,
    /// Materials, by index.
    pub materials: Vec<Material>,
    /// Sections, by index.
    pub sections: Vec<Section>,
    /// Vertices of the body of each frame.
    pub bodies: Vec<Vec<VertexIndex>>,
    /// Frames with all joints at zero (slides in the middle of their limits), loops open: where on a body something is
    /// attached.
    pub home: Vec<Isometry3<f64>>,
    /// Nodes by name, and the vertex that each is.
    pub nodes: Vec<(String, VertexIndex)>,
    /// Beams whose length follows a joint.
    pub booms: Vec<Boom>,
    /// Degrees of freedom of the nodes that are not joined rigidly, and of those left when the ground is held.
    pub freedom: [usize; 2],
}

/// A beam whose length follows a prismatic joint.
#[derive(Debug, Clone, PartialEq)]
pub struct Boom {
    /// Name of the beam.
    pub name: String,
    /// Its two vertices.
    pub ends: [VertexIndex; 2],
    /// The frame that slides, along its z.
    pub frame: FrameIndex,
    /// Whether its second end slides, or its first.
    pub second_slides: bool,
    /// Whether it points along that axis, or against it, as far as something of it is out.
    pub is_along: bool,
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
#[derive(Debug, Clone)]
pub struct Edge {
    /// What reports call it: `joint:2`, `beam:b1` (each part of it), `base`, ...
    pub name: String,
    /// Vertices; in the tree: parent, child.
    pub ends: [VertexIndex; 2],
    /// What it is.
    pub element: Arc<dyn ElasticElement>,
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

impl Structure {
    /// All elements: those of the tree by vertex, then the closures.
    pub fn edges(&self) -> impl Iterator<Item = &Edge> {
        self.tree.iter().chain(&self.closures)
    }

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

    /// The frame of the first of some vertices that moves with one.
    pub fn frame_of(&self, vertices: [VertexIndex; 2]) -> Option<FrameIndex> {
        vertices.into_iter().find_map(|vertex| match self.vertices[vertex].spot {
            Spot::At(frame, _) => Some(frame),
            Spot::Between(..) => None,
        })
    }

    /// Vertices from a vertex to the ground, the ground left out.
    pub fn path(&self, vertex: VertexIndex) -> impl Iterator<Item = VertexIndex> {
        std::iter::successors(Some(vertex), |&v| Some(self.tree[v].ends[0])).take_while(|&v| v != 0)
    }
}

/// The nearest of some vertices, of which every body has one; of equally near ones the first.
pub(super) fn nearest(
    among: &[VertexIndex],
    at: &Vector3<f64>,
    position: impl Fn(VertexIndex) -> Vector3<f64>,
) -> VertexIndex {
    let mut best = (f64::INFINITY, among[0]);
    for &vertex in among {
        let distance = (position(vertex) - at).norm();
        if distance < best.0 - 1e-9 {
            best = (distance, vertex);
        }
    }
    best.1
}
