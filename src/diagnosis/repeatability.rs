//! Noise that a gap is compared with.

use crate::description::campaign::{Campaign, NoiseOrigin};
use crate::estimation::row_sigmas;
use crate::noise::{Repeated, repeats};

/// Noise over the sigmas of the rows: 1 where files state it, or that of readings repeated at one configuration; `None` where
/// nothing shows it. Markers of one body and fixed reflectors show that of the instrument alone: what all markers of a configuration
/// share, such as the robot's own repeatability, is above it and no sign of a cause.
pub fn noise(campaign: &Campaign, least: f64) -> Option<f64> {
    let is_stated = campaign.sigma.is_some() && campaign.noise_origin == NoiseOrigin::Stated;
    if is_stated { Some(1.0) } else { repeatability(campaign, least) }
}

/// Noise over the sigmas of the rows, from readings of one point at one configuration under one load and from one side of
/// approach; `None` where they have fewer than `least` degrees of freedom.
fn repeatability(campaign: &Campaign, least: f64) -> Option<f64> {
    let (sigmas, first_rows) = (row_sigmas(campaign), campaign.first_rows());
    let found = repeats(campaign, Repeated::Anywhere, |reading, row| sigmas[first_rows[reading] + row])?;
    (found.degrees_of_freedom >= least).then_some(found.sigma)
}
