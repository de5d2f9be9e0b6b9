//! How angles weigh against lengths where a campaign does not state the noise of orientations: by what a calibration leaves
//! of both.
//!
//! The residuals of lengths and of angles estimate the two unknown variances; their ratio is the weight of the next fit, until it
//! no longer changes (iterated almost unbiased estimation of variance components; Foerstner 1979). Medians of the residuals' sizes stand for
//! their deviations, and Huber's weights keep outliers from the fit.

use std::borrow::Cow;

use nalgebra::{DMatrix, DVector};

use super::bound_springs::calibrate_as_weighed;
use super::problem::{row_kinds, row_sigmas};
use super::result::{Calibration, CalibrationError, Comparison};
use super::settings::{Settings, Weights};
use crate::description::campaign::{Campaign, Reading};
use crate::least_squares::Progress;
use crate::math::{least_squares, median};
use crate::model::Model;
use crate::prediction::{Linearised, Predictor};

/// Most fits of the linear problem: the ratio converges linearly, slowly where one kind of rows weighs far too much at first.
const ROUNDS: usize = 200;
/// Scale of Huber's loss, in medians of sizes: 1.345 standard deviations.
const HUBER: f64 = 1.345 * 1.4826;
/// Change of the ratio that counts as none.
const STEADY: f64 = 1e-3;
/// Least and greatest noise of orientations for one of lengths, rad/m: what trackers and cameras have lies within.
const RATIOS: [f64; 2] = [1e-2, 1e3];

/// The campaign with the noise of its orientations as the readings to be fitted show it, where it has both lengths and angles and
/// does not state that of angles; else as it is.
///
/// # Errors
/// As [`calibrate`].
pub fn weighed<'c>(
    model: &Model,
    campaign: &'c Campaign,
    held_out: &[bool],
    settings: &Settings,
) -> Result<Cow<'c, Campaign>, CalibrationError> {
    let has_both = |reading: &Reading| {
        let lengths = reading.observes.length_rows();
        reading.observes.by_variable().is_none() && lengths > 0 && reading.observes.rows() > lengths
    };
    let is_known = campaign.sigma_orientation.is_some() || settings.weights != Weights::Stated;
    if is_known || !campaign.readings.iter().any(has_both) {
        return Ok(Cow::Borrowed(campaign));
    }
    let asked = Settings { second_order: false, ..settings.clone() };
    let found = calibrate_as_weighed(model, campaign, held_out, &asked, &mut |_| {})?;
    let mut weighed = campaign.clone();
    let Some(ratio) = ratio(model, campaign, held_out, &found)? else { return Ok(Cow::Borrowed(campaign)) };
    for noise in weighed.readings.iter_mut().map(|reading| &mut reading.noise) {
        let sigma = noise.orientation * ratio;
        noise.orientation = sigma.clamp(RATIOS[0] * noise.position[0], RATIOS[1] * noise.position[0]);
    }
    Ok(Cow::Owned(weighed))
}

/// By how much the noise of angles is greater than stated compared with that of lengths, from the problem linearised where a calibration
/// ended; `None` where nothing shows it.
fn ratio(
    model: &Model,
    campaign: &Campaign,
    held_out: &[bool],
    found: &Calibration,
) -> Result<Option<f64>, CalibrationError> {
    let fitted = campaign.select(|index, _| held_out.get(index) != Some(&true));
    let kept = found.identifiability.kept.iter().map(|&column| found.slots[column]).collect();
    let predictor = Predictor::new(model, &fitted, kept)?;
    let mut at_end = Linearised::default();
    predictor.linearise(&found.values, true, &mut at_end)?;
    let (sigmas, width) = (row_sigmas(&fitted), predictor.slots.len());
    let mut kinds: Vec<usize> = fitted.readings.iter().flat_map(row_kinds).collect();
    // Constraints are neither lengths nor angles that are read.
    kinds.resize(sigmas.len(), 2);
    let columns = DMatrix::from_fn(sigmas.len(), width, |row, k| at_end.jacobian[row * width + k] / sigmas[row]);
    let right = DVector::from_fn(sigmas.len(), |row, _| at_end.residual[row] / sigmas[row]);
    let (mut ratio, mut trust) = (1.0, vec![1.0; sigmas.len()]);
    for _ in 0..ROUNDS {
        let weight = |row: usize| if kinds[row] == 1 { trust[row] / ratio } else { trust[row] };
        let weighted = DMatrix::from_fn(sigmas.len(), width, |row, k| columns[(row, k)] * weight(row));
        let x = least_squares(&weighted, &DVector::from_fn(sigmas.len(), |row, _| right[row] * weight(row)));
        let left = &right - &columns * x;
        let of = |kind: usize| {
            let own = (0..kinds.len()).filter(|&row| kinds[row] == kind);
            median(&mut own.map(|row| left[row].abs()).collect::<Vec<_>>()).filter(|size| *size > 0.0)
        };
        let Some([lengths, angles]) = of(0).zip(of(1)).map(<[f64; 2]>::from) else { return Ok(None) };
        for (row, trust) in trust.iter_mut().enumerate().filter(|(row, _)| kinds[*row] < 2) {
            let scale = HUBER * if kinds[row] == 1 { angles } else { lengths };
            *trust = (scale / left[row].abs().max(f64::MIN_POSITIVE)).min(1.0).sqrt();
        }
        let change = (angles / lengths / ratio).ln().abs();
        ratio = angles / lengths;
        if change < STEADY {
            break;
        }
    }
    Ok(ratio.is_finite().then_some(ratio))
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
