//! Whether something was moved half-way through: a marker that slipped, a tripod that was knocked, a joint whose encoder was set anew.
//! What calibration leaves then steps at one row: in axes of the measurement frame (the instrument), of the body that carries the
//! marker (the marker), or by one turn or shift of a joint.
//!
//! Each reading, in the order of measurement where that is known and else in that of the files, is tried as the first one after the step, with columns that are zero before it and what moves each reading
//! from it on, fitted with all that was fitted before (the test of Quandt, *J. Am. Stat. Assoc.* 55, 1960, for a change at an
//! unknown place; its chance is bounded by the sum over the places). Of several the one with the least information criterion is reported
//! (Schwarz, *Ann. Statist.* 6, 1978); where the same motion, growing evenly from the first row to the last, takes more out of the
//! residuals, it is a drift and no step.

use std::cmp::Ordering;

use nalgebra::{DMatrix, DVector, Matrix3, SMatrix, Vector3};

use super::evidence::{Evidence, Limits};
use super::fitted::Fitted;
use super::outlying::outlying;
use super::overlap::apart;
use super::step::{Step, What, described};
use crate::description::campaign::Reading;
use crate::diagnostic::Diagnostic;
use crate::kinematics::{Geometry, Placements};
use crate::math::norm;
use crate::math::quantiles::f_tail;
use crate::math::{distinct, median};
use crate::noise::reference_noise;
use crate::prediction::residuals;

/// Least number of readings on either side: two or three wrong ones in a row are outliers and no step, and the three values of a
/// step are then found from 15 coordinates at least.
const LEAST: usize = 5;
/// Least diagonal of the Cholesky factor of a step's information given what is fitted, over its information alone: below, fitted
/// parameters make the step themselves to within 0.1 %, and its size would be that of the model's errors times a thousand.
const FREE: f64 = 1e-3;

/// Separation of the configurations before and after ([`apart`]) beyond which a step may be what the model misses in one region: half-way
/// between an order at random and regions that do not touch. It is reported then only where it leaves a ninth of the squares: a real arm
/// that starts with twenty readings of one posture leaves two fifths without a step there. A judgement.
const APART: f64 = 0.5;
const CLEAR_FALL: f64 = 3.0;

pub(super) fn stands_still(evidence: &Evidence, limits: &Limits) -> Vec<Diagnostic> {
    let Some(step) = stepped(evidence, limits, &[]) else { return Vec::new() };
    // A few readings that are simply wrong make a step of their own; after a knock all are.
    let wrong = outlying(evidence, limits).map_or_else(Vec::new, |(wrong, ..)| wrong);
    let place = |k: usize| evidence.campaign.rank(k);
    let is_of = |k: usize| !matches!(step.what, What::Marker(of) if evidence.campaign.readings[k].marker != Some(of));
    let later = || (0..evidence.campaign.readings.len()).filter(|&k| place(k) >= place(step.at) && is_of(k));
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
    if !found.converged() || campaign.holds_differences() {
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
    let one_of_several = moves.markers.iter().map(|&marker| What::Marker(marker));
    let bodies = [What::Instrument, What::Tool].into_iter().chain(one_of_several);
    let bodies = bodies.filter_map(|what| greatest::<3>(&fit, &moves, what));
    let zeros = (0..moves.variables).filter_map(|k| greatest::<1>(&fit, &moves, What::Zero(k)));
    let price = (fit.residual.len() as f64).ln();
    // A drift and a step have as many values.
    let merit = |step: &Step| {
        let left = (total - step.gain).max(f64::MIN_POSITIVE);
        fit.residual.len() as f64 * left.ln() + price * step.values
    };
    let step = bodies.chain(zeros).min_by(|a, b| merit(a).total_cmp(&merit(b)))?;
    // Fixed reflectors that moved by less say that instrument and base stood still.
    let moved = reference_noise(&campaign.references).and_then(|seen| seen.motion).map(|motion| motion.greatest);
    let on_base = !campaign.references.beside_base;
    if step.what == What::Instrument && on_base && moved.is_some_and(|moved| moved < limits.reference_step * step.by) {
        return None;
    }
    let freedom = fit.freedom() - step.values;
    // Of a robust fit the residuals are not orthogonal to what was fitted, and the gain of a step is none.
    if freedom < limits.noise_freedom || step.gain >= total {
        return None;
    }
    let left = (total - step.gain).max(f64::MIN_POSITIVE);
    let tried = ((3 + moves.variables) * fit.readings().len()) as f64;
    let chance = f_tail((step.gain / step.values) / (left / freedom), step.values, freedom) * tried;
    let noise = fit.noise((left / freedom).sqrt());
    // Of half of the readings 1.5 in squares: those near the middle of a step hardly fall.
    let is_of_few = step.fall_of_half < limits.sessions_fall.sqrt();
    if chance > limits.chance
        || step.fall < limits.sessions_fall
        || is_of_few
        || step.by < limits.sessions_apart * noise
    {
        return None;
    }
    if step.fall < CLEAR_FALL && is_of_a_region(&fit, &moves, &step) {
        return None;
    }
    Some(drift_or(step, &fit, &moves))
}

/// Whether configurations before the step are of another region than those after it.
fn is_of_a_region(fit: &Fitted, moves: &Moves, step: &Step) -> bool {
    let place = |index: usize| fit.evidence.campaign.rank(index);
    let own = (0..fit.readings().len()).filter(|&k| moves.concerns(step.what, k)).map(|k| fit.reading(k));
    apart(fit.evidence, &own.collect::<Vec<usize>>(), |index| place(index) >= place(step.at)) > APART
}

/// What turns and shifts move the fitted readings by.
struct Moves {
    variables: usize,
    /// Markers that were read, where there are several.
    markers: Vec<usize>,
    /// The marker of each fitted reading.
    of: Vec<Option<usize>>,
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
        let of: Vec<Option<usize>> = fit.readings().iter().map(|&index| campaign.readings[index].marker).collect();
        let mut markers = distinct(of.iter().flatten().copied());
        if markers.len() < 2 {
            markers.clear();
        }
        Some(Self { variables: model.variables.len(), markers, of, bodies, zeros: by_variables(fit, values)? })
    }

    /// Whether a reading, by its place among the fitted ones, moves with it.
    fn concerns(&self, what: What, k: usize) -> bool {
        !matches!(what, What::Marker(marker) if self.of.get(k) != Some(&Some(marker)))
    }

    /// Of a reading, by its place among the fitted ones.
    fn columns<const N: usize>(&self, what: What, k: usize) -> SMatrix<f64, 3, N> {
        let full = match what {
            What::Instrument => Matrix3::identity(),
            What::Tool | What::Marker(_) => self.bodies[k],
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
        residuals(model, &moved, values).ok()
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

/// Which of two readings, by their places among the fitted ones, was taken first.
fn in_order(fit: &Fitted, a: usize, b: usize) -> Ordering {
    let [one, other] = [a, b].map(|k| fit.evidence.campaign.rank(fit.reading(k)));
    one.total_cmp(&other)
}

/// The step that takes most out of the residuals.
fn greatest<const N: usize>(fit: &Fitted, moves: &Moves, what: What) -> Option<Step> {
    let mut order: Vec<usize> = (0..fit.readings().len()).filter(|&k| moves.concerns(what, k)).collect();
    let count = order.len();
    order.sort_by(|&a, &b| in_order(fit, a, b));
    let mut sums = Sums::<N>::new(fit);
    let mut best: Option<(Step, usize, DVector<f64>, DMatrix<f64>)> = None;
    let mut behind: Vec<(usize, SMatrix<f64, 3, N>)> = Vec::with_capacity(count);
    for (before, &k) in order.iter().enumerate().rev() {
        behind.push(sums.add(fit, moves, (what, k), 1.0));
        if before < LEAST || count - before < LEAST {
            continue;
        }
        let Some((by, gain)) = sums.solve() else { continue };
        if best.as_ref().is_none_or(|(best, ..)| gain > best.gain) {
            let step = Step {
                what,
                is_drift: false,
                at: fit.reading(k),
                by: 0.0,
                change: by.get(0).copied().unwrap_or(0.0),
                values: N as f64,
                gain,
                fall: 1.0,
                fall_of_half: 1.0,
            };
            best = Some((step, behind.len(), by, sums.on_basis.clone()));
        }
    }
    let (best, last, by, on_basis) = best?;
    let mut moved: Vec<f64> =
        order.iter().rev().take(last).map(|&k| (moves.columns::<N>(what, k) * &by).norm()).collect();
    let [fall, fall_of_half] = falls(fit, &order, &without(fit, &behind[..last], &on_basis, &by));
    Some(Step { by: median(&mut moved)?, fall, fall_of_half, ..best })
}

/// A step, or the drift of the same that takes more out of the residuals.
fn drift_or(step: Step, fit: &Fitted, moves: &Moves) -> Step {
    let drift = match step.what {
        What::Zero(_) => drifted::<1>(fit, moves, step.what),
        _ => drifted::<3>(fit, moves, step.what),
    };
    match drift.filter(|drift| drift.gain > step.gain) {
        Some(drift) => Step { at: step.at, ..drift },
        None => step,
    }
}

/// What grows evenly from the first row to the last.
fn drifted<const N: usize>(fit: &Fitted, moves: &Moves, what: What) -> Option<Step> {
    let mut order: Vec<usize> = (0..fit.readings().len()).filter(|&k| moves.concerns(what, k)).collect();
    order.sort_by(|&a, &b| in_order(fit, a, b));
    let last = order.len().checked_sub(1).filter(|last| *last > 0)? as f64;
    let mut sums = Sums::<N>::new(fit);
    let all: Vec<(usize, SMatrix<f64, 3, N>)> =
        (order.iter().enumerate()).map(|(place, &k)| sums.add(fit, moves, (what, k), place as f64 / last)).collect();
    let (by, gain) = sums.solve()?;
    let mut moved: Vec<f64> = order.iter().map(|&k| (moves.columns::<N>(what, k) * &by).norm()).collect();
    let [fall, fall_of_half] = falls(fit, &order, &without(fit, &all, &sums.on_basis, &by));
    let change = by.get(0).copied().unwrap_or(0.0);
    let at = fit.reading(*order.first()?);
    let by = median(&mut moved)?;
    Some(Step { what, is_drift: true, at, by, change, values: N as f64, gain, fall, fall_of_half })
}

/// Sums over readings of which columns of a motion, fitted with all that was fitted before, are solved.
struct Sums<const N: usize> {
    square: DMatrix<f64>,
    right: DVector<f64>,
    on_basis: DMatrix<f64>,
}

impl<const N: usize> Sums<N> {
    fn new(fit: &Fitted) -> Self {
        Self { square: DMatrix::zeros(N, N), right: DVector::zeros(N), on_basis: DMatrix::zeros(fit.basis.ncols(), N) }
    }

    /// Adds a reading, by its place among the fitted ones, which moves by a share of the motion: its first row, and its weighted columns.
    fn add(
        &mut self,
        fit: &Fitted,
        moves: &Moves,
        (what, k): (What, usize),
        share: f64,
    ) -> (usize, SMatrix<f64, 3, N>) {
        let first = fit.rows[k];
        let weights = Vector3::from_fn(|row, _| share / fit.sigma(first + row));
        let own: SMatrix<f64, 3, N> = Matrix3::from_diagonal(&weights) * moves.columns::<N>(what, k);
        self.square += own.transpose() * own;
        self.right += own.transpose() * fit.residual.fixed_rows::<3>(first);
        self.on_basis += fit.basis.rows(first, 3).transpose() * own;
        (first, own)
    }

    /// The motion and what it takes out of the weighted squares; `None` of one that the fitted parameters can make themselves.
    fn solve(&self) -> Option<(DVector<f64>, f64)> {
        let scale = self.square.trace();
        if scale <= 0.0 {
            return None;
        }
        let free = &self.square - self.on_basis.transpose() * &self.on_basis;
        let factor = (free / scale).cholesky().filter(|factor| factor.l().diagonal().min() > FREE)?;
        let by = factor.solve(&self.right) / scale;
        let gain = self.right.dot(&by);
        Some((by, gain))
    }
}

/// Residuals without a motion, and what fitted parameters then take up less.
fn without<const N: usize>(
    fit: &Fitted,
    moved: &[(usize, SMatrix<f64, 3, N>)],
    on_basis: &DMatrix<f64>,
    by: &DVector<f64>,
) -> DVector<f64> {
    let mut left = &fit.residual + &fit.basis * (on_basis * by);
    for (first, own) in moved {
        let mut rows = left.fixed_rows_mut::<3>(*first);
        rows -= own * by;
    }
    left
}

/// Axes of the body that a reading's marker is on, measurement frame.
fn axes_of_body(geometry: &Geometry, placements: &Placements, reading: &Reading) -> Matrix3<f64> {
    let model = geometry.model;
    let frame = reading.marker.map_or(model.tool.0, |marker| model.markers[marker].frame);
    let base = geometry.placement(model.base_slot(reading.session));
    (base * placements.frames[frame]).rotation.into_inner()
}

/// By which factor errors of readings fall to those of other residuals: their root mean square, and their median.
fn falls(fit: &Fitted, readings: &[usize], left: &DVector<f64>) -> [f64; 2] {
    let errors = |all: &DVector<f64>| -> Vec<f64> {
        readings.iter().map(|&k| all.fixed_rows::<3>(fit.rows[k]).norm()).collect()
    };
    let (mut before, mut after) = (errors(&fit.residual), errors(left));
    let of_all = norm(&before) / norm(&after).max(f64::MIN_POSITIVE);
    let of_half = median(&mut before).zip(median(&mut after));
    [of_all, of_half.map_or(1.0, |(with, without)| with / without.max(f64::MIN_POSITIVE))]
}
