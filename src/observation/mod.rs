//! Kinds of readings: one file each says how it is written in files, what it reads of a measured point, how that changes
//! with the point, and its noise. To add a kind: its file, and its line in [`FAMILY`]; nothing else in the program asks which
//! kind a campaign has. SI throughout; vectors have the axes of the measurement frame.

mod axis;
mod contact;
mod deflection;
mod direction;
mod distance;
mod inclination;
mod kind;
mod orientation;
mod pose;
mod position;
mod torque;

#[cfg(feature = "cli")]
use std::borrow::Cow;

#[cfg(feature = "cli")]
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Serialize, Serializer};

pub use kind::{
    ANCHOR_COLUMN, CONTACT_COLUMN, MOST_ROWS, MOST_TARGET_VALUES, MeasuredPoint, Noise, Observation, PointDerivative,
    Purpose, Rows, TargetValues, Twist, ValueColumn, XYZ, rows_of,
};

/// The kind of a campaign's readings: a handle on an [`Observation`], equal by name.
#[derive(Clone, Copy)]
pub struct Observes(&'static dyn Observation);

/// Position of a marker or the tool centre point.
pub const POSITION: Observes = Observes(&position::Position);
/// Position and orientation of the tool.
pub const POSE: Observes = Observes(&pose::Pose);
/// Loaded position minus unloaded position.
pub const DEFLECTION: Observes = Observes(&deflection::Deflection);
/// Loaded pose minus unloaded pose.
pub const DEFLECTION_POSE: Observes = Observes(&deflection::DeflectionPose);
/// Length from a fixed anchor.
pub const DISTANCE: Observes = Observes(&distance::Distance);
/// A ball on the tool touches something; a reading's own kind is one of the three that follow.
pub const CONTACT: Observes = Observes(&contact::Contact);
/// A ball in a socket.
pub const SOCKET: Observes = Observes(&contact::Socket);
/// A ball on a face.
pub const PLANE: Observes = Observes(&contact::Surface::Plane);
/// A ball on a sphere.
pub const SPHERE: Observes = Observes(&contact::Surface::Sphere);

/// Orientation of the tool alone.
pub const ORIENTATION: Observes = Observes(&orientation::Orientation);

/// Direction of the tool's z axis.
pub const AXIS: Observes = Observes(&axis::AXIS);

/// Direction of gravity in a body.
pub const INCLINATION: Observes = Observes(&inclination::INCLINATION);

/// Torque with which a motor holds its joint.
pub const TORQUE: Observes = Observes(&torque::Torque);

/// All kinds, in the order in which help and schema list them.
pub const FAMILY: [Observes; 10] =
    [POSITION, POSE, DEFLECTION, DEFLECTION_POSE, DISTANCE, CONTACT, ORIENTATION, AXIS, INCLINATION, TORQUE];

impl Observes {
    /// A handle on a kind, which need not be in [`FAMILY`].
    pub const fn new(kind: &'static dyn Observation) -> Self {
        Self(kind)
    }
}

/// The kinds that campaign files and commands may name: those of [`FAMILY`], then a program's own. What reads a campaign
/// carries it (`files::Reader`).
#[derive(Debug, Clone, PartialEq)]
pub struct Kinds(Vec<Observes>);

impl Kinds {
    /// Those of [`FAMILY`].
    pub fn standard() -> Self {
        Self(FAMILY.to_vec())
    }

    /// With a kind of a program's own; another of its name that the program added before is replaced.
    ///
    /// # Errors
    /// The kind of [`FAMILY`] that has the name.
    pub fn with(mut self, kind: Observes) -> Result<Self, Observes> {
        if let Some(known) = FAMILY.into_iter().find(|known| *known == kind) {
            return Err(known);
        }
        self.0.retain(|known| *known != kind);
        self.0.push(kind);
        Ok(self)
    }

    /// All of them.
    pub fn iter(&self) -> impl Iterator<Item = Observes> {
        self.0.iter().copied()
    }

    /// A kind by its name in files.
    pub fn named(&self, name: &str) -> Option<Observes> {
        self.iter().find(|kind| kind.name() == name)
    }
}

impl Default for Observes {
    /// Positions, as where a campaign says nothing.
    fn default() -> Self {
        POSITION
    }
}

impl std::ops::Deref for Observes {
    type Target = dyn Observation;

    fn deref(&self) -> &Self::Target {
        self.0
    }
}

impl PartialEq for Observes {
    fn eq(&self, other: &Self) -> bool {
        self.name() == other.name()
    }
}

impl std::fmt::Debug for Observes {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

impl Serialize for Observes {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name())
    }
}

#[cfg(feature = "cli")]
impl JsonSchema for Observes {
    fn schema_name() -> Cow<'static, str> {
        "Observes".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        let kinds: Vec<_> = FAMILY
            .iter()
            .map(|kind| json_schema!({"description": kind.about(), "type": "string", "const": kind.name()}))
            .collect();
        json_schema!({"description": "What a reading is.", "oneOf": kinds})
    }
}
