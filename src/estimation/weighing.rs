//! How angles weigh against lengths where a campaign does not state the noise of orientations: by what a calibration leaves
//! of both.
//!
//! Of readings whose noise has two unknown variances the ratio of what is left of each kind, fitted again until it stands, is the
//! weight (iterated almost unbiased estimation of variance components; Foerstner 1979). Medians of the residuals' sizes stand for
//! their deviations, so that outliers do not decide.

use std::borrow::Cow;

use super::calibration::calibrate_as_weighed;
use super::result::{Calibration, CalibrationError, Comparison};
use super::settings::{Settings, Weights};
use crate::description::campaign::Campaign;
use crate::least_squares::Progress;
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

/// Calibrates `model` on the readings of `campaign` that are not `held_out` (one mark for each reading).
///
/// # Errors
/// [`CalibrationError`]; a fit that converges badly is no error but is named in [`Calibration::ending`].
///
/// ```
/// use elastogeo::estimation::{Settings, calibrate, split};
///
/// // Six joint compliances from deflections of a KR-270.
/// let loaded = elastogeo::files::load_campaign("kr270-no-compensator", None)?;
/// let held_out = split(&loaded.campaign, 0.25, 1);
/// let found = calibrate(&loaded.robot.model, &loaded.campaign, &held_out, &Settings::default(), &mut |_| {})?;
/// let [before, after] = [found.before, found.after].map(|errors| 1e3 * errors.check.distance[1]);
/// assert_eq!(format!("{before:.4} -> {after:.4} mm"), "0.6813 -> 0.0714 mm");
/// # Ok::<(), elastogeo::Error>(())
/// ```
pub fn calibrate(
    model: &Model,
    campaign: &Campaign,
    held_out: &[bool],
    settings: &Settings,
    progress: &mut dyn FnMut(&Progress),
) -> Result<Calibration, CalibrationError> {
    calibrate_as_weighed(model, &*weighed(model, campaign, held_out, settings)?, held_out, settings, progress)
}

/// Ordinary and weighted least squares next to each other.
///
/// # Errors
/// As [`calibrate`].
pub fn compare(
    model: &Model,
    campaign: &Campaign,
    held_out: &[bool],
    settings: &Settings,
) -> Result<Comparison, CalibrationError> {
    let with = |weights| calibrate(model, campaign, held_out, &Settings { weights, ..settings.clone() }, &mut |_| {});
    Ok(Comparison { ols: with(Weights::Equal)?, wls: with(Weights::Direction)? })
}
