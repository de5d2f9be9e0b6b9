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

use std::borrow::Cow;
use std::sync::{PoisonError, RwLock};

#[cfg(feature = "cli")]
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

pub use kind::{
    MOST_ROWS, MOST_TARGET_VALUES, MeasuredPoint, Noise, Observation, PointDerivative, Purpose, Rows, TargetValues,
    Twist, ValueColumn, XYZ, rows_of,
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
pub const PLANE: Observes = Observes(&contact::Plane);
/// A ball on a sphere.
pub const SPHERE: Observes = Observes(&contact::Sphere);

/// Orientation of the tool alone.
pub const ORIENTATION: Observes = Observes(&orientation::Orientation);

/// Direction of the tool's z axis.
pub const AXIS: Observes = Observes(&axis::Axis);

/// Direction of gravity in a body.
pub const INCLINATION: Observes = Observes(&inclination::Inclination);

/// Torque with which a motor holds its joint.
pub const TORQUE: Observes = Observes(&torque::Torque);

/// All kinds, in the order in which help and schema list them.
pub const FAMILY: [Observes; 10] =
    [POSITION, POSE, DEFLECTION, DEFLECTION_POSE, DISTANCE, CONTACT, ORIENTATION, AXIS, INCLINATION, TORQUE];

/// Kinds of a program's own. A file names its kind before anything else is known of it, so what can be named is of the process.
static OWN: RwLock<Vec<Observes>> = RwLock::new(Vec::new());

impl Observes {
    /// A handle on a kind, which need not be in [`FAMILY`].
    pub const fn new(kind: &'static dyn Observation) -> Self {
        Self(kind)
    }

    /// Makes a kind of a program's own known by its name: files and commands may name it from then on. One that the program
    /// added before under this name is replaced; what was read with it keeps it.
    ///
    /// # Errors
    /// The kind of [`FAMILY`] that has the name.
    pub fn add(kind: &'static dyn Observation) -> Result<Self, Self> {
        if let Some(known) = FAMILY.into_iter().find(|known| known.name() == kind.name()) {
            return Err(known);
        }
        let mut own = OWN.write().unwrap_or_else(PoisonError::into_inner);
        own.retain(|known| known.name() != kind.name());
        own.push(Self(kind));
        Ok(Self(kind))
    }

    /// All kinds that files may name: those of [`FAMILY`], then those that the program added.
    pub fn all() -> Vec<Self> {
        let own = OWN.read().unwrap_or_else(PoisonError::into_inner);
        FAMILY.into_iter().chain(own.iter().copied()).collect()
    }

    /// A kind by its name in files.
    pub fn named(name: &str) -> Option<Self> {
        Self::all().into_iter().find(|kind| kind.name() == name)
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

impl<'de> Deserialize<'de> for Observes {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let name = Cow::<str>::deserialize(deserializer)?;
        Self::named(&name).ok_or_else(|| {
            let known: Vec<String> = Self::all().iter().map(|kind| format!("`{}`", kind.name())).collect();
            serde::de::Error::custom(format!("unknown variant `{name}`, expected one of {}", known.join(", ")))
        })
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
