//! Fuzzy compliances from deflections, each component with a partition of its own: conclusions in closed form, modal values
//! by a bounded optimiser, structure grown until the test error stops falling; and the grey box, a fuzzy correction of what a calibrated structure leaves.
//!
//! Source: IR663 calibration paper, sec. 2.2.2 and 3.3.2, with two changes. Conclusions are linear in the readings and
//! are solved for instead of descended to; modal values then are the only unknowns, and are found by Gauss-Newton steps
//! on the projected residual (Golub and Pereyra 1973). The paper's random search (Solis and Wets 1981) is an option.

mod grow;
mod modes;
mod rules;
mod samples;

pub use grow::{Grown, Step, SubModel};
pub use rules::Partition;
pub use samples::Level;

use super::calibrate;
use super::result::{Calibration, CalibrationError};
use super::settings::{Settings, What};
use super::statistics::{Errors, errors_of};
use crate::description::campaign::Campaign;
use crate::description::fuzzy::Input;
use crate::least_squares::Progress;
use crate::math::mean_rms_max;
use crate::model::Model;
use crate::prediction::{Linearised, Predictor};
use grow::grow;
use rules::cross_validated;
use samples::Samples;

/// How modal values are placed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Placement {
    /// Gauss-Newton on the residual that the best conclusions leave.
    GaussNewton,
    /// Random search of Solis and Wets (1981), seeded.
    SolisWets(u64),
}

/// A fitted model with its figures.
#[derive(Debug, Clone)]
pub struct FuzzyFit {
    /// The model (its [`Model::fuzzy`] set) with which the figures were made.
    pub model: Model,
    /// Values of its parameters.
    pub values: Vec<f64>,
    /// Rules and how they came about.
    pub grown: Grown,
    /// Errors of fitted readings and of those set aside.
    pub errors: [Errors; 2],
    /// Root mean square displacement measured, which a rigid robot would miss by, m: of the same.
    pub rigid: [f64; 2],
    /// Residuals of all readings, as [`Linearised::residual`].
    pub residual: Vec<f64>,
    /// Whether deflections grow as the load does.
    pub levels: Vec<Level>,
}

/// A grey box.
#[derive(Debug, Clone)]
pub struct GreyFit {
    /// The structure's calibration.
    pub parametric: Calibration,
    /// The correction; `None` where it does not help readings it has not seen.
    pub correction: Option<FuzzyFit>,
    /// Root mean square error over parts of the fitted readings left out in turns, m: without and with the correction.
    pub cross_validated: [f64; 2],
}

/// Least part by which a correction must lower the cross-validated error.
const WORTH: f64 = 0.03;

/// Fits a fuzzy compliance to the deflections that are not set `aside`; what the springs of the model give is left out.
/// `taken` hears of every set that is added.
///
/// # Errors
/// [`CalibrationError::Malformed`] where the readings are no deflections of one marker; see [`super::calibrate`].
pub fn fit_fuzzy(
    model: &Model,
    campaign: &Campaign,
    aside: &[bool],
    inputs: &[Input],
    placement: Placement,
    taken: &(dyn Fn(&Step) + Sync),
) -> Result<FuzzyFit, CalibrationError> {
    let samples = Samples::measured(model, campaign, aside, inputs)?;
    let grown = grow(&samples, placement, false, taken)?;
    let values = model.registry.nominal();
    finished(model, campaign, aside, inputs, &values, &samples, grown, false)
}

/// Calibrates the structure, then fits a correction to what it leaves, and keeps it if it helps where it was not fitted.
///
/// # Errors
/// As [`fit_fuzzy`] and [`super::calibrate`].
#[allow(clippy::too_many_arguments)] // those of both fits
pub fn fit_grey(
    model: &Model,
    campaign: &Campaign,
    aside: &[bool],
    inputs: &[Input],
    placement: Placement,
    settings: &Settings,
    progress: &mut dyn FnMut(&Progress),
    taken: &(dyn Fn(&Step) + Sync),
) -> Result<GreyFit, CalibrationError> {
    let settings = Settings { what: Some(What { geometric: false, elastic: true }), ..settings.clone() };
    let parametric = calibrate(model, campaign, aside, &settings, progress)?;
    let samples = Samples::left(model, campaign, aside, inputs, &parametric)?;
    let grown = grow(&samples, placement, true, taken)?;
    let cross_validated = cross_validated(&samples, &grown);
    let helps = cross_validated[1] < (1.0 - WORTH) * cross_validated[0];
    let correction = if helps {
        let fit = finished(model, campaign, aside, inputs, &parametric.values, &samples, grown, true)?;
        let unseen = &parametric.after.check;
        (unseen.readings == 0 || fit.errors[1].distance[1] < unseen.distance[1]).then_some(fit)
    } else {
        None
    };
    Ok(GreyFit { parametric, correction, cross_validated })
}

#[allow(clippy::too_many_arguments)] // the end of both fits
fn finished(
    model: &Model,
    campaign: &Campaign,
    aside: &[bool],
    inputs: &[Input],
    values: &[f64],
    samples: &Samples,
    grown: Grown,
    adds: bool,
) -> Result<FuzzyFit, CalibrationError> {
    let mut model = model.clone();
    model.fuzzy = Some(rules::model_of(samples, &grown, inputs, adds));
    let mut found = Linearised::default();
    Predictor::new(&model, campaign, Vec::new())?.linearise(values, false, &mut found)?;
    let errors = [false, true].map(|set| errors_of(campaign, &found.residual, |i| aside[i] == set));
    let rigid = [false, true].map(|set| {
        let of = campaign.readings.iter().zip(aside).filter(|(_, aside)| **aside == set);
        mean_rms_max(of.map(|(r, _)| r.measured[..3].iter().map(|v| v * v).sum::<f64>().sqrt()))[1]
    });
    let levels = samples::levels(campaign, &found.residual);
    Ok(FuzzyFit { values: values.to_vec(), grown, errors, rigid, residual: found.residual, levels, model })
}
