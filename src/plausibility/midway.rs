//! Whether something was moved half-way through: a marker that slipped, a tripod that was knocked, a joint whose encoder was set anew.
//! What calibration leaves then steps at one row: in axes of the measurement frame (the instrument), of the body that carries the
//! marker (the marker), or by one turn or shift of a joint.
//!
//! Each row of the files is tried as the first one after the step, with columns that are zero before it and what moves each reading
//! from it on, fitted with all that was fitted before (the test of Quandt, *J. Am. Stat. Assoc.* 55, 1960, for a change at an
//! unknown place; its chance is bounded by the sum over the places). Of several the one with the least information criterion is told
//! (Schwarz, *Ann. Statist.* 6, 1978).

use nalgebra::{DMatrix, DVector, Matrix3, SMatrix, Vector3};

use super::evidence::{Evidence, Limits};
use super::fitted::Fitted;
use super::outlying::outlying;
use super::words::mm;
use crate::description::campaign::Reading;
use crate::diagnostic::{Code, Diagnostic};
use crate::kinematics::{Geometry, Placements};
use crate::math::median;
use crate::math::quantiles::f_tail;
use crate::noise::reference_noise;
use crate::prediction::{Linearised, Predictor};

/// Least number of readings on either side: two or three wrong ones in a row are outliers and no step, and the three values of a
/// step are then found from 15 coordinates at least.
const LEAST: usize = 5;
/// Least diagonal of the Cholesky factor of a step's information given what is fitted, over its information alone: below, fitted
/// parameters make the step themselves to within 0.1 %, and its size would be that of the model's errors times a thousand.
const FREE: f64 = 1e-3;

/// What moved.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum What {
    /// The instrument, or the robot's base.
    Instrument,
    /// The marker on its body, or the tool.
    Marker,
    /// The zero of a variable, by index.
    Zero(usize),
}

/// A step: what moved, the first reading after it, its size (m; of a zero what half of the readings after it moved at least), how many
/// values it has, what it takes out of the weighted squares.
struct Step {
    what: What,
    at: usize,
    by: f64,
    /// Of a zero, rad or m.
    change: f64,
    values: f64,
    gain: f64,
    /// Residuals with it over those without.
    fall: f64,
    /// The same of half of the readings: a few that are wrong leave the others where they were.
    fall_of_half: f64,
}

pub(super) fn stands_still(evidence: &Evidence, limits: &Limits) -> Vec<Diagnostic> {
    let Some(step) = stepped(evidence, limits, &[]) else { return Vec::new() };
    // A few readings that are simply wrong make a step of their own; after a knock all are.
    let wrong = outlying(evidence, limits).map_or_else(Vec::new, |(wrong, ..)| wrong);
    let row = |k: usize| evidence.campaign.readings[k].row;
    let later = || (0..evidence.campaign.readings.len()).filter(|&k| row(k) >= row(step.at));
    let are_some = 2 * later().filter(|k| wrong.contains(k)).count() < later().count();
    let step = if wrong.is_empty() || !are_some { Some(step) } else { stepped(evidence, limits, &wrong) };
    step.map(|step| described(evidence, &step)).into_iter().collect()
}

/// A step that is not chance, certain readings left out.
fn stepped(evidence: &Evidence, limits: &Limits, wrong: &[usize]) -> Option<Step> {
    let (campaign, found) = (evidence.campaign, evidence.found?);
    let is_position = |k: &usize| {
        let reading = &campaign.readings[*k];
        reading.observes.measured_position(&reading.measured).is_some()
    };
    if !found.converged() || campaign.is_difference() {
        return None;
    }
    let mut fit = Fitted::of(evidence)?;
    let out: Vec<usize> = (0..fit.readings().len()).filter(|&k| wrong.contains(&fit.reading(k))).collect();
    out.into_iter().for_each(|k| fit.leave_out(k));
    if !fit.readings().iter().all(is_position) || fit.readings().len() < 2 * LEAST {
        return None;
    }
    let total = fit.residual.norm_squared();
    let moves = Moves::of(&fit)?;
    let bodies = [What::Instrument, What::Marker].into_iter().filter_map(|what| greatest::<3>(&fit, &moves, what));
    let zeros = (0..moves.variables).filter_map(|k| greatest::<1>(&fit, &moves, What::Zero(k)));
    let price = (fit.residual.len() as f64).ln();
    let merit = |step: &Step| {
        let left = (total - step.gain).max(f64::MIN_POSITIVE);
        fit.residual.len() as f64 * left.ln() + price * step.values
    };
    let step = bodies.chain(zeros).min_by(|a, b| merit(a).total_cmp(&merit(b)))?;
    // Fixed reflectors that moved by less say that instrument and base stood still.
    let moved = reference_noise(&campaign.references).and_then(|seen| seen.motion).map(|motion| motion.greatest);
    if step.what == What::Instrument && moved.is_some_and(|moved| moved < limits.reference_step * step.by) {
        return None;
    }
    let freedom = fit.freedom() - step.values;
    // Of a robust fit the residuals are not orthogonal to what was fitted, and the gain of a step is none.
    if freedom < limits.noise_freedom || step.gain >= total {
        return None;
    }
    let left = (total - step.gain).max(f64::MIN_POSITIVE);
    let tried = ((2 + moves.variables) * fit.readings().len()) as f64;
    let chance = f_tail((step.gain / step.values) / (left / freedom), step.values, freedom) * tried;
    let fall = (total / left).sqrt();
    let noise = fit.least() * (left / freedom).sqrt().max(1.0);
    // Of half of the readings 1.5 in squares: those near the middle of a step hardly fall.
    let is_of_few = step.fall_of_half < limits.sessions_fall.sqrt();
    if chance > limits.chance || fall < limits.sessions_fall || is_of_few || step.by < limits.sessions_apart * noise {
        return None;
    }
    Some(Step { fall, ..step })
}

fn described(evidence: &Evidence, step: &Step) -> Diagnostic {
    let (campaign, fall) = (evidence.campaign, step.fall);
    let address = campaign.address(&campaign.readings[step.at]);
    // Readings that were held out stand between the last fitted one before the step and the first one after it.
    let row = |index: usize| campaign.readings[index].row;
    let is_before = |index: &usize| row(*index) < row(step.at);
    let held_out = evidence.found.map_or(&[][..], |found| &found.held_out);
    let last = (0..campaign.readings.len()).filter(is_before).max_by_key(|&index| row(index));
    let fitted = |index: &usize| held_out.get(*index) != Some(&true);
    let before = (0..campaign.readings.len()).filter(is_before).filter(fitted).max_by_key(|&index| row(index));
    let since = match before.filter(|_| last != before) {
        Some(before) => {
            format!("from a row after {} and up to {address}", campaign.address(&campaign.readings[before]))
        }
        None => format!("from {address} on"),
    };
    let (what, remedy) = match step.what {
        What::Marker => (
            "the marker moved on its body, or the tool was changed".to_owned(),
            "name sessions before and after it (column `session`) and write `estimate: {tool: per-session}`; or leave one part out",
        ),
        What::Instrument => (
            "the instrument or the robot's base was moved".to_owned(),
            "name sessions before and after it (column `session`) and write `estimate: {base: per-session}`; or leave one part out",
        ),
        What::Zero(k) => (
            evidence.model.variables.get(k).map_or_else(String::new, |variable| {
                let change = match variable.is_angle {
                    true => format!("{:+.4} deg", step.change.to_degrees()),
                    false => format!("{:+.4} mm", 1e3 * step.change),
                };
                format!("the zero of `{}` changed by {change} (an encoder set anew, a slip)", variable.name)
            }),
            "calibrate the part before it and the part after it each by itself; or correct the column of that joint in one of them",
        ),
    };
    let message = format!(
        "{since} readings are {} mm away from those before, and without that step errors fall to 1/{fall:.1}: {what}?",
        mm(step.by)
    );
    Diagnostic::warning(message)
        .code(Code::MovedMidway)
        .remedy(remedy)
        .figure("step_mm", 1e3 * step.by)
        .figure("fall", fall)
}

/// What turns and shifts move the fitted readings by.
struct Moves {
    variables: usize,
    /// Axes of the body of each reading's marker, measurement frame.
    bodies: Vec<Matrix3<f64>>,
    /// What a unit of each variable moves each reading by, m/rad or 1, measurement frame: reading by reading.
    zeros: Vec<Vector3<f64>>,
}

impl Moves {
    fn of(fit: &Fitted) -> Option<Self> {
        let (model, campaign) = (fit.evidence.model, fit.evidence.campaign);
        let values = &fit.evidence.found?.values;
        let geometry = Geometry::new(model, values).ok()?;
        let mut placements = Placements::default();
        let mut bodies = Vec::with_capacity(fit.readings().len());
        for &index in fit.readings() {
            geometry.place(campaign.configuration(index), &mut placements).ok()?;
            bodies.push(axes_of_body(&geometry, &placements, &campaign.readings[index]));
        }
        Some(Self { variables: model.variables.len(), bodies, zeros: by_variables(fit, values)? })
    }

    /// Of a reading, by its place among the fitted ones.
    fn columns<const N: usize>(&self, what: What, k: usize) -> SMatrix<f64, 3, N> {
        let full = match what {
            What::Instrument => Matrix3::identity(),
            What::Marker => self.bodies[k],
            What::Zero(variable) => {
                let moved = self.zeros[k * self.variables + variable];
                Matrix3::from_columns(&[moved, Vector3::zeros(), Vector3::zeros()])
            }
        };
        full.fixed_columns::<N>(0).into_owned()
    }
}

/// Change of a variable for the derivative of positions by it, rad or m: what cancels and what is curved are then below 1e-6 of a meter
/// and a radian.
const DIFFERENCE: f64 = 1e-4;

/// What a unit of each variable moves each fitted reading by: reading by reading, variables of one together.
fn by_variables(fit: &Fitted, values: &[f64]) -> Option<Vec<Vector3<f64>>> {
    let (model, campaign) = (fit.evidence.model, fit.evidence.campaign);
    let count = model.variables.len();
    let mut is_fitted = vec![false; campaign.readings.len()];
    fit.readings().iter().for_each(|&index| is_fitted[index] = true);
    let fitted = campaign.select(|index, _| is_fitted[index]);
    let left = |variable: usize, by: f64| -> Option<Vec<f64>> {
        let mut moved = fitted.clone();
        moved.joints.iter_mut().skip(variable).step_by(count).for_each(|value| *value += by);
        let mut all = Linearised::default();
        Predictor::new(model, &moved, Vec::new()).ok()?.linearise(values, false, &mut all).ok()?;
        Some(all.residual)
    };
    let mut found = vec![Vector3::zeros(); count * fit.readings().len()];
    for variable in 0..count {
        let (low, high) = (left(variable, -DIFFERENCE)?, left(variable, DIFFERENCE)?);
        for k in 0..fit.readings().len() {
            let first = fit.rows[k];
            // A residual is what was measured less what is predicted.
            found[k * count + variable] =
                Vector3::from_fn(|row, _| (low[first + row] - high[first + row]) / (2.0 * DIFFERENCE));
        }
    }
    Some(found)
}

/// The step that takes most out of the residuals.
fn greatest<const N: usize>(fit: &Fitted, moves: &Moves, what: What) -> Option<Step> {
    let campaign = fit.evidence.campaign;
    let count = fit.readings().len();
    // Rows of the files in their order.
    let mut order: Vec<usize> = (0..count).collect();
    order.sort_by_key(|&k| campaign.readings[fit.reading(k)].row);
    let width = fit.basis.ncols();
    let mut on_basis = DMatrix::<f64>::zeros(width, N);
    let (mut square, mut right) = (DMatrix::<f64>::zeros(N, N), DVector::<f64>::zeros(N));
    let mut best: Option<(Step, usize, DVector<f64>, DMatrix<f64>)> = None;
    let mut behind: Vec<(usize, SMatrix<f64, 3, N>)> = Vec::with_capacity(count);
    for (before, &k) in order.iter().enumerate().rev() {
        let first = fit.rows[k];
        let weights = Vector3::from_fn(|row, _| 1.0 / fit.sigma(first + row));
        let own: SMatrix<f64, 3, N> = Matrix3::from_diagonal(&weights) * moves.columns::<N>(what, k);
        behind.push((first, own));
        square += own.transpose() * own;
        right += own.transpose() * fit.residual.fixed_rows::<3>(first);
        on_basis += fit.basis.rows(first, 3).transpose() * own;
        let scale = square.trace();
        if before < LEAST || count - before < LEAST || scale <= 0.0 {
            continue;
        }
        let free = &square - on_basis.transpose() * &on_basis;
        // A step that the fitted parameters can make themselves.
        let Some(factor) = (free / scale).cholesky().filter(|factor| factor.l().diagonal().min() > FREE) else {
            continue;
        };
        let by = factor.solve(&right) / scale;
        let gain = right.dot(&by);
        if best.as_ref().is_none_or(|(best, ..)| gain > best.gain) {
            let step = Step {
                what,
                at: fit.reading(k),
                by: 0.0,
                change: by.get(0).copied().unwrap_or(0.0),
                values: N as f64,
                gain,
                fall: 1.0,
                fall_of_half: 1.0,
            };
            best = Some((step, behind.len(), by, on_basis.clone()));
        }
    }
    let (best, last, by, on_basis) = best?;
    let mut left = &fit.residual + &fit.basis * (on_basis * &by);
    for (first, own) in &behind[..last] {
        let mut rows = left.fixed_rows_mut::<3>(*first);
        rows -= own * &by;
    }
    let mut moved: Vec<f64> =
        order.iter().rev().take(last).map(|&k| (moves.columns::<N>(what, k) * &by).norm()).collect();
    Some(Step { by: median(&mut moved)?, fall_of_half: fall_to(fit, &order, &left), ..best })
}

/// Axes of the body that a reading's marker is on, measurement frame.
fn axes_of_body(geometry: &Geometry, placements: &Placements, reading: &Reading) -> Matrix3<f64> {
    let model = geometry.model;
    let frame = reading.marker.map_or(model.tool.0, |marker| model.markers[marker].frame);
    let base = geometry.placement(model.base_slot(reading.session));
    (base * placements.frames[frame]).rotation.into_inner()
}

/// By which factor the median error of readings falls to that of other residuals.
fn fall_to(fit: &Fitted, readings: &[usize], left: &DVector<f64>) -> f64 {
    let middle = |all: &DVector<f64>| {
        median(&mut readings.iter().map(|&k| all.fixed_rows::<3>(fit.rows[k]).norm()).collect::<Vec<f64>>())
    };
    let both = middle(&fit.residual).zip(middle(left));
    both.map_or(1.0, |(with, without)| with / without.max(f64::MIN_POSITIVE))
}
