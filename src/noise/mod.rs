//! What a campaign says of its instrument without any robot: fixed reflectors, distances of markers that one body carries, and
//! readings repeated in place.
//! A calibration cannot fall below this noise, and what it leaves above it is the robot's.

mod references;
mod repeats;
mod rigid_markers;

pub use references::{Motion, ReferenceNoise, reference_noise};
pub use repeats::{Repeated, repeats};
pub use rigid_markers::rigid_markers;

/// A standard deviation of a coordinate, found from readings.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NoiseEstimate {
    /// One sigma of a coordinate, m.
    pub sigma: f64,
    /// Degrees of freedom that it was found from.
    pub degrees_of_freedom: f64,
}
