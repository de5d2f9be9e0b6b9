//! Deflections against springs: a passive structure gives way to a load, never against it, and more than that, as its springs
//! and levers allow. Where mirrored readings, or reversed wrenches, are fitted decisively better, they are named.

use rayon::prelude::*;

use super::evidence::{Evidence, Limits};
use super::hypothesis::Hypothesis;
use super::readings::{AS_GOOD, SAID, Trial, explained};
use super::trial::{drawn, typical};
use crate::description::campaign::Campaign;
use crate::diagnostic::{Code, Diagnostic};
use crate::estimation::{Settings, What, calibrate};
use crate::model::Model;

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
