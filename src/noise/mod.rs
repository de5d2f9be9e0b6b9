//! What a campaign says of its instrument without any robot: fixed reflectors, distances of markers that one body carries, and
//! readings repeated in place.
//! A calibration cannot fall below this noise, and what it leaves above it is the robot's.

mod found;
mod references;
mod repeats;
mod rigid_markers;

pub use found::{LEAST_FREEDOM, fill_noise};
pub use references::{Motion, ReferenceNoise, reference_noise};
pub use repeats::{Repeated, repeats};
pub use rigid_markers::rigid_markers;

use crate::math::median;
use crate::math::quantiles::{OF_MEDIAN, OF_QUARTER};

/// A standard deviation of a coordinate, found from readings.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NoiseEstimate {
    /// One sigma of a coordinate, m.
    pub sigma: f64,
    /// Degrees of freedom that it was found from.
    pub degrees_of_freedom: f64,
}

/// Root mean square of deviations over the same by their median, beyond which some are outliers and the median counts.
/// Of Gauss's distribution it is 1, of Student's with 3 degrees of freedom 1.5.
const WRONG: f64 = 2.0;

impl NoiseEstimate {
    /// From deviations from their means, each of the standard deviation sought but for the share that the mean takes: with so many
    /// degrees of freedom in all. Their root mean square, or by their median, or lower quartile, where some readings are wrong. `None` where nothing
    /// scatters.
    fn of(mut deviations: Vec<f64>, degrees_of_freedom: f64) -> Option<Self> {
        let squares: f64 = deviations.iter().map(|v| v * v).sum();
        let sigma = (squares / degrees_of_freedom).sqrt();
        let taken = (deviations.len() as f64 / degrees_of_freedom).sqrt();
        deviations.iter_mut().for_each(|v| *v = v.abs());
        let robust = median(&mut deviations)? * taken * OF_MEDIAN;
        let sigma = if robust > 0.0 && sigma > WRONG * robust { robust } else { sigma };
        // Where a third of the readings is wrong half of their differences are.
        deviations.sort_by(f64::total_cmp);
        let of_quarter = deviations.get(deviations.len() / 4)? * taken * OF_QUARTER;
        let sigma = if of_quarter > 0.0 && sigma > WRONG * of_quarter { of_quarter } else { sigma };
        (degrees_of_freedom > 0.0 && squares > 0.0).then_some(Self { sigma, degrees_of_freedom })
    }
}
