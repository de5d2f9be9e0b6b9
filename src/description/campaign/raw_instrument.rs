//! Image of `instrument:`.

#[cfg(feature = "cli")]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The instrument's noise, one sigma.
#[derive(Debug, Clone, Default, PartialEq, Deserialize, Serialize)]
#[cfg_attr(feature = "cli", derive(JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct RawInstrument {
    /// Of each coordinate or distance, in the length unit: one number, or by axis.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sigma: Option<RawSigma>,
    /// Of each component of the orientation, in the angle unit.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub orientation: Option<f64>,
    /// Of a torque or force of a joint, in the unit of torques or forces.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub torque: Option<f64>,
    /// What is added to `sigma` with the distance from the instrument (the origin of the measurement frame), parts per million of it:
    /// one sigma is the sum of the two.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ppm: Option<f64>,
}

/// Noise of a coordinate.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
#[cfg_attr(feature = "cli", derive(JsonSchema))]
#[serde(untagged, expecting = "the value fits none of the forms that are accepted here")]
pub enum RawSigma {
    /// The same along all axes.
    All(f64),
    /// By axis.
    ByAxis {
        /// Along x.
        x: f64,
        /// Along y.
        y: f64,
        /// Along z.
        z: f64,
    },
}
