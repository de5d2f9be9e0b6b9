//! Springs that all come out softer or stiffer by one factor: single joints age and are guessed, but not all alike. Then the declared
//! masses, the gravity or the stiffnesses are off by it; of deflections the wrenches may be.

use super::evidence::{Evidence, Limits};
use crate::description::campaign::Campaign;
use crate::diagnosis::Diagnosis;
use crate::diagnostic::{Code, Diagnostic};
use crate::math::quantiles::normal95;
use crate::model::Model;
use crate::parameter::{Group, Slot};

/// Standard deviations of a common factor from one, by the tolerances of all springs, from which it is no chance: of normal ones 6 in
/// 100000 are as far.
const CERTAIN: f64 = 4.0;

/// A spring that the readings tell.
struct Spring<'a> {
    name: &'a str,
    /// Logarithm of how many times softer it is than declared.
    softer: f64,
    /// Standard deviation of that.
    sigma: f64,
    /// Standard deviation by which it may be off as declared.
    tolerance: f64,
}

/// Of a calibration.
pub(super) fn of_calibration(evidence: &Evidence, limits: &Limits) -> Vec<Diagnostic> {
    let Some(found) = evidence.found else { return Vec::new() };
    let own = found.estimates.iter().filter(|estimate| !estimate.at_bound);
    let springs = own.filter_map(|estimate| spring(evidence.model, estimate.slot, estimate.value, estimate.ci95?));
    let springs: Vec<Spring> = springs.collect();
    let found = match evidence.campaign.holds_differences() {
        true => of_wrenches(&springs, limits),
        false => reported(springs, limits),
    };
    found.into_iter().collect()
}

/// Of springs fitted to deflections, by a common factor that the description's tolerances of them do not allow. Deflections that are
/// far off altogether are refused before anything is fitted ([`Limits::deflection_factor`]).
fn of_wrenches(springs: &[Spring], limits: &Limits) -> Option<Diagnostic> {
    let common = common(springs, |spring| spring.tolerance).filter(|_| springs.len() > 1)?;
    let is_one_side = springs.iter().all(|spring| spring.softer * common.mean > 0.0);
    let is_far = common.mean.abs() > limits.wrench_factor.ln() && common.mean.abs() < limits.stiffness_factor.ln();
    if !is_one_side || !is_far || common.mean.abs() < CERTAIN * common.sigma {
        return None;
    }
    let message = format!(
        "all identifiable springs are about {}, which their tolerances do not allow: are wrenches or deflections in another unit, \
         as lbf (4.45 N) and lbf.ft (1.36 N.m), or the declared stiffnesses off by that factor?",
        by(common.mean, springs)
    );
    let remedy = "give wrenches and deflections in the units that `units:` declares; if the declared stiffnesses are guesses, go on with --force";
    Some(Diagnostic::warning(message).code(Code::WrongUnits).remedy(remedy).figure("factor", common.mean.exp()))
}

/// Of the causes that a diagnosis found, and of what it fitted with them.
pub(super) fn of_causes(model: &Model, campaign: &Campaign, found: &Diagnosis, limits: &Limits) -> Option<Diagnostic> {
    // Of deflections it is reported before anything is fitted.
    if campaign.is_difference() {
        return None;
    }
    let of_entries = found.causes.iter().flat_map(|cause| {
        let amounts = cause.entries.iter().flat_map(|entry| &entry.amounts);
        amounts.filter_map(|(symbol, amount)| {
            let slot = model.registry.slot(symbol)?;
            let width = cause.parameters.iter().find(|parameter| parameter.name == *symbol)?.ci95?;
            spring(model, slot, model.registry[slot].nominal + amount, width)
        })
    });
    let fitted = found.calibration.iter().flat_map(|of| &of.estimates).filter(|estimate| !estimate.at_bound);
    let fitted = fitted.filter_map(|estimate| spring(model, estimate.slot, estimate.value, estimate.ci95?));
    let mut springs: Vec<Spring> = of_entries.collect();
    let others: Vec<Spring> = fitted.filter(|own| springs.iter().all(|known| known.name != own.name)).collect();
    springs.extend(others);
    reported(springs, limits)
}

/// A spring's compliance against the declared one, where it is known well enough for a factor.
fn spring(model: &Model, slot: Slot, value: f64, width: f64) -> Option<Spring<'_>> {
    let parameter = &model.registry[slot];
    let is_compliance = parameter.kind.is_compliance();
    let is_reported =
        parameter.group == Group::Elastic && is_compliance && parameter.nominal > 0.0 && width < 0.5 * value;
    let sigma = width / normal95() / value;
    let tolerance = parameter.tolerance / parameter.nominal;
    is_reported.then(|| Spring { name: &parameter.name, softer: (value / parameter.nominal).ln(), sigma, tolerance })
}

/// Where all are far off to one side, by whatever factors.
fn all_far(springs: &[Spring], limits: &Limits) -> Option<Diagnostic> {
    let far = limits.all_springs.ln();
    let is_softer = springs.iter().all(|spring| spring.softer > far);
    if !is_softer && !springs.iter().all(|spring| spring.softer < -far) {
        return None;
    }
    let factors = || springs.iter().map(|spring| spring.softer.abs());
    let [least, most] = [factors().fold(f64::INFINITY, f64::min), factors().fold(0.0, f64::max)].map(f64::exp);
    let how = if is_softer { "softer" } else { "stiffer" };
    let names: Vec<&str> = springs.iter().map(|spring| spring.name).collect();
    let message = format!(
        "all identifiable springs are {least:.0} to {most:.0} times {how} than declared ({}): are payload, masses or stiffnesses \
         off by a factor?",
        names.join(", ")
    );
    let remedy = "look at powers of ten of payload, masses and stiffnesses, and at `units:`; if the declared stiffnesses are guesses, go on \
                  with --force";
    Some(Diagnostic::warning(message).code(Code::WrongUnits).remedy(remedy).figure("factor", least))
}

fn reported(springs: Vec<Spring>, limits: &Limits) -> Option<Diagnostic> {
    if springs.len() < 2 {
        return None;
    }
    let is_far = |mean: &f64| mean.abs() > limits.deflection_factor.ln() && mean.abs() < limits.stiffness_factor.ln();
    let alike = common(&springs, |_| limits.alike).map(|common| common.mean);
    let Some(mean) = alike.filter(is_far) else { return all_far(&springs, limits) };
    let message = format!(
        "all identifiable springs are {}: are the declared masses, or the stiffnesses, off by that factor?",
        by(mean, &springs)
    );
    let remedy = "look at powers of ten of masses and stiffnesses, at `mass` and `rotational_stiffness` under `units:`, and at `gravity`; if \
                  the declared stiffnesses are guesses, go on with --force";
    Some(Diagnostic::warning(message).code(Code::WrongUnits).remedy(remedy).figure("factor", mean.exp()))
}

/// A factor that springs share.
struct Common {
    /// Its logarithm: how many times softer they are.
    mean: f64,
    /// Standard deviation of that.
    sigma: f64,
}

/// The factor by which all springs are softer, where each lies within three standard deviations of it, single ones differing by `spread`;
/// `None` where they are not by the same.
fn common(springs: &[Spring], spread: impl Fn(&Spring) -> f64) -> Option<Common> {
    let variance = |spring: &Spring| spring.sigma.powi(2) + spread(spring).powi(2);
    let weight: f64 = springs.iter().map(|spring| variance(spring).recip()).sum();
    let mean = springs.iter().map(|spring| spring.softer / variance(spring)).sum::<f64>() / weight;
    let is_alike = |spring: &Spring| (spring.softer - mean).abs() < 3.0 * variance(spring).sqrt();
    springs.iter().all(is_alike).then(|| Common { mean, sigma: weight.sqrt().recip() })
}

/// How much softer or stiffer, and which they are.
fn by(mean: f64, springs: &[Spring]) -> String {
    let how = if mean > 0.0 { "softer" } else { "stiffer" };
    let names: Vec<&str> = springs.iter().map(|spring| spring.name).collect();
    format!("{:.1} times {how} than declared ({})", mean.abs().exp(), names.join(", "))
}
