//! What checks look at, and their limits.

use crate::description::campaign::Campaign;
use crate::estimation::Calibration;
use crate::model::Model;

/// What a check may look at.
#[derive(Clone, Copy)]
pub struct Evidence<'a> {
    /// The robot.
    pub model: &'a Model,
    /// Its readings.
    pub campaign: &'a Campaign,
    /// What was fitted to them.
    pub found: &'a Calibration,
}

/// Limits of the checks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// Farthest that base, tool or a marker may stand, m. Instruments of robot calibration (trackers, cameras, draw wires)
    /// reach less than 100 m; what a fit puts beyond that is a direction that ran away.
    pub farthest: f64,
}

impl Default for Limits {
    fn default() -> Self {
        Self { farthest: 100.0 }
    }
}
