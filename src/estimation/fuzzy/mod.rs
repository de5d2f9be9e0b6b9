//! Fuzzy compliances from deflections: rules for each component on a grid of its own or in a tree, grown until the error of
//! configurations left out in turns stops falling; and the grey box: a fuzzy correction of what a calibrated structure
//! leaves, or local springs that rules blend.
//!
//! Source: IR663 calibration paper, sec. 2.2.2 and 3.3.2, with two changes. Conclusions are linear in the readings and
//! are solved for instead of descended to; modal values of grids then are the only unknowns, and are found by Gauss-Newton
//! steps on the projected residual (Golub and Pereyra 1973). The paper's random search (Solis and Wets 1981) is an option.
//! More inputs, by splits along the axes, and rules between parametric models are the paper's outlook.

mod components;
mod group;
mod grow;
mod grown;
mod inputs;
mod levels;
mod local;
mod modes;
mod normal;
mod partition;
mod samples;
mod settings;
mod task;
mod tree;
mod validation;

pub use grown::{Grown, Step, SubModel};
pub use inputs::changing_inputs;
pub use levels::Level;
pub use local::{LocalFit, fit_local};
pub use partition::Partition;
pub use settings::{FuzzySettings, Placement};
pub use task::{AxesOf, FuzzyTask, Structure};
pub use tree::TreeStep;

use super::result::{Calibration, CalibrationError};
use super::settings::{Settings, What};
use super::statistics::{Errors, errors_of};
use super::weighing::calibrate;
use crate::description::fuzzy::{Component, Fuzzy};
use crate::least_squares::Progress;
use crate::math::{mean_rms_max, norm};
use crate::model::Model;
use crate::prediction::residuals;
use components::grow_components;
use grow::grow_grids;
use samples::Samples;

/// A fitted model with its figures.
#[derive(Debug, Clone)]
pub struct FuzzyFit {
    /// The model (its [`Model::fuzzy`] set) with which the figures were made.
    pub model: Model,
    /// Values of its parameters.
    pub values: Vec<f64>,
    /// Rules and how they came about.
    pub grown: Grown,
    /// Errors of fitted readings and of those held out.
    pub errors: [Errors; 2],
    /// Root mean square displacement measured, which a rigid robot would miss by, m: of the same.
    pub rigid: [f64; 2],
    /// Residuals of all readings, as [`crate::prediction::Linearised::residual`].
    pub residual: Vec<f64>,
    /// Whether deflections grow as the load does.
    pub levels: Vec<Level>,
}

/// A grey box.
#[derive(Debug, Clone)]
pub struct GreyFit {
    /// The structure's calibration.
    pub parametric: Calibration,
    /// The correction; `None` where it does not help readings that it was not fitted to.
    pub correction: Option<FuzzyFit>,
    /// Root mean square error over parts of the fitted readings left out in turns, m: without and with the correction.
    pub cross_validated: [f64; 2],
}

/// Fits a fuzzy compliance to the deflections that are not held out, in place of the springs of the model. `taken` is
/// called with every set that is added.
///
/// # Errors
/// [`CalibrationError::Malformed`] where the readings are no deflections of one marker; see [`super::calibrate`].
pub fn fit_fuzzy(task: &FuzzyTask, taken: &(dyn Fn(&Step) + Sync)) -> Result<FuzzyFit, CalibrationError> {
    let values = task.model.registry.nominal();
    let (samples, grown) = grown_on(task, |axes| Samples::measured(task, axes, &values), false, taken)?;
    finished(task, values, grown, samples.marker, false)
}

/// Samples in the axes that were asked for, or that serve best, and the rules grown on them.
fn grown_on(
    task: &FuzzyTask,
    samples: impl Fn(AxesOf) -> Result<Samples, CalibrationError>,
    correction: bool,
    taken: &(dyn Fn(&Step) + Sync),
) -> Result<(Samples, Grown), CalibrationError> {
    let axes = match (task.axes, task.structure()) {
        (AxesOf::Best, Structure::Tree) => candidate_axes(task.model),
        (axes, _) => vec![axes],
    };
    let mut best: Option<(Samples, Grown)> = None;
    for axes in axes {
        let samples = samples(axes)?;
        if samples.columns.is_empty() {
            return Err(CalibrationError::Malformed("no fitted reading is loaded".into()));
        }
        let grown = grow(task, &samples, correction, taken);
        // The base's come first, and others only where they serve better.
        let worth =
            |(_, known): &(Samples, Grown)| grown.left_out < (1.0 - task.settings.worth).powi(2) * known.left_out;
        if best.as_ref().is_none_or(worth) {
            best = Some((samples, grown));
        }
    }
    let Some((samples, mut grown)) = best else {
        return Err(CalibrationError::Malformed("the robot has no frame".into()));
    };
    let outside = |&&k: &&usize| samples.x[k].iter().zip(&samples.range).any(|(x, [low, high])| x < low || x > high);
    grown.beyond = samples.indices(true, |_| true).iter().filter(outside).count();
    Ok((samples, grown))
}

/// Rules on samples, as asked for.
fn grow(task: &FuzzyTask, samples: &Samples, correction: bool, taken: &(dyn Fn(&Step) + Sync)) -> Grown {
    match task.structure() {
        Structure::Grid => grow_grids(samples, &task.settings, correction, taken),
        Structure::Tree => grow_components(samples, task.reciprocal, &task.settings, taken),
    }
}

/// The base's axes, and those of the frames that move between base and tool.
fn candidate_axes(model: &Model) -> Vec<AxesOf> {
    let mut frames = Vec::new();
    let mut frame = model.tool.0;
    while frame != 0 {
        if model.frames[frame].moves() {
            frames.push(AxesOf::Frame(frame));
        }
        frame = model.frames[frame].antecedent;
    }
    frames.push(AxesOf::Base);
    frames.reverse();
    frames
}

/// Calibrates the springs by `settings`, then fits a correction to the residuals, and keeps it if it helps readings that it
/// was not fitted to.
///
/// # Errors
/// As [`fit_fuzzy`] and [`super::calibrate`].
pub fn fit_grey(
    task: &FuzzyTask,
    settings: &Settings,
    progress: &mut dyn FnMut(&Progress),
    taken: &(dyn Fn(&Step) + Sync),
) -> Result<GreyFit, CalibrationError> {
    let settings = Settings { what: Some(What { geometric: false, elastic: true }), ..settings.clone() };
    let parametric = calibrate(task.model, task.campaign, task.held_out, &settings, progress)?;
    let left = |axes| Samples::new(task, axes, &parametric.values, &parametric.residual);
    let (samples, grown) = grown_on(task, left, true, taken)?;
    let again = |samples: &Samples| grow(task, samples, true, &|_: &Step| {});
    let cross_validated = validation::nested(&samples, task.settings.folds, &again);
    let mut correction = None;
    if cross_validated[1] < (1.0 - task.settings.correction_worth) * cross_validated[0] {
        let fit = finished(task, parametric.values.clone(), grown, samples.marker, true)?;
        let without = &parametric.after.check;
        let helps = without.readings == 0 || fit.errors[1].distance[1] < without.distance[1];
        correction = helps.then_some(fit);
    }
    Ok(GreyFit { parametric, correction, cross_validated })
}

/// The model with rules at a marker (the tool without one), and its figures. `adds` says that they correct the springs.
fn finished(
    task: &FuzzyTask,
    values: Vec<f64>,
    grown: Grown,
    marker: Option<usize>,
    adds: bool,
) -> Result<FuzzyFit, CalibrationError> {
    let (campaign, held_out) = (task.campaign, task.held_out);
    let mut model = task.model.clone();
    // An input with a single set everywhere has no influence.
    let used = grown.used();
    let components = grown.components.iter().map(|own| Component { at: own.at, rules: own.rules.over(&used) });
    model.fuzzy = Some(Fuzzy {
        components: components.collect(),
        inputs: used.iter().map(|&k| task.inputs[k]).collect(),
        at: marker,
        axes: grown.axes,
        adds,
    });
    let residual = residuals(&model, campaign, &values)?;
    let errors = [false, true].map(|set| errors_of(campaign, &residual, |i| held_out[i] == set));
    let rigid = [false, true].map(|set| {
        let of = campaign.readings.iter().zip(held_out).filter(|(_, held_out)| **held_out == set);
        mean_rms_max(of.map(|(r, _)| norm(&r.measured[..3])))[1]
    });
    let levels = levels::levels(campaign, &residual);
    Ok(FuzzyFit { values, grown, errors, rigid, residual, levels, model })
}
