//! Noise as a campaign states it: of its instrument, of a file's, of a row.

use super::raw::{RawInstrument, RawSigma};
use crate::description::units::Units;

/// Columns that state the noise of a row's lengths: their name, the axes of which they say it, and what one sigma is of what
/// they hold. An expanded uncertainty of 95 % is two standard ones (*Guide to the expression of uncertainty in
/// measurement*, G.6.6).
pub const NOISE_COLUMNS: [(&str, &[usize], f64); 5] = [
    ("sigma", &[0, 1, 2], 1.0),
    ("U95", &[0, 1, 2], 0.5),
    ("sigma.x", &[0], 1.0),
    ("sigma.y", &[1], 1.0),
    ("sigma.z", &[2], 1.0),
];

/// What is stated of an instrument, SI.
#[derive(Debug, Clone, Copy, Default)]
pub struct StatedNoise {
    /// One sigma of a coordinate by axis, m.
    pub sigma: Option<[f64; 3]>,
    /// One sigma of a component of an orientation, rad.
    pub orientation: Option<f64>,
    /// One sigma of the torque of a joint, N.m; of a sliding joint's force, N.
    pub load: Option<f64>,
    /// What is added to it with the distance, m/m.
    pub ppm: f64,
}

/// What is stated of an instrument, in SI.
pub fn stated_noise(instrument: Option<&RawInstrument>, units: &Units) -> StatedNoise {
    let (length, angle) = (units.length.factor(), units.angle.factor());
    let Some(instrument) = instrument else { return StatedNoise::default() };
    let sigma = instrument.sigma.as_ref().map(|sigma| match *sigma {
        RawSigma::All(sigma) => [sigma * length; 3],
        RawSigma::ByAxis { x, y, z } => [x * length, y * length, z * length],
    });
    let ppm = 1e-6 * instrument.ppm.unwrap_or_default();
    let load = instrument.torque.map(|sigma| sigma * units.torque.factor());
    StatedNoise { sigma, orientation: instrument.orientation.map(|sigma| sigma * angle), load, ppm }
}
