//! Checks of the instrument, from readings in which no robot is.

use std::collections::BTreeSet;

use super::evidence::{Evidence, Limits};
use crate::description::campaign::{NoiseOrigin, Sharing};
use crate::diagnostic::{Code, Diagnostic};
use crate::math::quantiles::f_tail;
use crate::noise::{NoiseEstimate, Repeated, reference_noise, repeats, rigid_markers};

/// A scale that no instrument has: readings or lengths of the description are in another unit, or off by a factor.
pub(super) fn scale(evidence: &Evidence, limits: &Limits) -> Vec<Diagnostic> {
    let Some(found) = evidence.found else { return Vec::new() };
    let scales = evidence.campaign.readings.iter().filter_map(|own| evidence.model.scale_slot(own.session));
    let [doubted, refused] = limits.instrument_scale;
    let reported = |slot: usize| {
        let value = found.values.get(slot).copied().filter(|value| value.abs() > doubted)?;
        let name = &evidence.model.registry[slot].name;
        let message =
            format!("the instrument's `{name}` came out at {:+.3} %, more than instruments have", 100.0 * value);
        let remedy = "look at the units of readings and description and at the distances that give the scale; where the robot's lengths may be \
                      off together, hold the scale (`estimate: {scale: false}`)";
        let is_refused = value.abs() > refused;
        let diagnostic = if is_refused { Diagnostic::error(message) } else { Diagnostic::warning(message) };
        Some(diagnostic.code(Code::WrongUnits).remedy(remedy).figure("scale", value))
    };
    scales.collect::<BTreeSet<usize>>().into_iter().filter_map(reported).collect()
}

/// What fixed reflectors and rigid markers say against the campaign.
pub(super) fn instrument(evidence: &Evidence, limits: &Limits) -> Vec<Diagnostic> {
    let (model, campaign) = (evidence.model, evidence.campaign);
    let mut found = Vec::new();
    let references = reference_noise(&campaign.references);
    if let Some((noise, motion)) = references.and_then(|seen| Some((seen.noise, seen.motion?)))
        && motion.p < limits.chance
        && motion.rms > limits.reference_motion * noise.sigma
    {
        let [rms, greatest, drift, sigma] = [motion.rms, motion.greatest, motion.drift, noise.sigma].map(|m| 1e3 * m);
        let message = format!(
            "the fixed reflectors moved against the instrument: {rms:.4} mm rms, {greatest:.4} mm at most, {drift:.4} mm from first to last, where they scatter by {sigma:.4} mm"
        );
        let diagnostic = Diagnostic::warning(message).code(Code::ReferencesMoved);
        let diagnostic = diagnostic.figure("rms_mm", rms).figure("greatest_mm", greatest).figure("drift_mm", drift);
        found.push(diagnostic.remedy(match campaign.sessions.base {
            Sharing::PerSession => {
                "calibration cannot be better than that: cut the campaign where they moved, or let it warm up; where their rows are of \
                 sessions, say of which, in a column `session` or by the configurations in a column `pose`"
            }
            _ => {
                "calibration cannot be better than that: estimate base per session, cut the campaign where they moved, or let it warm up"
            }
        }));
    }
    let shown = [
        ("distances between rigid markers", rigid_markers(model, campaign)),
        ("readings repeated in place", repeats(campaign, Repeated::InPlace, |_, _| 1.0)),
        ("fixed reflectors", references.map(|seen| seen.noise)),
    ];
    let stated = campaign.sigma.filter(|_| campaign.noise_origin == NoiseOrigin::Stated);
    let stated = stated.map(|sigma| (sigma.iter().map(|s| s * s).sum::<f64>() / 3.0).sqrt());
    for (what, NoiseEstimate { sigma, degrees_of_freedom }) in
        shown.into_iter().filter_map(|(what, noise)| Some((what, noise?)))
    {
        let Some(stated) = stated.filter(|stated| *stated > 0.0 && sigma > 0.0) else { continue };
        let ratio = sigma / stated;
        // One side: that the stated noise is known exactly.
        let chance = f_tail(ratio.powi(2), degrees_of_freedom, 1e9);
        if ratio > limits.shown_noise && chance < limits.chance {
            let [sigma, stated] = [sigma, stated].map(|m| 1e3 * m);
            let message =
                format!("{what} scatter by {sigma:.4} mm a coordinate, where the campaign states {stated:.4} mm");
            let diagnostic = Diagnostic::warning(message).code(Code::NoiseDisagrees);
            let diagnostic = diagnostic.figure("shown_mm", sigma).figure("stated_mm", stated);
            found.push(
                diagnostic
                    .remedy("state the instrument's noise as it is, or look for readings that do not belong here"),
            );
        }
    }
    found
}
