//! How angles weigh against lengths where a campaign states the noise of one of them only, or of neither, and deflections against places:
//! by what a calibration leaves of both. What is stated stays as it is.
//!
//! The residuals of what is stated and of what is not estimate the variances; their ratio is the weight of the next fit, until it
//! no longer changes (iterated almost unbiased estimation of variance components; Foerstner 1979). Medians of the residuals' sizes stand for
//! their deviations, and Huber's weights keep outliers from the fit.

use std::borrow::Cow;

use nalgebra::{DMatrix, DVector};

use super::bound_springs::calibrate_as_weighed;
use super::problem::{row_kinds, row_sigmas};
use super::result::{Calibration, CalibrationError, Comparison};
use super::settings::{Settings, Weights};
use crate::description::campaign::{Campaign, Reading};
use crate::least_squares::{Progress, Status};
use crate::math::quantiles::{HUBER, OF_MEDIAN};
use crate::math::{least_squares, median};
use crate::model::Model;
use crate::prediction::{Predictor, residuals, with_holding_loads};

/// Most fits of the linear problem: the ratio converges linearly, slowly where one kind of rows weighs far too much at first.
const ROUNDS: usize = 200;
/// Scale of Huber's loss, in medians of sizes: 1.345 standard deviations.
const HUBER_OF_MEDIAN: f64 = HUBER * OF_MEDIAN;
/// Change of the ratio that counts as none.
const STEADY: f64 = 1e-3;
/// Least and greatest noise of orientations for one of lengths, rad/m: what trackers and cameras have lies within.
const RATIOS: [f64; 2] = [1e-2, 1e3];

/// Least and greatest noise of deflections for one of places: what either leaves of an unmodelled effect lies within.
const DEFLECTIONS: [f64; 2] = [1e-3, 1e3];

/// What weighs a row.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Weight {
    /// The noise that is stated; the lengths', where none is.
    Reference,
    /// What the fit leaves of lengths.
    Length,
    /// What the fit leaves of angles.
    Angle,
    /// What it leaves of lengths of differences beside places.
    Deflection,
    /// Neither a length nor an angle that is read.
    Other,
}

/// What weighs the rows of each kind (lengths, angles, others) of a reading.
fn weights(campaign: &Campaign) -> impl Fn(&Reading) -> [Weight; 3] + use<> {
    let states_lengths = |of: &Reading| of.observes.length_rows() > 0 && of.noise.is_stated[0];
    let states_angles = |of: &Reading| of.observes.angle_rows() > 0 && of.noise.is_stated[1];
    let is_by_angles = !campaign.readings.iter().any(states_lengths) && campaign.readings.iter().any(states_angles);
    let is_mixed = campaign.holds_differences() && !campaign.is_difference();
    move |reading| {
        let is_deflection = is_mixed && reading.observes.is_difference() && !reading.noise.is_stated[0];
        let length = match is_by_angles {
            _ if is_deflection => Weight::Deflection,
            true => Weight::Length,
            false => Weight::Reference,
        };
        let angle = if reading.noise.is_stated[1] { Weight::Reference } else { Weight::Angle };
        [length, angle, Weight::Other]
    }
}

/// The campaign with the noise of its orientations, or of its lengths, as the readings to be fitted show it, where it has both lengths
/// and angles and does not state that of both, and so that of deflections beside places; else as it is.
///
/// # Errors
/// As [`calibrate`].
pub fn weighed<'c>(
    model: &Model,
    campaign: &'c Campaign,
    held_out: &[bool],
    settings: &Settings,
) -> Result<Cow<'c, Campaign>, CalibrationError> {
    let has_both = |reading: &Reading| reading.observes.length_rows() > 0 && reading.observes.angle_rows() > 0;
    let weight = weights(campaign);
    let is_open = |reading: &Reading| {
        row_kinds(reading).any(|kind| !matches!(weight(reading)[kind], Weight::Reference | Weight::Other))
    };
    let is_known = settings.weights != Weights::Stated || !campaign.readings.iter().any(is_open);
    let is_mixed = campaign.readings.iter().any(|reading| weight(reading)[0] == Weight::Deflection);
    if is_known || !campaign.readings.iter().any(has_both) && !is_mixed {
        return Ok(Cow::Borrowed(campaign));
    }
    let asked = Settings { second_order: false, ..settings.clone() };
    let found = calibrate_as_weighed(model, campaign, held_out, &asked, &mut |_| {})?;
    let Some([of_lengths, of_angles, of_deflections]) = ratios(model, campaign, held_out, &found, &weight)? else {
        return Ok(Cow::Borrowed(campaign));
    };
    let mut weighed = campaign.clone();
    for reading in &mut weighed.readings {
        let [length, angle, _] = weight(reading);
        let noise = &mut reading.noise;
        if length == Weight::Length {
            let range = [noise.orientation / RATIOS[1], noise.orientation / RATIOS[0]];
            noise.position = noise.position.map(|sigma| (sigma * of_lengths).clamp(range[0], range[1]));
        }
        if length == Weight::Deflection {
            let of_deflections = of_deflections.clamp(DEFLECTIONS[0], DEFLECTIONS[1]);
            noise.position = noise.position.map(|sigma| sigma * of_deflections);
        }
        if angle == Weight::Angle {
            let sigma = noise.orientation * of_angles;
            noise.orientation = sigma.clamp(RATIOS[0] * noise.position[0], RATIOS[1] * noise.position[0]);
        }
    }
    Ok(Cow::Owned(weighed))
}

/// By how much the noise of lengths, of angles and of deflections, where it is not stated, is greater than assumed compared with what is, from the
/// problem linearised where a calibration ended; `None` where nothing shows it.
fn ratios(
    model: &Model,
    campaign: &Campaign,
    held_out: &[bool],
    found: &Calibration,
    weight: &impl Fn(&Reading) -> [Weight; 3],
) -> Result<Option<[f64; 3]>, CalibrationError> {
    let fitted = campaign.select(|index, _| held_out.get(index) != Some(&true));
    let kept = found.kept_slots();
    let predictor = Predictor::new(model, &fitted, kept)?;
    let at_end = predictor.linearised(&found.values)?;
    let (sigmas, width) = (row_sigmas(&fitted), predictor.slots.len());
    let of_rows = |reading: &Reading| row_kinds(reading).map(|kind| weight(reading)[kind]).collect::<Vec<_>>();
    let mut weights: Vec<Weight> = fitted.readings.iter().flat_map(of_rows).collect();
    weights.resize(sigmas.len(), Weight::Other);
    let (columns, right) = at_end.whitened(&sigmas);
    let open = [Weight::Length, Weight::Angle, Weight::Deflection];
    let ratio_of =
        |weight: Weight, ratios: &[f64; 3]| open.iter().position(|of| *of == weight).map_or(1.0, |k| ratios[k]);
    let (mut ratios, mut trust) = ([1.0; 3], vec![1.0; sigmas.len()]);
    for _ in 0..ROUNDS {
        let scale = |row: usize| trust[row] / ratio_of(weights[row], &ratios);
        let weighted = DMatrix::from_fn(sigmas.len(), width, |row, k| columns[(row, k)] * scale(row));
        let x = least_squares(&weighted, &DVector::from_fn(sigmas.len(), |row, _| right[row] * scale(row)));
        let left = &right - &columns * x;
        let size = |of: Weight| {
            let mut own: Vec<f64> =
                (0..weights.len()).filter(|&row| weights[row] == of).map(|row| left[row].abs()).collect();
            median(&mut own).filter(|size| *size > 0.0)
        };
        let Some(reference) = size(Weight::Reference) else { return Ok(None) };
        let mut change: f64 = 0.0;
        for (ratio, of) in ratios.iter_mut().zip(open).filter(|(_, of)| weights.contains(of)) {
            let Some(own) = size(of) else { return Ok(None) };
            change = change.max((own / reference / *ratio).ln().abs());
            *ratio = own / reference;
        }
        for (row, trust) in trust.iter_mut().enumerate().filter(|(row, _)| weights[*row] != Weight::Other) {
            let scale = HUBER_OF_MEDIAN * reference * ratio_of(weights[row], &ratios);
            *trust = (scale / left[row].abs().max(f64::MIN_POSITIVE)).min(1.0).sqrt();
        }
        if change < STEADY {
            break;
        }
    }
    Ok(ratios.iter().all(|ratio| ratio.is_finite()).then_some(ratios))
}

/// Calibrates `model` on the readings of `campaign` that are not `held_out` (one mark for each reading). Where loads of joints are
/// measured, what the description puts on them is that of the values found ([`with_holding_loads`]), not of the declared ones.
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
    let weighed = weighed(model, campaign, held_out, settings)?;
    let mut found = calibrate_as_weighed(model, &weighed, held_out, settings, progress)?;
    let mut known = weighed;
    for _ in 0..LOADED {
        let loaded = with_holding_loads(model, &known, &found.values)?;
        if !found.converged() || are_steady(&known, &loaded) {
            break;
        }
        known = Cow::Owned(loaded.into_owned());
        found = calibrate_as_weighed(model, &known, held_out, settings, progress)?;
    }
    // As whoever predicts with the values found will see them.
    if let Cow::Owned(loaded) = with_holding_loads(model, &known, &found.values)? {
        found.residual = residuals(model, &loaded, &found.values)?;
        // Lengths that hardly show in places may wander with the loads that they make.
        if found.converged() && !are_steady(&known, &loaded) {
            found.ending = Status::IterationLimit;
        }
    }
    Ok(found)
}

/// Most fits with the loads of joints of the values found before. A length that is off by a thousandth changes them by about as much, so
/// that few are needed.
const LOADED: usize = 10;
/// Change of all read loads together, in standard deviations, that counts as none: no estimate moves by more of its own.
const LOAD_CHANGE: f64 = 0.05;
/// The same of loads that deflect joints, over their root mean square: no compliance moves by more.
const DEFLECTING_CHANGE: f64 = 1e-4;

/// Whether the loads of joints are the same in two versions of a campaign, but for what no estimate shows.
fn are_steady(before: &Campaign, after: &Campaign) -> bool {
    let read = before.readings.iter().zip(&after.readings).filter(|(of, _)| of.observes.by_variable().is_some());
    let moved: f64 = read.map(|(before, after)| ((after.load - before.load) / before.noise.load).powi(2)).sum();
    let described = |of: &Campaign| of.conditions.described_loads.concat();
    let (old, new) = (described(before), described(after));
    let pairs = || old.iter().zip(&new).filter(|(a, b)| a.is_finite() && b.is_finite());
    let size: f64 = pairs().map(|(_, b)| b * b).sum();
    let change: f64 = pairs().map(|(a, b)| (a - b).powi(2)).sum();
    moved.sqrt() <= LOAD_CHANGE && change <= DEFLECTING_CHANGE.powi(2) * size
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
