//! Deflections that no spring explains, and places and deflections that contradict each other.

use super::again::fitted;
use super::deflections::show_the_springs;
use super::evidence::{Evidence, Limits};
use super::shown::mm;
use crate::description::campaign::{Campaign, Reading};
use crate::diagnostic::{Code, Diagnostic};
use crate::estimation::Calibration;
use crate::math::norm;
use crate::parameter::{Group, Slot};

/// Share of their own size that fitted springs leave of deflections, from which they explain little. A judgement.
const LITTLE: f64 = 0.5;
/// What springs may leave, in standard deviations of the noise, whatever the size.
const NOISE: f64 = 3.0;
/// Root mean square of something of the fitted readings that are, or are not, differences, m.
fn rms(
    campaign: &Campaign,
    found: &Calibration,
    differences: bool,
    of: impl Fn(&Reading, &[f64]) -> f64,
) -> Option<f64> {
    let is_own = |index: usize, reading: &Reading| {
        reading.observes.is_difference() == differences && reading.observes.length_rows() > 0 && !found.holds_out(index)
    };
    let own =
        campaign.by_reading(&found.residual, 1).enumerate().filter(|(index, (reading, _))| is_own(*index, reading));
    let squares: Vec<f64> = own.map(|(_, (reading, rows))| of(reading, rows).powi(2)).collect();
    (!squares.is_empty()).then(|| (squares.iter().sum::<f64>() / squares.len() as f64).sqrt())
}

fn left(reading: &Reading, rows: &[f64]) -> f64 {
    norm(&rows[..reading.observes.length_rows().min(rows.len())])
}

/// Deflections of which fitted springs leave most: they are not of these loads, or in other axes.
pub(super) fn are_explained(evidence: &Evidence, limits: &Limits) -> Vec<Diagnostic> {
    let (model, campaign) = (evidence.model, evidence.campaign);
    let Some(found) = evidence.found.filter(|found| found.converged()) else { return Vec::new() };
    let is_spring = |slot: &Slot| model.registry[*slot].group == Group::Elastic;
    if !found.slots.iter().any(is_spring) || !show_the_springs(evidence, limits).is_empty() {
        return Vec::new();
    }
    let size = |reading: &Reading, _: &[f64]| norm(&reading.measured[..reading.observes.length_rows()]);
    let noise = |reading: &Reading, _: &[f64]| match reading.noise.is_stated[0] {
        true => norm(&reading.observes.sigmas(&reading.noise)[..reading.observes.length_rows()]),
        false => 0.0,
    };
    let [size, noise] = [rms(campaign, found, true, size), rms(campaign, found, true, noise)];
    let (Some(left), Some(size), Some(noise)) = (rms(campaign, found, true, left), size, noise) else {
        return Vec::new();
    };
    if left <= LITTLE * size || left <= NOISE * noise {
        return Vec::new();
    }
    let message =
        format!("fitted springs leave {} mm of deflections of {} mm: these loads do not make them", mm(left), mm(size));
    let remedy = "look at the axes of the wrenches (those of the robot's base), their signs, units and points, and at what was zeroed";
    let diagnostic = Diagnostic::warning(message).code(Code::UnlikeDescription).remedy(remedy);
    vec![diagnostic.figure("left_mm", 1e3 * left).figure("size_mm", 1e3 * size)]
}

/// Places and deflections that one set of springs describes much worse together than each alone: the loads are not those that are written, or
/// the masses under which the arm sags.
pub(super) fn agree(evidence: &Evidence, limits: &Limits) -> Vec<Diagnostic> {
    contradiction(evidence, limits).into_iter().collect()
}

fn contradiction(evidence: &Evidence, limits: &Limits) -> Option<Diagnostic> {
    let (model, campaign) = (evidence.model, evidence.campaign);
    let found = evidence.calibrated().filter(|found| found.converged())?;
    let mut halves = campaign.by_difference()?;
    let is_spring = |slot: &Slot| model.registry[*slot].group == Group::Elastic;
    let kept = found.kept_slots();
    let springs: Vec<Slot> = kept.iter().copied().filter(is_spring).collect();
    if springs.is_empty() {
        return None;
    }
    // Springs alone, where the arm, its base and its tool were found to be.
    let of_springs = &mut halves[1];
    (of_springs.estimate_base, of_springs.estimate_tool, of_springs.estimate_scale) = (false, false, false);
    let mut placed = model.clone();
    for (slot, parameter) in placed.registry.all_mut().iter_mut().enumerate() {
        if parameter.group != Group::Elastic {
            parameter.nominal = *found.values.get(slot)?;
        }
    }
    let of_half = |differences: bool| {
        let own = |index: usize| campaign.readings[index].observes.is_difference() == differences;
        let held_out = (0..campaign.readings.len()).filter(|&index| own(index)).map(|index| found.holds_out(index));
        let held_out: Vec<bool> = held_out.collect();
        let (model, slots) = if differences { (&placed, springs.clone()) } else { (model, kept.clone()) };
        let half = &halves[usize::from(differences)];
        let alone = fitted(model, half, &held_out, Some(slots))?;
        let of_fitted = half.readings.iter().zip(&held_out).filter(|(_, held_out)| !**held_out);
        let rows: usize = of_fitted.map(|(reading, _)| reading.observes.rows()).sum();
        let alone_left =
            rms(half, &alone, differences, left)? * (rows as f64 / alone.degrees_of_freedom.max(1.0)).sqrt();
        let sigma = rms(half, &alone, differences, |reading, _| reading.noise.position[0])?;
        Some(([rms(campaign, found, differences, left)?, alone_left], rows as f64 / sigma.powi(2)))
    };
    let [(places, of_places), (deflections, of_deflections)] = [of_half(false)?, of_half(true)?];
    // What no parameter describes is left of each alone as well, and pulls at the springs of both: judged by all that is left.
    let all = |k: usize| (of_places * places[k].powi(2) + of_deflections * deflections[k].powi(2)).sqrt();
    if all(0) <= limits.sessions_fall * all(1) {
        return None;
    }
    let [a, b, c, d] = [places[0], deflections[0], places[1], deflections[1]].map(mm);
    let message = format!(
        "places and deflections contradict each other: together {a} and {b} mm are left of them, each alone {c} and {d} mm, since the springs under \
         which the arm sags are not those that the deflections show"
    );
    let remedy = "look at unit, axes and zero of the loads, at masses, and at payload and tool in each file; until then fit them apart";
    let diagnostic = Diagnostic::warning(message).code(Code::UnlikeDescription).remedy(remedy);
    Some(diagnostic.figure("places_mm", 1e3 * places[0]).figure("deflections_mm", 1e3 * deflections[0]))
}
