//! Boxes that no link may pass through, at a placed configuration: links are the lines from each frame's origin to the next,
//! and from frames to the tool centre point and the markers.

use nalgebra::{Point3, Vector3};

use super::geometry::{Geometry, Placements};
use crate::description::raw::JointKind;
use crate::description::robot::FrameIndex;
use crate::model::Model;

/// A line that is inside a box by less than this (m) touches it.
const ROUNDED: f64 = 1e-9;

/// A link that passes through a box.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Entered<'m> {
    /// Name of the box.
    pub keep_out: &'m str,
    /// The link's ends.
    pub link: Link<'m>,
}

/// A straight line that moves with the robot.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Link<'m> {
    /// Name of the frame at whose origin it begins.
    pub from: &'m str,
    /// Where it ends.
    pub to: End<'m>,
}

/// An end of a link.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum End<'m> {
    /// The origin of the frame of this name.
    Frame(&'m str),
    /// The tool centre point.
    Tool,
    /// The marker of this name.
    Marker(&'m str),
}

impl std::fmt::Display for Entered<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} passes through `{}`", self.link, self.keep_out)
    }
}

impl std::fmt::Display for Link<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.to {
            End::Frame(name) => write!(f, "the link from frame {} to frame {name}", self.from),
            End::Tool => write!(f, "the line from frame {} to the tool", self.from),
            End::Marker(name) => write!(f, "the line from frame {} to marker {name}", self.from),
        }
    }
}

/// Links and boxes that they pass through, box by box. Nothing is computed where no box is declared.
pub fn entered<'g>(geometry: &'g Geometry, placements: &'g Placements) -> impl Iterator<Item = Entered<'g>> + 'g {
    let boxes = geometry.model.keep_out.iter();
    boxes.flat_map(move |keep_out| {
        let through = lines(geometry, placements).filter(|(_, [a, b])| passes_through(&keep_out.space, a, b));
        through.map(|(link, _)| Entered { keep_out: &keep_out.name, link })
    })
}

/// Links that stand still and pass through a box: no configuration keeps out of it.
pub fn always_entered<'g>(geometry: &'g Geometry, placements: &'g Placements) -> Option<Entered<'g>> {
    let model = geometry.model;
    let stands = |name: &str| model.frame(name).is_some_and(|frame| stands_still(model, frame));
    entered(geometry, placements)
        .find(|entered| stands(entered.link.from) && matches!(entered.link.to, End::Frame(to) if stands(to)))
}

/// Whether no joint moves a frame's origin: that of a revolute joint does not leave its axis.
fn stands_still(model: &Model, frame: FrameIndex) -> bool {
    let mut path = model.path(frame).into_iter();
    path.all(|on| !model.frames[on].moves() || on == frame && model.frames[on].joint == JointKind::Revolute)
}

fn lines<'g>(
    geometry: &'g Geometry,
    placements: &'g Placements,
) -> impl Iterator<Item = (Link<'g>, [Point3<f64>; 2])> + 'g {
    let model = geometry.model;
    let origin = |frame: FrameIndex| Point3::from(placements.frames[frame].translation.vector);
    let name = |frame: FrameIndex| model.frames[frame].name.as_str();
    let links = model.frames.iter().enumerate().skip(1).map(move |(index, frame)| {
        let link = Link { from: name(frame.antecedent), to: End::Frame(name(index)) };
        (link, [origin(frame.antecedent), origin(index)])
    });
    let point = move |frame: FrameIndex, at: Point3<f64>, to: End<'g>| {
        (Link { from: name(frame), to }, [origin(frame), placements.frames[frame] * at])
    };
    let tool = point(model.tool.0, geometry.tool().translation.vector.into(), End::Tool);
    let markers = model.markers.iter().enumerate();
    let markers = markers.map(move |(m, marker)| point(marker.frame, geometry.marker(m), End::Marker(&marker.name)));
    links.chain(std::iter::once(tool)).chain(markers)
}

/// Whether the line from `a` to `b` has a point inside the box, its faces left out (slab method: Kay and Kajiya 1986).
pub fn passes_through(space: &[[f64; 2]; 3], a: &Point3<f64>, b: &Point3<f64>) -> bool {
    let along: Vector3<f64> = b - a;
    let (mut enters, mut leaves) = (f64::NEG_INFINITY, f64::INFINITY);
    for k in 0..3 {
        let [low, high] = [space[k][0] + ROUNDED - a[k], space[k][1] - ROUNDED - a[k]];
        if along[k] == 0.0 {
            if !(low < 0.0 && 0.0 < high) {
                return false;
            }
        } else {
            let (one, other) = (low / along[k], high / along[k]);
            enters = enters.max(one.min(other));
            leaves = leaves.min(one.max(other));
        }
    }
    enters < leaves && enters < 1.0 && leaves > 0.0
}
