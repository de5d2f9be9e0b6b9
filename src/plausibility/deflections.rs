//! Deflections against springs: a passive structure gives way to a load, never against it, and more than that, as its springs
//! and levers allow. Where mirrored readings, or reversed wrenches, are fitted decisively better, they are named.

use rayon::prelude::*;

use super::evidence::{Evidence, Limits};
use super::hypothesis::Hypothesis;
use super::readings::{AS_GOOD, SAID, Trial, explained};
use super::trial::{drawn, typical};
use crate::description::campaign::{Campaign, Reading};
use crate::diagnostic::{Code, Diagnostic};
use crate::estimation::{Settings, What, calibrate};
use crate::math::median;
use crate::model::Model;
use crate::prediction::{Linearised, Predictor};

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
        let (mut turned, mut values) = (some.clone(), model.registry.nominal());
        way.apply(model, &mut turned, &mut values);
        Some((vec![way], error(model, &turned, limits)?))
    };
    let mut named: Vec<Trial> = Hypothesis::all(model, &some).into_par_iter().filter_map(with).collect();
    named.retain(|(_, error)| error * limits.fall <= before);
    named.sort_by(|a, b| a.1.total_cmp(&b.1));
    let Some((_, best)) = named.first() else { return Vec::new() };
    let bound = AS_GOOD * best;
    named.retain(|(_, error)| *error <= bound);
    named.truncate(SAID);
    vec![explained(evidence, "the fitted springs", Some(before), &named).code(Code::Misread)]
}

/// Deflections against those of the springs as declared, before anything is fitted: all are in proportion too great or too small
/// where stiffness, loads or readings are in another unit, also where the fit then has nothing but bounds to end at.
pub(super) fn as_large_as_declared(evidence: &Evidence, limits: &Limits) -> Vec<Diagnostic> {
    let (model, campaign) = (evidence.model, evidence.campaign);
    if !campaign.is_difference() {
        return Vec::new();
    }
    let mut nominal = Linearised::default();
    let predicted = Predictor::new(model, campaign, Vec::new())
        .and_then(|by| by.linearise(&model.registry.nominal(), false, &mut nominal));
    if predicted.is_err() {
        return Vec::new();
    }
    let size = |values: &[f64]| values.iter().map(|v| v * v).sum::<f64>().sqrt();
    let ratio = |(reading, residual): (&Reading, &[f64])| {
        let lengths = reading.observes.length_rows();
        let measured = reading.measured.get(..lengths)?;
        let given: Vec<f64> = measured.iter().zip(residual).map(|(m, r)| m - r).collect();
        let noise = size(&reading.observes.sigmas(&reading.noise)[..lengths]);
        let [measured, given] = [size(measured), size(&given)];
        // What neither shows above the noise says nothing; what is rigid gives nothing to compare with.
        (given > 0.0 && measured.max(given) > limits.trimmed * noise).then(|| (measured / given).ln())
    };
    let mut ratios: Vec<f64> = campaign.by_reading(&nominal.residual, 1).filter_map(ratio).collect();
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
    let remedy = "state `stiffness`, `rotational_stiffness`, `force`, `torque` and `length` under `units:` as the files have them; \
                  if the declared stiffnesses are guesses, take no notice";
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
