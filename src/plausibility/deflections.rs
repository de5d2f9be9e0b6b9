//! Deflections against springs: a passive structure gives way to a load, never against it, and more than that, as its springs
//! and levers allow. Where mirrored readings, or reversed wrenches, are fitted decisively better, they are named.

use nalgebra::DMatrix;
use rayon::prelude::*;

use super::evidence::{Evidence, Limits};
use super::fitted::Fitted;
use super::hypothesis::{Hypothesis, total_length};
use super::readings::{AS_GOOD, SAID, Trial, explained};
use super::shown::mm;
use super::trial::{drawn, noise, typical};
use crate::description::campaign::{Campaign, Reading};
use crate::diagnostic::{Code, Diagnostic};
use crate::estimation::{Calibration, Estimate, Settings, What, calibrate, row_sigmas};
use crate::math::norm;
use crate::math::{median, orthonormal, project_off, quantiles::f_tail};
use crate::model::Model;
use crate::parameter::Group;
use crate::prediction::{Predictor, residuals};

/// Most steps of a trial: springs are nearly linear in deflections.
const STEPS: usize = 12;

pub(super) fn follow_their_loads(evidence: &Evidence, limits: &Limits) -> Vec<Diagnostic> {
    let (model, campaign) = (evidence.model, evidence.campaign);
    if !campaign.is_difference() || model.elastic_slots().is_empty() {
        return Vec::new();
    }
    let chosen = drawn(campaign, limits);
    let some = campaign.select(|_, reading| chosen[reading.pose]);
    let Some(before) = error(model, &some, limits) else { return Vec::new() };
    let with = |way: Hypothesis| {
        let (mut turned, mut values) = (campaign.clone(), model.registry.nominal());
        way.apply(model, &mut turned, &mut values);
        let turned = turned.select(|_, reading| chosen[reading.pose]);
        Some((vec![way], error(model, &turned, limits)?))
    };
    let tried = |ways: Vec<Hypothesis>| ways.into_par_iter().filter_map(with).collect::<Vec<Trial>>();
    let worth = limits.fall * HALF;
    let may_suffice =
        |way: &Hypothesis| linear(evidence, &chosen, Some(*way), limits).is_some_and(|left| worth * left <= before);
    let mut named = tried(Hypothesis::all(model, &some).into_par_iter().filter(may_suffice).collect());
    // Forces and moments weighed otherwise against each other nearly silence one of them: nothing but noise is to be left.
    let is_held = campaign.sigma.is_some();
    let suffices = |way: &Hypothesis, error: f64| match way {
        Hypothesis::Moments(_) | Hypothesis::Forces(_) => !is_held || error <= limits.noise[1] * noise(&some),
        Hypothesis::Exchanged(..) | Hypothesis::Markers(..) | Hypothesis::AxisUnit(..) => {
            is_held && error <= limits.noise[1] * noise(&some)
        }
        _ => true,
    };
    named.retain(|(ways, error)| error * limits.fall <= before && ways.iter().all(|way| suffices(way, *error)));
    // Of the joints springs show less: with the right ones nothing but noise is left.
    let noise = limits.noise[1] * noise(&some);
    if named.is_empty() && campaign.sigma.is_some() && before > noise {
        named = tried(promising(evidence, &chosen, limits));
        named.retain(|(_, error)| error * limits.fall <= before && *error <= noise);
    }
    named.sort_by(|a, b| a.1.total_cmp(&b.1));
    let Some((_, best)) = named.first() else { return Vec::new() };
    let bound = AS_GOOD * best;
    named.retain(|(_, error)| *error <= bound);
    named.truncate(SAID);
    vec![explained(evidence, "the fitted springs", Some(before), &named, &|_| None)]
}

/// Deflections within their noise: of no fitted spring more is known than its size, and what is fitted is noise.
pub(super) fn show_the_springs(evidence: &Evidence, _: &Limits) -> Vec<Diagnostic> {
    let found = evidence.found.filter(|found| evidence.campaign.is_difference() && found.converged());
    let of_springs = |own: &&Estimate| evidence.model.registry[own.slot].group == Group::Elastic;
    let springs: Vec<&Estimate> = found.iter().flat_map(|found| found.estimates.iter().filter(of_springs)).collect();
    let kept: Vec<(&Estimate, f64)> = springs.into_iter().filter_map(|own| Some((own, own.ci95?))).collect();
    let is_unknown = |(own, half): &(&Estimate, f64)| *half >= own.value.abs().min(own.nominal.abs());
    if kept.is_empty() || !kept.iter().all(is_unknown) {
        return Vec::new();
    }
    let message =
        "no spring is known to better than its own size: the loads deflect the robot by less than the noise shows";
    let remedy = "load it more, or read more configurations and repeats; until then the declared springs are as good";
    vec![Diagnostic::warning(message).code(Code::TooLittleData).remedy(remedy).figure("springs", kept.len() as f64)]
}

/// Deflections that a calibration leaves all shifted alike: their unloaded readings were not of the unloaded robot.
pub(super) fn zeroed(evidence: &Evidence, limits: &Limits) -> Vec<Diagnostic> {
    let campaign = evidence.campaign;
    let converged = evidence.found.is_some_and(Calibration::converged);
    if !converged || !campaign.holds_differences() {
        return Vec::new();
    }
    shift(evidence, limits).into_iter().collect()
}

fn shift(evidence: &Evidence, limits: &Limits) -> Option<Diagnostic> {
    let fit = Fitted::of(evidence)?;
    let campaign = evidence.campaign;
    let is_shown = |k: usize| {
        let observes = campaign.readings[fit.reading(k)].observes;
        observes.is_difference() && observes.length_rows() == 3
    };
    let mut columns = DMatrix::zeros(fit.residual.len(), 3);
    for k in (0..fit.readings().len()).filter(|&k| is_shown(k)) {
        (0..3).for_each(|axis| columns[(fit.rows[k] + axis, axis)] = 1.0 / fit.sigma(fit.rows[k] + axis));
    }
    let free = project_off(&columns, &fit.basis);
    let normal = free.tr_mul(&free);
    let by = normal.clone().cholesky()?.solve(&free.tr_mul(&fit.residual));
    let gain = (normal * &by).dot(&by);
    let total = fit.residual.norm_squared();
    let (left, freedom) = ((total - gain).max(f64::MIN_POSITIVE), fit.freedom() - 3.0);
    if freedom < limits.noise_freedom || gain >= total {
        return None;
    }
    let chance = f_tail((gain / 3.0) / (left / freedom), 3.0, freedom);
    let fall = (total / left).sqrt();
    let noise = fit.noise((left / freedom).sqrt());
    if chance > limits.chance || fall < limits.sessions_fall || by.norm() < limits.sessions_apart * noise {
        return None;
    }
    let [x, y, z] = [0, 1, 2].map(|axis| mm(by[axis]));
    let message = format!(
        "all deflections are shifted alike by about {x}, {y}, {z} mm in x, y, z, and without that what is left of them falls to 1/{fall:.1}: were they zeroed under load?"
    );
    let remedy = "take the readings without load again, or take that shift off all deflections: springs that are fitted to it are wrong";
    let diagnostic = Diagnostic::warning(message).code(Code::Misread).remedy(remedy);
    Some(diagnostic.figure("shift_mm", 1e3 * by.norm()).figure("fall", fall))
}

/// Share of the error to which it falls at least, to first order, before a fit is worth its time; and by how much the first order
/// may be greater than what that fit leaves. Springs are nearly linear in deflections, and bounds of a fit only add to what it leaves.
const HALF: f64 = 0.5;

/// What springs, linear about their declared values, leave where the chosen readings are read in another way.
fn linear(evidence: &Evidence, chosen: &[bool], way: Option<Hypothesis>, limits: &Limits) -> Option<f64> {
    let (model, campaign) = (evidence.model, evidence.campaign);
    let (mut read, mut values) = (campaign.clone(), model.registry.nominal());
    way.into_iter().for_each(|way| way.apply(model, &mut read, &mut values));
    linear_error(model, &read.select(|_, reading| chosen[reading.pose]), &values, limits)
}

/// Other ways to read the joints with which springs, linear about their declared values, leave least: only these are fitted.
fn promising(evidence: &Evidence, chosen: &[bool], limits: &Limits) -> Vec<Hypothesis> {
    let left = |way| linear(evidence, chosen, way, limits);
    let Some(before) = left(None) else { return Vec::new() };
    let better = |way: Hypothesis| Some((way, left(Some(way)).filter(|error| HALF * before >= *error)?));
    let mut all: Vec<(Hypothesis, f64)> =
        Hypothesis::of_joints(evidence.model, evidence.campaign).into_par_iter().filter_map(better).collect();
    all.sort_by(|a, b| a.1.total_cmp(&b.1));
    all.into_iter().take(SAID).map(|(way, _)| way).collect()
}

/// What springs leave of the deflections to first order (m, [`typical`]).
fn linear_error(model: &Model, campaign: &Campaign, values: &[f64], limits: &Limits) -> Option<f64> {
    let all = Predictor::new(model, campaign, model.elastic_slots()).ok()?.linearised(values).ok()?;
    let sigmas = row_sigmas(campaign);
    let (columns, residual) = all.whitened(&sigmas);
    if !residual.iter().chain(columns.iter()).all(|value| value.is_finite()) {
        return None;
    }
    let basis = orthonormal(&columns, None);
    let left: Vec<f64> = project_off(&residual, &basis).iter().zip(&sigmas).map(|(left, sigma)| left * sigma).collect();
    typical(campaign, &left, limits)
}

/// Share of the sum of the robot's lengths beyond which deflections are taken for positions: arms that machine or assemble deflect by
/// thousandths of it. A judgement.
const PLACES: f64 = 0.05;

/// Deflections against those of the springs as declared, before anything is fitted: all are in proportion too great or too small
/// where stiffness, loads or readings are in another unit, also where the fit then has nothing but bounds to end at.
pub(super) fn as_large_as_declared(evidence: &Evidence, limits: &Limits) -> Vec<Diagnostic> {
    let (model, campaign) = (evidence.model, evidence.campaign);
    if !campaign.is_difference() {
        return Vec::new();
    }
    let Ok(nominal) = residuals(model, campaign, &model.registry.nominal()) else { return Vec::new() };
    let ratio = |(reading, residual): (&Reading, &[f64])| {
        let lengths = reading.observes.length_rows();
        let measured = reading.measured.get(..lengths)?;
        let given: Vec<f64> = measured.iter().zip(residual).map(|(m, r)| m - r).collect();
        let stated = norm(&reading.observes.sigmas(&reading.noise)[..lengths]);
        let noise = if reading.noise.is_stated[0] { stated } else { 0.0 };
        let [measured, given] = [norm(measured), norm(&given)];
        // What neither shows above the noise says nothing; what is rigid gives nothing to compare with.
        (given > 0.0 && measured.max(given) > limits.trimmed * noise).then(|| (measured / given).ln())
    };
    let mut ratios: Vec<f64> = campaign.by_reading(&nominal, 1).filter_map(ratio).collect();
    let count = ratios.len();
    let Some(middle) = median(&mut ratios).filter(|_| count >= limits.least_configurations) else { return Vec::new() };
    if middle.abs() < limits.deflection_factor.ln() || !middle.is_finite() {
        return Vec::new();
    }
    let how = if middle > 0.0 { "greater" } else { "smaller" };
    let message = format!(
        "deflections are {:.3} times {how} than the declared springs allow for (median of {count}): are stiffness, loads or readings in another unit?",
        middle.abs().exp()
    );
    let is_hopeless = middle.abs() > limits.stiffness_factor.ln();
    let diagnostic = if is_hopeless { Diagnostic::error(message) } else { Diagnostic::warning(message) };
    let lengths = |reading: &Reading| norm(reading.measured.get(..reading.observes.length_rows()).unwrap_or_default());
    let sizes = campaign.readings.iter().map(lengths).filter(|size| *size > 0.0).collect::<Vec<_>>();
    let are_places = median(&mut { sizes }).is_some_and(|size| size > PLACES * total_length(model));
    let remedy = match are_places {
        true => "are these positions (`observes: position`)? Loads deflect an arm by thousandths of its length",
        false => {
            "state `stiffness`, `rotational_stiffness`, `force`, `torque` and `length` under `units:` as the files have them; \
             if the declared stiffnesses are guesses, take no notice"
        }
    };
    vec![diagnostic.code(Code::WrongUnits).remedy(remedy).figure("factor", middle.exp())]
}

/// What fitted springs leave of the deflections (m, [`typical`]).
fn error(model: &Model, campaign: &Campaign, limits: &Limits) -> Option<f64> {
    let settings = Settings {
        what: Some(What { geometric: false, elastic: true }),
        second_order: false,
        max_iterations: Some(STEPS),
        ..Settings::default()
    };
    let none = vec![false; campaign.readings.len()];
    let found = calibrate(model, campaign, &none, &settings, &mut |_| {}).ok()?;
    typical(campaign, &found.residual, limits).filter(|error| error.is_finite())
}
