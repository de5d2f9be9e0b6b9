//! A base or tool that is not where the description says, or a last joint that counts the other way with the markers near its axis,
//! found by calibration: a few millimetres are less than tolerances allow registration to leave, and yet many times what a calibration
//! with it leaves.

use super::evidence::{Evidence, Limits};
use super::hypothesis::Hypothesis;
use super::readings::explained;
use crate::diagnostic::{Code, Diagnostic};
use crate::estimation::{Calibration, Settings, calibrate, describes, far_off};
use crate::parameter::{Group, Slot};

/// Where calibration leaves far more than the stated noise, the same with the last joint negated, else with base or tool estimated as well:
/// the first with which the error falls to what noise can be.
pub(super) fn as_placed(evidence: &Evidence, limits: &Limits) -> Vec<Diagnostic> {
    let (model, campaign) = (evidence.model, evidence.campaign);
    let [_, most] = limits.noise;
    let is_far = |found: &&Calibration| found.noise_ratio > most && found.degrees_of_freedom >= limits.noise_freedom;
    if campaign.is_difference() || campaign.sigma.is_none() {
        return Vec::new();
    }
    let Some(found) = evidence.found.filter(is_far) else {
        return evidence.found.and_then(|found| nearer_placed(evidence, found)).into_iter().collect();
    };
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

/// Tolerances by which a constant moved from which it may stand for a base or tool that is not where the description says, and by which
/// the constants have to stay nearer together with one that is estimated: ten standard deviations of a described robot.
const FAR: f64 = 10.0;

/// Where constants moved far and as little is left with base or tool estimated as well, and constants that stay near: these stood for it.
fn nearer_placed(evidence: &Evidence, found: &Calibration) -> Option<Diagnostic> {
    let (model, campaign) = (evidence.model, evidence.campaign);
    // Of each constant of the geometry that was fitted, its change in tolerances.
    let moved = |of: &Calibration| -> Vec<(Slot, f64)> {
        let geometry = of.estimates.iter().filter(|own| model.registry[own.slot].group == Group::Geometry);
        geometry.map(|own| (own.slot, (own.value - own.nominal) / model.registry[own.slot].tolerance)).collect()
    };
    let squares = |of: &[(Slot, f64)]| of.iter().map(|(_, by)| by * by).sum::<f64>();
    let before = moved(found);
    let (slot, most) = before.iter().copied().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))?;
    if most.abs() < FAR || !found.converged() {
        return None;
    }
    let nearer = |way: &Hypothesis| {
        let mut own = campaign.clone();
        way.apply(model, &mut own, &mut model.registry.nominal());
        let settings = Settings { second_order: false, ..Settings::default() };
        calibrate(model, &own, &found.held_out, &settings, &mut |_| {}).is_ok_and(|again| {
            let is_as_good = describes(campaign, &again) || again.noise_ratio <= found.noise_ratio;
            again.converged() && is_as_good && squares(&before) - squares(&moved(&again)) > FAR * FAR
        })
    };
    let unknown = |way: Hypothesis| match way {
        Hypothesis::Unknown { base, tool } if nearer(&way) => Some((base, tool)),
        _ => None,
    };
    let what = match Hypothesis::all(model, campaign).into_iter().find_map(unknown)? {
        (true, false) => "the base",
        (false, _) => "the tool and the markers",
        (true, true) => "base, tool and markers",
    };
    let message = format!(
        "`{}` ends {:.0} tolerances from the description; with {what} estimated as well, residuals are as small and all constants stay nearer",
        model.registry[slot].name,
        most.abs()
    );
    let remedy = format!("look where the description has {what}, or estimate them (`estimate:` in the campaign)");
    Some(Diagnostic::warning(message).code(Code::MovedFar).remedy(remedy).figure("tolerances", most.abs()))
}
