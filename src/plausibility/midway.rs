//! Whether something was moved half-way through: a marker that slipped, a tripod that was knocked. What calibration leaves
//! then steps at one row, in axes of the measurement frame (the instrument) or of the body that carries the marker (the marker).
//!
//! Each row of the files is tried as the first one after the step, with three columns that are zero before it and an axis each
//! from it on, fitted with all that was fitted before (the test of Quandt, *J. Am. Stat. Assoc.* 55, 1960, for a change at an
//! unknown place; its chance is bounded by the sum over the places).

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

/// Least number of readings on either side: two or three wrong ones in a row are outliers and no step, and the three values of a
/// step are then found from 15 coordinates at least.
const LEAST: usize = 5;
/// Least diagonal of the Cholesky factor of a step's information beside what is fitted, of its information alone: below, fitted
/// parameters make the step themselves to within 0.1 %, and its size would be that of the model's errors times a thousand.
const FREE: f64 = 1e-3;

/// A step: what moved, the first reading after it, its size (m) and what is left (root mean square over stated noise).
struct Step {
    is_marker: bool,
    at: usize,
    by: f64,
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
    step.map(|step| said(evidence, &step)).into_iter().collect()
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
    let steps = [false, true].into_iter().filter_map(|is_marker| greatest(&fit, is_marker));
    let step = steps.max_by(|a, b| a.gain.total_cmp(&b.gain))?;
    // Fixed reflectors that moved by less say that instrument and base stood still.
    let moved = reference_noise(&campaign.references).and_then(|seen| seen.motion).map(|motion| motion.greatest);
    if !step.is_marker && moved.is_some_and(|moved| moved < limits.reference_step * step.by) {
        return None;
    }
    let total = fit.residual.norm_squared();
    let freedom = fit.freedom() - 3.0;
    // Of a robust fit the residuals are not orthogonal to what was fitted, and the gain of a step is none.
    if freedom < limits.noise_freedom || step.gain >= total {
        return None;
    }
    let left = (total - step.gain).max(f64::MIN_POSITIVE);
    let tried = (2 * fit.readings().len()) as f64;
    let chance = f_tail((step.gain / 3.0) / (left / freedom), 3.0, freedom) * tried;
    let fall = (total / left).sqrt();
    let noise = fit.least() * (left / freedom).sqrt().max(1.0);
    // Of half of the readings 1.5 in squares: those near the middle of a step hardly fall.
    let is_of_few = step.fall_of_half < limits.sessions_fall.sqrt();
    if chance > limits.chance || fall < limits.sessions_fall || is_of_few || step.by < limits.sessions_apart * noise {
        return None;
    }
    Some(Step { fall, ..step })
}

fn said(evidence: &Evidence, step: &Step) -> Diagnostic {
    let (campaign, fall) = (evidence.campaign, step.fall);
    let address = campaign.address(&campaign.readings[step.at]);
    let (what, remedy) = match step.is_marker {
        true => (
            "the marker moved on its body, or the tool was changed",
            "name sessions before and after it (column `session`) and write `estimate: {tool: per-session}`; or leave one part out",
        ),
        false => (
            "the instrument or the robot's base was moved",
            "name sessions before and after it (column `session`) and write `estimate: {base: per-session}`; or leave one part out",
        ),
    };
    let message = format!(
        "from {address} on readings are {} mm away from those before, and without that step errors fall to 1/{fall:.1}: {what}?",
        mm(step.by)
    );
    Diagnostic::warning(message)
        .code(Code::MovedMidway)
        .remedy(remedy)
        .figure("step_mm", 1e3 * step.by)
        .figure("fall", fall)
}

/// The step that takes most out of the residuals.
fn greatest(fit: &Fitted, is_marker: bool) -> Option<Step> {
    let (model, campaign) = (fit.evidence.model, fit.evidence.campaign);
    let geometry = Geometry::new(model, &fit.evidence.found?.values).ok()?;
    let mut placements = Placements::default();
    let count = fit.readings().len();
    // Rows of the files in their order.
    let mut order: Vec<usize> = (0..count).collect();
    order.sort_by_key(|&k| campaign.readings[fit.reading(k)].row);
    let width = fit.basis.ncols();
    let mut on_basis = DMatrix::<f64>::zeros(width, 3);
    let (mut square, mut right) = (Matrix3::<f64>::zeros(), Vector3::<f64>::zeros());
    let mut best: Option<Step> = None;
    let (mut behind, mut taken) = (Vec::with_capacity(count), (0, Vector3::zeros(), DMatrix::zeros(width, 3)));
    for (before, &k) in order.iter().enumerate().rev() {
        let index = fit.reading(k);
        let reading = &campaign.readings[index];
        let axes = match is_marker {
            true => {
                geometry.place(campaign.configuration(index), &mut placements).ok()?;
                axes_of_body(&geometry, &placements, reading)
            }
            false => Matrix3::identity(),
        };
        let first = fit.rows[k];
        let weights = Vector3::from_fn(|row, _| 1.0 / fit.sigma(first + row));
        let own: SMatrix<f64, 3, 3> = Matrix3::from_diagonal(&weights) * axes;
        behind.push((first, own));
        square += own.transpose() * own;
        right += own.transpose() * fit.residual.fixed_rows::<3>(first);
        on_basis += fit.basis.rows(first, 3).transpose() * own;
        if before < LEAST || count - before < LEAST {
            continue;
        }
        let free = square - Matrix3::from_iterator((on_basis.transpose() * &on_basis).iter().copied());
        // A step that the fitted parameters can make themselves.
        let Some(factor) = (free / square.trace()).cholesky().filter(|factor| factor.l().diagonal().min() > FREE)
        else {
            continue;
        };
        let by = factor.solve(&right) / square.trace();
        let gain = right.dot(&by);
        if best.as_ref().is_none_or(|best| gain > best.gain) {
            taken = (behind.len(), by, on_basis.clone());
            best = Some(Step { is_marker, at: index, by: by.norm(), gain, fall: 1.0, fall_of_half: 1.0 });
        }
    }
    best.map(|best| {
        let (last, by, on_basis) = taken;
        let mut left = &fit.residual + &fit.basis * (on_basis * by);
        for (first, own) in &behind[..last] {
            let mut rows = left.fixed_rows_mut::<3>(*first);
            rows -= own * by;
        }
        Step { fall_of_half: fall_to(fit, &order, &left), ..best }
    })
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
