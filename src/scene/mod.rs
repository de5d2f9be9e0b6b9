//! The robot as it is drawn: points that move with its bodies, and the parts that join them. Everything is read off the
//! description: frames and what moves them, loops, actuators, beams with their sections, springs, masses, markers.
//!
//! A [`Scene`] is drawn up once for a robot; [`Scene::place`] gives its points at a configuration, [`Scene::deflect`]
//! how far load moves each of them.

mod parts;
mod place;
mod shot;

pub use parts::draw;
pub use shot::Shot;

use nalgebra::Vector3;
use serde::Serialize;

use crate::description::robot::FrameIndex;
use crate::elements::VertexIndex;

/// Kinds of part.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum PartKind {
    /// A body, as the polyline of its Khalil-Kleinfinger lengths from one frame to the next.
    Link,
    /// A joint: its origin, and a point along its axis.
    Joint,
    /// A frame: its origin, and the tips of x, y, z.
    Frame,
    /// Where a loop is closed: the two frames that meet.
    Cut,
    /// An actuator between its two pins: the one on the antecedent body first.
    Actuator,
    /// A beam: outline of its section at one end, then as many points at the other.
    Beam,
    /// A spring between its two anchors.
    Spring,
    /// A centre of mass.
    Mass,
    /// A measured point; from its frame to it.
    Marker,
    /// The tool centre point: its origin, and the tips of x, y, z.
    Tool,
    /// A fixed point of the instrument.
    Anchor,
}

/// How a joint moves, or the shape of a beam's section.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Form {
    /// A joint that turns.
    Revolute,
    /// A joint that slides.
    Prismatic,
    /// A beam of round section.
    Round,
    /// A beam of rectangular section, or of one that is drawn so.
    Box,
}

/// What drives a joint.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Drive {
    /// A commanded variable.
    Variable,
    /// An actuator between two bodies.
    Actuator,
    /// Other joints.
    Coupling,
    /// Its loop.
    Passive,
}

/// A part: what it is and the points that draw it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Part {
    /// Kind.
    pub kind: PartKind,
    /// Name, as the description writes it.
    pub name: String,
    /// What it is, in words with units.
    pub words: String,
    /// Its points, by index in [`Scene::points`].
    pub points: Vec<usize>,
    /// How a joint moves, or the shape of a beam's section.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub form: Option<Form>,
    /// What drives a joint.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub drive: Option<Drive>,
    /// Sites of the catalogue of effects that it stands for (`joint:2`, `link:2`, `actuator:screw2`, ...).
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub sites: Vec<String>,
}

/// A point that moves with the robot.
#[derive(Debug, Clone, PartialEq)]
pub struct Point {
    /// Where it is.
    pub spot: Spot,
    /// The vertex of the elastic structure with which it yields.
    pub vertex: VertexIndex,
}

/// Where a point is.
#[derive(Debug, Clone, PartialEq)]
pub enum Spot {
    /// Point of a frame, m.
    At(FrameIndex, Vector3<f64>),
    /// Pin of an actuator (0 on the antecedent body, 1 on the body it moves), by index of the actuator.
    Pin(usize, usize),
    /// Corner of a beam's section: the beam, its end (0 or 1), offsets along the local y and z, m.
    Corner(usize, usize, [f64; 2]),
    /// Point of the measurement frame, m.
    Measured(Vector3<f64>),
}

/// A robot as it is drawn.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Scene {
    /// Parts, in the order of the description.
    pub parts: Vec<Part>,
    /// Points.
    pub points: Vec<Point>,
    beams: Vec<Beam>,
    /// Length of drawn axes, m: a share of the robot's size.
    pub axis: f64,
}

/// A beam: its two nodes (frame, position in it, m), and the frame whose z is the local z.
#[derive(Debug, Clone, PartialEq)]
struct Beam {
    nodes: [(FrameIndex, Vector3<f64>); 2],
    normal: FrameIndex,
}
