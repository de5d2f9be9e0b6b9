//! A base or tool that is not where the description says, or a last joint that counts the other way with the markers near its axis,
//! found by calibration: a few millimetres are less than tolerances allow registration to leave, and yet many times what a calibration
//! with it leaves.

use super::evidence::{Evidence, Limits};
use super::hypothesis::Hypothesis;
use super::readings::explained;
use crate::diagnostic::Diagnostic;
use crate::estimation::{Calibration, Settings, calibrate, far_off};

/// Where calibration leaves far more than the stated noise, the same with the last joint negated, else with base or tool estimated as well:
/// the first with which the error falls to what noise can be.
pub(super) fn as_placed(evidence: &Evidence, limits: &Limits) -> Vec<Diagnostic> {
    let (model, campaign) = (evidence.model, evidence.campaign);
    let [_, most] = limits.noise;
    let is_far = |found: &&Calibration| found.noise_ratio > most && found.degrees_of_freedom >= limits.noise_freedom;
    let Some(found) = evidence.found.filter(is_far) else { return Vec::new() };
    if campaign.is_difference() || campaign.sigma.is_none() {
        return Vec::new();
    }
    let decisive = |way: Hypothesis| {
        let mut moved = campaign.clone();
        way.apply(model, &mut moved, &mut model.registry.nominal());
        let settings = Settings { only: Some(found.slots.clone()), second_order: false, ..Settings::default() };
        let again = calibrate(model, &moved, &found.held_out, &settings, &mut |_| {}).ok()?;
        // With an axis turned round a robot is another one of the same motions: constants that no arm has explain nothing.
        let falls = again.converged()
            && again.noise_ratio <= most
            && again.noise_ratio * limits.fall <= found.noise_ratio
            && far_off(model, &again).next().is_none();
        falls.then(|| (vec![way], again.after.fit.distance[1]))
    };
    let ways = Hypothesis::all(model, campaign);
    // Registration shows the sign of every other joint; that of the first, negated with the base upside down, looks like gravity.
    let last = model.variables.len();
    let is_sign = |way: &&Hypothesis| matches!(way, Hypothesis::Negated(joint) if joint + 1 == last && last > 1);
    let unknowns = ways.iter().filter(|way| way.adds_unknowns());
    let named = ways.iter().filter(is_sign).chain(unknowns).copied().find_map(decisive);
    named
        .map(|named| explained(evidence, "calibration", Some(found.after.fit.distance[1]), &[named], &|_| None))
        .into_iter()
        .collect()
}
