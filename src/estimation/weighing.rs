//! How angles weigh against lengths where a campaign does not state the noise of orientations: by what a calibration leaves
//! of both.
//!
//! Of readings whose noise has two unknown variances the ratio of what is left of each kind, fitted again until it stands, is the
//! weight (iterated almost unbiased estimation of variance components; Foerstner 1979). Medians of the residuals' sizes stand for
//! their deviations, so that outliers do not decide.

use std::borrow::Cow;

use super::calibration::calibrate_as_weighed;
use super::result::CalibrationError;
use super::settings::{Settings, Weights};
use crate::description::campaign::Campaign;
use crate::math::median;
use crate::model::Model;

/// Fits: the first ratio is within a few per cent where both kinds determine the same parameters.
const ROUNDS: usize = 3;
/// Least and greatest noise of orientations for one of lengths, rad/m: what trackers and cameras have lies within.
const RATIOS: [f64; 2] = [1e-2, 1e3];

/// The campaign with the noise of its orientations as the readings to be fitted show it, where it has both lengths and angles and
/// does not state that of angles; else as it is.
///
/// # Errors
/// As [`super::calibrate`].
pub fn weighed<'c>(
    model: &Model,
    campaign: &'c Campaign,
    held_out: &[bool],
    settings: &Settings,
) -> Result<Cow<'c, Campaign>, CalibrationError> {
    let has_both = campaign.readings.iter().any(|reading| {
        let lengths = reading.observes.length_rows();
        reading.observes.by_variable().is_none() && lengths > 0 && reading.observes.rows() > lengths
    });
    if campaign.sigma_orientation.is_some() || settings.weights != Weights::Stated || !has_both {
        return Ok(Cow::Borrowed(campaign));
    }
    let asked = Settings { second_order: false, ..settings.clone() };
    let mut weighed = campaign.clone();
    for _ in 0..ROUNDS {
        let found = calibrate_as_weighed(model, &weighed, held_out, &asked, &mut |_| {})?;
        let (mut lengths, mut angles) = (Vec::new(), Vec::new());
        for ((reading, own), _) in weighed.by_reading(&found.residual, 1).zip(held_out).filter(|(_, held)| !**held) {
            let sigmas = reading.observes.sigmas(&reading.noise);
            let count = reading.observes.length_rows();
            if reading.observes.by_variable().is_some() || count == 0 || own.len() == count {
                continue;
            }
            let over = |range: std::ops::Range<usize>| own[range.clone()].iter().zip(sigmas[range].to_vec());
            lengths.extend(over(0..count).map(|(r, s)| (r / s).abs()));
            angles.extend(over(count..own.len()).map(|(r, s)| (r / s).abs()));
        }
        let (Some(of_lengths), Some(of_angles)) = (median(&mut lengths), median(&mut angles)) else { break };
        if !(of_lengths > 0.0 && of_angles > 0.0) {
            break;
        }
        for noise in weighed.readings.iter_mut().map(|reading| &mut reading.noise) {
            let sigma = noise.orientation * of_angles / of_lengths;
            noise.orientation = sigma.clamp(RATIOS[0] * noise.position[0], RATIOS[1] * noise.position[0]);
        }
    }
    Ok(Cow::Owned(weighed))
}
