//! Where an effect can sit: a frame, joint, link or actuator of the robot, its base, its tool, a marker, or the instrument.

use crate::description::robot::FrameIndex;

/// Kinds of site.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum SiteKind {
    /// `frame:<n>`
    Frame,
    /// `joint:<n>`: one that has a coordinate; of single effects also one that an actuator's angle or a loop moves.
    Joint,
    /// `joints`: all joints that have a coordinate, together.
    Joints,
    /// `link:<n>`: the body that moves with frame n.
    Link,
    /// `actuator:<name>`
    Actuator,
    /// `base`
    Base,
    /// `tool`
    Tool,
    /// `marker:<name>`
    Marker,
    /// `instrument`
    Instrument,
}

/// A site on a robot.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Site {
    /// As written: `joint:2`, `base`.
    pub name: String,
    /// Its kind.
    pub kind: SiteKind,
    /// Its frame, of a frame, joint or link; the driven joint's of an actuator; that of the body that carries a marker.
    pub frame: FrameIndex,
    /// The coordinate ([`crate::model::Model::coordinates`]) that moves the joint or actuator; `None` of other sites, and of joints
    /// that a loop moves.
    pub coordinate: Option<usize>,
    /// The actuator, by index in [`crate::model::Model::actuators`]; of sites that are actuators.
    pub actuator: Option<usize>,
    /// The marker, by index in [`crate::model::Model::markers`]; of sites that are markers.
    pub marker: Option<usize>,
}

impl Site {
    /// What belongs to its coordinate, in a list by coordinates.
    pub fn of<'a, T>(&self, by_coordinate: &'a [T]) -> Option<&'a T> {
        by_coordinate.get(self.coordinate?)
    }
}

impl SiteKind {
    /// How a description writes a site of this kind: `joint:<name>`, `base`.
    pub fn written(self) -> &'static str {
        match self {
            Self::Frame => "frame:<name>",
            Self::Joint => "joint:<name>",
            Self::Joints => "joints",
            Self::Link => "link:<name>",
            Self::Actuator => "actuator:<name>",
            Self::Base => "base",
            Self::Tool => "tool",
            Self::Marker => "marker:<name>",
            Self::Instrument => "instrument",
        }
    }
}
