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

use crate::description::robot::FrameIndex;
use crate::elements::VertexIndex;

/// Kinds of part.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
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

/// A part: what it is and the points that draw it.
#[derive(Debug, Clone, PartialEq)]
pub struct Part {
    /// Kind.
    pub kind: PartKind,
    /// Name, as the description writes it.
    pub name: String,
    /// What it is, in words with units.
    pub words: String,
    /// How a joint moves: `revolute`, `prismatic`, `fixed`; the shape of a beam's section; else empty.
    pub form: &'static str,
    /// What drives a joint: `variable`, `actuator`, `coupling`, `passive`; else empty.
    pub drive: &'static str,
    /// Sites of the catalogue of effects that it stands for (`joint:2`, `link:2`, `actuator:screw2`, ...).
    pub sites: Vec<String>,
    /// Its points, by index in [`Scene::points`].
    pub points: Vec<usize>,
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
