//! Constants that end far from the description, although the files, read in another way, leave as little with constants that stay near it.
//!
//! Over a small region a column in another unit, a scale or a base that is not where it was is nearly a change of a few constants: they take
//! it up, and no residual shows it. The same calibration is made with the files read in each other way, and with base or tool
//! estimated as well; as little left with constants many standard deviations nearer is named.

use rayon::prelude::*;

use super::again::fitted;
use super::evidence::{Evidence, Limits};
use super::hypothesis::Hypothesis;
use super::trial::Trials;
use super::words::words_of;
use crate::diagnostic::{Code, Diagnostic};
use crate::estimation::{Calibration, Estimate, describes};
use crate::parameter::{Group, Slot};

/// Tolerances by which a constant moved from which it may stand for something else, and by which the constants have to stay nearer
/// together with the files read otherwise: ten standard deviations of a described robot.
const FAR: f64 = 10.0;
/// Ways that are calibrated with, those with which registration leaves least: a calibration each. A judgement.
const TRIED: usize = 12;

/// What constants stand for that ended far from the description.
pub(super) fn as_described(evidence: &Evidence, limits: &Limits) -> Vec<Diagnostic> {
    let (model, campaign) = (evidence.model, evidence.campaign);
    if campaign.is_difference() || campaign.sigma.is_none() {
        return Vec::new();
    }
    let Some(found) = evidence.found.filter(|found| found.converged()) else { return Vec::new() };
    let before = moved(evidence, found);
    let most = before.iter().copied().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()));
    let Some((slot, most)) = most.filter(|(_, most)| most.abs() >= FAR) else { return Vec::new() };
    // What a fit finds from another start by itself is not explained by a way.
    let by_itself = fitted(model, campaign, &found.held_out, Some(found.slots.clone()));
    let by_itself = by_itself.map_or(f64::INFINITY, |again| squares(&moved(evidence, &again)));
    let before_all = squares(&before).min(by_itself);
    let nearer = |way: &Hypothesis| {
        let mut own = campaign.clone();
        way.apply(model, &mut own, &mut model.registry.nominal());
        let only = (!way.adds_unknowns()).then(|| found.slots.clone());
        let again = fitted(model, &own, &found.held_out, only)?;
        let after = moved(evidence, &again);
        let is_as_good = describes(campaign, &again) || again.noise_ratio <= found.noise_ratio;
        let are_near = way.adds_unknowns() || after.iter().all(|(_, by)| by.abs() < FAR);
        let left = squares(&after);
        (is_as_good && are_near && before_all - left > FAR * FAR).then_some((*way, left))
    };
    let ways = ways(evidence, limits);
    let all: Vec<(Hypothesis, f64)> = ways.par_iter().filter_map(nearer).collect();
    let found = all.into_iter().min_by(|a, b| a.1.total_cmp(&b.1));
    found.map(|(way, _)| described(evidence, slot, most, &way)).into_iter().collect()
}

/// Of each constant of the geometry that was fitted, its change in tolerances as far as that is beyond its 95 % interval: what readings do
/// not determine is anywhere.
fn moved(evidence: &Evidence, of: &Calibration) -> Vec<(Slot, f64)> {
    let registry = &evidence.model.registry;
    let geometry = of.estimates.iter().filter(|own| registry[own.slot].group == Group::Geometry);
    let certain = |own: &Estimate| {
        let by = own.value - own.nominal;
        by.signum() * (by.abs() - own.ci95.unwrap_or(f64::INFINITY)).max(0.0)
    };
    geometry.map(|own| (own.slot, certain(own) / registry[own.slot].tolerance)).collect()
}

fn squares(of: &[(Slot, f64)]) -> f64 {
    of.iter().map(|(_, by)| by * by).sum()
}

/// Registration may leave so many times what it does without a way that is calibrated with: the constants' own errors, which registration
/// leaves in both, may add to those of the mistake or lessen them. A judgement, which decides only what is calibrated with.
const AS_MUCH: f64 = 1.5;

/// Base and tool estimated as well, and the ways to read the campaign with which registration leaves hardly more than without.
fn ways(evidence: &Evidence, limits: &Limits) -> Vec<Hypothesis> {
    let (model, campaign) = (evidence.model, evidence.campaign);
    let trials = Trials::new(model, campaign, limits);
    let (mut ways, others): (Vec<_>, Vec<_>) =
        Hypothesis::all(model, campaign).into_iter().partition(Hypothesis::adds_unknowns);
    let others = others.into_iter().filter(|way| !way.is_of_description());
    let Some(before) = trials.error(&[]) else { return ways };
    let left =
        |way: Hypothesis| trials.error(&[way]).filter(|error| *error <= AS_MUCH * before).map(|error| (way, error));
    let mut nearer: Vec<(Hypothesis, f64)> = others.filter_map(left).collect();
    nearer.sort_by(|a, b| a.1.total_cmp(&b.1));
    ways.extend(nearer.into_iter().take(TRIED).map(|(way, _)| way));
    ways
}

/// What `way` makes of the constant that moved by most tolerances.
fn described(evidence: &Evidence, slot: Slot, most: f64, way: &Hypothesis) -> Diagnostic {
    let words = words_of(way, evidence.model, evidence.campaign);
    let placed = match way {
        Hypothesis::Unknown { base: true, tool: false } => Some("the base"),
        Hypothesis::Unknown { base: false, .. } => Some("the tool and the markers"),
        Hypothesis::Unknown { .. } => Some("base, tool and markers"),
        _ => None,
    };
    let name = &evidence.model.registry[slot].name;
    let with = placed.map_or_else(|| words.with.clone(), |what| format!("{what} estimated as well"));
    let question = placed.map_or_else(|| format!(": {}", words.question), |_| String::new());
    let message = format!(
        "`{name}` ends {:.0} tolerances from the description; with {with}, residuals are as small and all constants stay nearer{question}",
        most.abs()
    );
    let remedy = placed.map_or(words.remedy, |what| {
        format!("look where the description has {what}, or estimate them (`estimate:` in the campaign)")
    });
    let code = match placed {
        None if words.is_unit => Code::WrongUnits,
        None => Code::Misread,
        Some(_) => Code::MovedFar,
    };
    Diagnostic::warning(message).code(code).remedy(remedy).figure("tolerances", most.abs())
}
