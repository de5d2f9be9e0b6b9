//! Springs that the description declares and the calibration leaves as they are: geometry then takes up what load moves.

use super::again::Fall;
use super::evidence::{Evidence, Limits};
use super::trial::noise;
use crate::diagnostic::{Code, Diagnostic};
use crate::estimation::{Settings, What, calibrate};

/// Errors over the noise from which springs are tried. A judgement: below, nothing of them is missed.
const OPEN: f64 = 2.0;

/// The same calibration with the springs that are declared identifiable, where it leaves nothing but the noise, and much less.
pub(super) fn are_as_declared(evidence: &Evidence, limits: &Limits) -> Vec<Diagnostic> {
    let (model, campaign) = (evidence.model, evidence.campaign);
    let elastic = model.elastic_slots();
    let is_without = |slots: &[usize]| !slots.iter().any(|slot| elastic.contains(slot));
    let Some(found) = evidence.found.filter(|found| found.converged() && is_without(&found.slots)) else {
        return Vec::new();
    };
    let is_loaded = model.structure.masses.iter().any(|body| model.registry[body.slot].nominal > 0.0)
        || campaign.readings.iter().any(|reading| reading.is_loaded() || reading.payload.is_some());
    let here = found.after.fit.distance[1];
    let is_open = !elastic.is_empty() && is_loaded && !campaign.is_difference() && here > OPEN * noise(campaign);
    // Where base and tool alone are fitted, the robot's own errors are what is left.
    if !is_open || found.slots.iter().all(|slot| !model.free_slots().contains(slot)) {
        return Vec::new();
    }
    let what = Some(What { geometric: true, elastic: true });
    let settings = Settings { what, second_order: false, ..Settings::default() };
    let Ok(again) = calibrate(model, campaign, &found.held_out, &settings, &mut |_| {}) else { return Vec::new() };
    let fall = Fall::between(found, &again);
    // A part of an error that springs take up may be another cause's.
    if !again.converged() || again.noise_ratio > limits.joints_fall || !fall.is_by(limits.joints_fall) {
        return Vec::new();
    }
    let with = fall.words("the springs of the description fitted as well");
    let message = format!("{with}: load moves these readings, and constants of the geometry take that up");
    let remedy = "write `calibrate: [geometry, joint-offset, joint-compliance]` into the campaign; for `identify` alone `--what geometric,elastic`";
    let diagnostic = Diagnostic::warning(message).code(Code::SpringsHeld).remedy(remedy);
    vec![fall.put(diagnostic)]
}
