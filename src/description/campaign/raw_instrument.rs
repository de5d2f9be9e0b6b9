//! Image of `instrument:`.

#[cfg(feature = "cli")]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::description::units::Units;

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

impl RawInstrument {
    /// What it states, and what it does not say as others have it.
    #[must_use]
    pub fn or(self, others: Self) -> Self {
        Self {
            sigma: self.sigma.or(others.sigma),
            orientation: self.orientation.or(others.orientation),
            torque: self.torque.or(others.torque),
            ppm: self.ppm.or(others.ppm),
        }
    }

    /// The same in other units.
    #[must_use]
    pub fn in_units(&self, from: &Units, to: &Units) -> Self {
        let [length, angle, torque] = [
            from.length.factor() / to.length.factor(),
            from.angle.factor() / to.angle.factor(),
            from.torque.factor() / to.torque.factor(),
        ];
        let sigma = self.sigma.as_ref().map(|sigma| match *sigma {
            RawSigma::All(sigma) => RawSigma::All(sigma * length),
            RawSigma::ByAxis { x, y, z } => RawSigma::ByAxis { x: x * length, y: y * length, z: z * length },
        });
        let orientation = self.orientation.map(|sigma| sigma * angle);
        Self { sigma, orientation, torque: self.torque.map(|sigma| sigma * torque), ppm: self.ppm }
    }
}

/// Noise of a coordinate.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
#[cfg_attr(feature = "cli", derive(JsonSchema))]
#[serde(
    untagged,
    expecting = "the value fits none of the forms that are accepted here; write a number, or one for each axis as `{x: 0.02, y: 0.02, z: 0.05}`"
)]
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
