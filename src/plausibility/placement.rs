//! A base or tool that is not where the description says, or a last joint that counts the other way with the markers near its axis,
//! found by calibration: a few millimetres are less than tolerances allow registration to leave, and yet many times what a calibration
//! with it leaves.

use rayon::prelude::*;

use super::again::{Fall, again, fitted};
use super::evidence::{Evidence, Limits};
use super::hypothesis::Hypothesis;
use super::readings::explained;
use super::trial::drawn;
use crate::description::campaign::{Campaign, NoiseOrigin};
use crate::diagnostic::Diagnostic;
use crate::estimation::{Calibration, far_off};

/// Where calibration leaves far more than the stated noise, the same with the last joint negated, else with base or tool estimated as well:
/// the first with which the error falls to what noise can be.
pub(super) fn as_placed(evidence: &Evidence, limits: &Limits) -> Vec<Diagnostic> {
    let (model, campaign) = (evidence.model, evidence.campaign);
    let [_, most] = limits.noise;
    if campaign.is_difference() {
        return Vec::new();
    }
    if campaign.sigma.is_none() || campaign.noise_origin != NoiseOrigin::Stated {
        return last_joint_reversed(evidence, limits).into_iter().collect();
    }
    let is_far = |found: &&Calibration| found.noise_ratio > most && found.degrees_of_freedom >= limits.noise_freedom;
    let Some(found) = evidence.found.filter(is_far) else {
        return Vec::new();
    };
    let decisive = |way: Hypothesis| {
        let mut moved = campaign.clone();
        way.apply(model, &mut moved, &mut model.registry.nominal());
        let again = again(model, &moved, found)?;
        // With an axis turned round a robot is another one of the same motions: constants that no arm has explain nothing.
        let falls = again.noise_ratio <= most
            && again.noise_ratio * limits.fall <= found.noise_ratio
            && far_off(model, &again).next().is_none();
        falls.then(|| (vec![way], again.after.fit.distance[1]))
    };
    let ways = Hypothesis::all(model, campaign);
    // Registration shows the sign of every other joint; that of the first, negated with the base upside down, looks like gravity.
    let last = model.variables.len();
    let is_sign = |way: &&Hypothesis| matches!(way, Hypothesis::Negated(joint) if joint + 1 == last && last > 1);
    let unknowns = ways.iter().filter(|way| way.adds_unknowns());
    let tried: Vec<Hypothesis> = ways.iter().filter(is_sign).chain(unknowns).copied().collect();
    let named = tried.into_par_iter().find_map_first(decisive);
    let Some(named) = named else { return Vec::new() };
    vec![explained(evidence, "calibration", Some(found.after.fit.distance[1]), &[named], &|_| None)]
}

/// Readings of a campaign on which calibrations are compared where the noise is not known, about: several times the parameters of any arm.
const COMPARED: usize = 600;

/// The same of the last joint alone where the noise is not stated, against what the calibration itself leaves.
fn last_joint_reversed(evidence: &Evidence, limits: &Limits) -> Option<Diagnostic> {
    let (model, found) = (evidence.model, evidence.found?);
    if !evidence.campaign.readings.iter().all(|reading| reading.observes.length_rows() > 0) {
        return None;
    }
    let last = model.variables.len();
    let way = *Hypothesis::all(model, evidence.campaign)
        .iter()
        .find(|way| matches!(way, Hypothesis::Negated(joint) if joint + 1 == last && last > 1))?;
    let is_few = evidence.campaign.readings.len() <= COMPARED;
    let is_drawn = drawn(evidence.campaign, &Limits { readings: COMPARED, ..*limits });
    let campaign = evidence.campaign.select(|_, reading| is_few || is_drawn.get(reading.pose) == Some(&true));
    let held_out = vec![false; campaign.readings.len()];
    let left = |campaign: &Campaign| fitted(model, campaign, &held_out, Some(found.slots.clone()));
    let mut reversed = campaign.clone();
    way.apply(model, &mut reversed, &mut model.registry.nominal());
    let both = [left(&campaign)?, left(&reversed)?];
    let fall = Fall::between(&both[0], &both[1]);
    let falls = fall.before > limits.finest && fall.is_by(limits.fall) && far_off(model, &both[1]).next().is_none();
    let after = both[1].after.fit.distance[1];
    falls.then(|| {
        explained(evidence, "calibration", Some(both[0].after.fit.distance[1]), &[(vec![way], after)], &|_| None)
    })
}
