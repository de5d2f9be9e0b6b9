//! Noise of repeated readings.

use crate::description::campaign::Campaign;
use crate::estimation::row_sigmas;
use crate::noise::{Repeated, repeats};

/// Noise over the sigmas of the rows, from readings of one point at one configuration under one load and from one side of
/// approach; `None` where they have fewer than `least` degrees of freedom.
pub fn repeatability(campaign: &Campaign, least: f64) -> Option<f64> {
    let (sigmas, first_rows) = (row_sigmas(campaign), campaign.first_rows());
    let found = repeats(campaign, Repeated::Anywhere, |reading, row| sigmas[first_rows[reading] + row])?;
    (found.degrees_of_freedom >= least).then_some(found.sigma)
}
