//! Image of what readings refer to in addition to the robot: `anchors:`, `contacts:`, `distances:`, `payloads:`.

use std::fmt;
use std::marker::PhantomData;

#[cfg(feature = "cli")]
use schemars::JsonSchema;
use serde::de::value::SeqAccessDeserializer;
use serde::de::{Error, IntoDeserializer, SeqAccess, Unexpected, Visitor};
use serde::{Deserialize, Deserializer, Serialize};

use crate::description::form::forms;

/// The word `unknown`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize)]
#[cfg_attr(feature = "cli", derive(JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Unknown {
    /// Estimated with the rest.
    Unknown,
}

/// A value, or `unknown`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[cfg_attr(feature = "cli", derive(JsonSchema))]
#[serde(untagged)]
pub enum OrUnknown<T> {
    /// Known.
    Known(T),
    /// To be estimated.
    Unknown(Unknown),
}

impl<T: Copy> OrUnknown<T> {
    /// What is known.
    pub fn known(self) -> Option<T> {
        match self {
            Self::Known(value) => Some(value),
            Self::Unknown(_) => None,
        }
    }
}

/// What may be unknown, and how it is written where it is known.
pub trait MayBeUnknown {
    /// Its form, in words.
    const FORM: &'static str;
}

impl MayBeUnknown for f64 {
    const FORM: &'static str = "a number";
}

impl MayBeUnknown for [f64; 3] {
    const FORM: &'static str = "three numbers as `[0, 0, 90]`";
}

impl<'de, T: Deserialize<'de> + MayBeUnknown> Deserialize<'de> for OrUnknown<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Reader<T>(PhantomData<T>);
        impl<'de, T: Deserialize<'de> + MayBeUnknown> Visitor<'de> for Reader<T> {
            type Value = OrUnknown<T>;
            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                write!(f, "{}, or `unknown`", T::FORM)
            }
            fn visit_str<E: Error>(self, text: &str) -> Result<OrUnknown<T>, E> {
                match text {
                    "unknown" => Ok(OrUnknown::Unknown(Unknown::Unknown)),
                    other => Err(E::invalid_value(Unexpected::Str(other), &self)),
                }
            }
            fn visit_f64<E: Error>(self, number: f64) -> Result<OrUnknown<T>, E> {
                let known = T::deserialize(number.into_deserializer());
                known.map(OrUnknown::Known).map_err(|_: E| E::invalid_type(Unexpected::Float(number), &self))
            }
            fn visit_i64<E: Error>(self, number: i64) -> Result<OrUnknown<T>, E> {
                self.visit_f64(number as f64)
            }
            fn visit_u64<E: Error>(self, number: u64) -> Result<OrUnknown<T>, E> {
                self.visit_f64(number as f64)
            }
            fn visit_seq<A: SeqAccess<'de>>(self, seq: A) -> Result<OrUnknown<T>, A::Error> {
                T::deserialize(SeqAccessDeserializer::new(seq)).map(OrUnknown::Known)
            }
        }
        deserializer.deserialize_any(Reader(PhantomData))
    }
}

/// A fixed point from which distances are measured, in the measurement frame.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[cfg_attr(feature = "cli", derive(JsonSchema))]
#[serde(untagged)]
pub enum RawAnchor {
    /// Known.
    At([f64; 3]),
    /// With what is unknown of it.
    Declared(RawDeclaredAnchor),
}

forms! {
    RawAnchor: "a point as `[0, 0, 900]`, or `{at: unknown, near: [0, 0, 900]}`",
    list at: [f64; 3] => RawAnchor::At(at),
    map declared: RawDeclaredAnchor => RawAnchor::Declared(declared)
}

/// A fixed point of which something may be unknown.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, Serialize)]
#[cfg_attr(feature = "cli", derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct RawDeclaredAnchor {
    /// Where it is.
    pub at: OrUnknown<[f64; 3]>,
    /// What the instrument shows at no distance; zero where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub zero: Option<OrUnknown<f64>>,
    /// Where it is about, if unknown: a start for the search.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub near: Option<[f64; 3]>,
}

impl RawAnchor {
    /// Where it is, if known.
    pub fn at(&self) -> Option<[f64; 3]> {
        match self {
            Self::At(at) => Some(*at),
            Self::Declared(declared) => declared.at.known(),
        }
    }
}

/// What a ball on the tool touches.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize)]
#[cfg_attr(feature = "cli", derive(JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum ContactKind {
    /// A cone or cup that holds the ball: its centre is a point.
    Socket,
    /// A flat face: the ball's centre is at its radius from it.
    Plane,
    /// A ball of the fixture: centres are at the sum of the radii.
    Sphere,
}

/// A place that the ball on the tool touches, in the measurement frame.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
#[cfg_attr(feature = "cli", derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct RawContact {
    /// What is touched.
    #[cfg_attr(feature = "cli", schemars(required))]
    pub kind: Option<ContactKind>,
    /// The column that says where the fixture stood: a contact is another one in each placement.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub group: Option<String>,
    /// The point: of a socket or sphere its centre, of a plane any point of it; unknown where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub at: Option<OrUnknown<[f64; 3]>>,
    /// Where it is about, if unknown: `plan` and `simulate` put it there.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub near: Option<[f64; 3]>,
    /// Of a plane its normal, towards the ball; unknown where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub normal: Option<OrUnknown<[f64; 3]>>,
    /// Distance of the ball's centre: of a sphere the sum of the radii, of a plane the ball's radius; of a sphere unknown
    /// where absent, of a plane zero.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub radius: Option<OrUnknown<f64>>,
}

/// The sensor of a joint's torque, or a motor current: shows gain times torque plus offset.
#[derive(Debug, Clone, Copy, Default, PartialEq, Deserialize, Serialize)]
#[cfg_attr(feature = "cli", derive(JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct RawTorque {
    /// What it shows per N.m (of a sliding joint per N); 1 where absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gain: Option<OrUnknown<f64>>,
    /// What it shows without load, in the unit of torques (of a sliding joint of forces); 0 where absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub offset: Option<OrUnknown<f64>>,
}
