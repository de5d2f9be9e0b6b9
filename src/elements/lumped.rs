//! Springs concentrated at a point: joints ka, kr, kar, krr in the joint's frame, the pedestal, supports, pins, released
//! ends of beams.

use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};

use super::beam::{self, Normal};
use super::element::{
    BodyPoint, Configuration, Direction, ElasticElement, Frames, Held, MotionRate, ParameterUse, Placed, Rate,
    VertexIndex, VertexMotion,
};
use super::flexibility::Flexibility;
use super::per_length::PerLength;
use super::screw::ScrewTriangle;
use crate::description::robot::FrameIndex;
use crate::parameter::Slot;

/// Six springs at a point, along and about the axes of a frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Lumped {
    /// The point.
    pub at: BodyPoint,
    /// Its axes.
    pub axes: Axes,
    /// Along x, y, z, about x, y, z.
    pub laws: [Law; 6],
    /// What each direction is called.
    pub symbols: [&'static str; 6],
    /// The beam of which it is a released end.
    pub end_of: Option<String>,
    /// Whether it closes a loop in the plane normal to its z axis only.
    pub in_plane: bool,
}

/// How a direction deforms.
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
        /// The screw.
        screw: ScrewTriangle,
    },
    /// Free, or held by a soft spring of this stiffness.
    Released(Option<Slot>),
}

/// Whose axes a lumped element has.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Axes {
    /// A frame's.
    Frame(FrameIndex),
    /// A beam's own.
    Beam([BodyPoint; 2], Normal),
}

/// First part of the axial compliances of screws; a direction's own compliance is the part of its number.
const AXIAL: usize = 6;

impl Lumped {
    /// A rigid joint of two vertices.
    pub fn rigid(frame: FrameIndex, symbols: [&'static str; 6]) -> Self {
        let at = BodyPoint { frame, point: Vector3::zeros() };
        Self { at, axes: Axes::Frame(frame), laws: [Law::Rigid; 6], symbols, end_of: None, in_plane: false }
    }

    fn rotation(&self, frames: &Frames) -> Matrix3<f64> {
        match self.axes {
            Axes::Frame(frame) => *frames[frame].rotation.matrix(),
            Axes::Beam(ends, normal) => {
                let [a, b] = ends.map(|end| end.place(frames));
                beam::axes(&a, &b, &normal.direction(frames)).0
            }
        }
    }

    fn flexibility(&self, at: &Configuration) -> Flexibility {
        let all = self.laws.map(|law| law.compliance(at.values, at.joints));
        if all.iter().all(|c| *c == 0.0) { Flexibility::Rigid } else { Flexibility::Diagonal(all) }
    }
}

impl Law {
    fn compliance(self, values: &[f64], joints: &[f64]) -> f64 {
        match self {
            Self::Rigid | Self::Released(_) => 0.0,
            Self::Compliance(slot) => values[slot],
            Self::Driven { own, axial, .. } if values[axial] == 0.0 => values[own],
            Self::Driven { own, axial, screw } => values[own] + values[axial] / screw.lever(values, joints).powi(2),
        }
    }
}

impl ElasticElement for Lumped {
    fn directions(&self) -> [Direction; 6] {
        self.laws.map(|law| match law {
            Law::Released(slot) => Direction::Released(slot),
            _ => Direction::Flexible,
        })
    }

    fn symbols(&self) -> Option<[&'static str; 6]> {
        Some(self.symbols)
    }

    fn parameters(&self) -> Vec<ParameterUse> {
        let mut all = Vec::new();
        for (part, law) in self.laws.iter().enumerate() {
            match *law {
                Law::Compliance(slot) => all.push(ParameterUse { slot, part }),
                Law::Driven { own, axial, .. } => {
                    all.push(ParameterUse { slot: own, part });
                    all.push(ParameterUse { slot: axial, part: part + AXIAL });
                }
                Law::Rigid | Law::Released(_) => {}
            }
        }
        all
    }

    fn is_active(&self, values: &[f64]) -> bool {
        !self.is_rigid(values)
    }

    fn is_rigid(&self, values: &[f64]) -> bool {
        self.laws.iter().all(|law| match *law {
            Law::Rigid => true,
            Law::Compliance(slot) => values[slot] == 0.0,
            Law::Driven { own, axial, .. } => values[own] == 0.0 && values[axial] == 0.0,
            Law::Released(_) => false,
        })
    }

    fn released_end_of(&self) -> Option<&str> {
        self.end_of.as_deref()
    }

    fn closes_in_plane(&self) -> bool {
        self.in_plane
    }

    fn place(&self, at: &Configuration, ends: [VertexIndex; 2], _: &PerLength) -> Placed {
        let rotation = at.turned(ends[0]) * self.rotation(at.frames);
        let origin = at.carried(ends[0], &self.at.place(at.frames));
        Placed::new(&rotation, &origin, self.flexibility(at))
    }

    fn pivot(&self, frames: &Frames, _: &[Vector3<f64>], _: [VertexIndex; 2]) -> Option<Vector3<f64>> {
        Some(self.at.place(frames))
    }

    fn held(&self, at: &Configuration, _: [VertexIndex; 2]) -> Held {
        let mut stiffness = Matrix6::zeros();
        for (k, law) in self.laws.iter().enumerate() {
            if let Law::Released(Some(slot)) = *law {
                stiffness[(k, k)] = at.values[slot];
            }
        }
        Held { stiffness, preload: Vector6::zeros() }
    }

    fn by_parameter(&self, part: usize, at: &Configuration) -> Rate {
        let direction = part % AXIAL;
        let rate = match self.laws[direction] {
            Law::Driven { screw, .. } if part >= AXIAL => 1.0 / screw.lever(at.values, at.joints).powi(2),
            _ => 1.0,
        };
        Rate::Flexibility(Flexibility::Single(direction, rate))
    }

    fn by_motion(&self, at: &Configuration, _: [VertexIndex; 2], moves: &VertexMotion) -> MotionRate {
        let origin = self.at.place(at.frames);
        let turn = match self.axes {
            Axes::Frame(axes) => moves.point(axes, &origin).1,
            Axes::Beam(ends, normal) => {
                let points = ends.map(|end| end.place(at.frames));
                let moved = [0, 1].map(|k| moves.point(ends[k].frame, &points[k]).0);
                beam::turn(points, moved, &normal, moves).0
            }
        };
        let mut found = MotionRate::of(&origin, moves.point(self.at.frame, &origin).0, turn);
        // Of a screw the lever changes.
        let driven = self.laws.iter().enumerate().find_map(|(direction, law)| match *law {
            Law::Driven { axial, screw, .. } if at.values[axial] != 0.0 => Some((direction, at.values[axial], screw)),
            _ => None,
        });
        if let Some((direction, axial, screw)) = driven {
            let [lever, rate] = screw.lever_rate(at, moves.motion);
            found.rate = Rate::Flexibility(Flexibility::Single(direction, -2.0 * rate / lever.powi(3) * axial));
        }
        found
    }
}
