//! Springs that all come out softer or stiffer by one factor: single joints age and are guessed, but not all alike. Then the declared
//! masses, the gravity or the stiffnesses are off by it.

use super::evidence::{Evidence, Limits};
use crate::description::campaign::Campaign;
use crate::diagnosis::Diagnosis;
use crate::diagnostic::{Code, Diagnostic};
use crate::math::quantiles::normal95;
use crate::model::Model;
use crate::parameter::{Group, Kind, Slot};

/// A spring that the readings tell.
struct Spring<'a> {
    name: &'a str,
    /// Logarithm of how many times softer it is than declared.
    softer: f64,
    /// Standard deviation of that.
    sigma: f64,
}

/// Of a calibration.
pub(super) fn of_calibration(evidence: &Evidence, limits: &Limits) -> Vec<Diagnostic> {
    let Some(found) = evidence.found.filter(|_| !evidence.campaign.is_difference()) else { return Vec::new() };
    let own = found.estimates.iter().filter(|estimate| !estimate.at_bound);
    let springs = own.filter_map(|estimate| spring(evidence.model, estimate.slot, estimate.value, estimate.ci95?));
    reported(springs.collect(), limits).into_iter().collect()
}

/// Of the causes that a diagnosis found, and of what it fitted with them.
pub(super) fn of_causes(model: &Model, campaign: &Campaign, found: &Diagnosis, limits: &Limits) -> Option<Diagnostic> {
    // Of deflections it is told before anything is fitted.
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
    let is_compliance = matches!(parameter.kind, Kind::LinearCompliance | Kind::RotationalCompliance);
    let is_reported =
        parameter.group == Group::Elastic && is_compliance && parameter.nominal > 0.0 && width < 0.5 * value;
    let sigma = width / normal95() / value;
    is_reported.then(|| Spring { name: &parameter.name, softer: (value / parameter.nominal).ln(), sigma })
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
        "all springs that the readings tell are {least:.0} to {most:.0} times {how} than declared ({}): are payload, masses or stiffnesses \
         off by a factor?",
        names.join(", ")
    );
    let remedy = "look at powers of ten of payload, masses and stiffnesses, and at `units:`; if the declared stiffnesses are guesses, go on \
                  with --force";
    Some(Diagnostic::warning(message).code(Code::WrongUnits).remedy(remedy).figure("factor", least))
}

fn reported(springs: Vec<Spring>, limits: &Limits) -> Option<Diagnostic> {
    let variance = |spring: &Spring| spring.sigma.powi(2) + limits.alike.powi(2);
    let weight: f64 = springs.iter().map(|spring| variance(spring).recip()).sum();
    let mean = springs.iter().map(|spring| spring.softer / variance(spring)).sum::<f64>() / weight;
    let is_alike = |spring: &Spring| (spring.softer - mean).abs() < 3.0 * variance(spring).sqrt();
    let is_far = mean.abs() > limits.deflection_factor.ln() && mean.abs() < limits.stiffness_factor.ln();
    if springs.len() < 2 {
        return None;
    }
    if !is_far || !springs.iter().all(is_alike) {
        return all_far(&springs, limits);
    }
    let factor = mean.abs().exp();
    let how = if mean > 0.0 { "softer" } else { "stiffer" };
    let names: Vec<&str> = springs.iter().map(|spring| spring.name).collect();
    let message = format!(
        "all springs that the readings tell are {factor:.1} times {how} than declared ({}): are the declared masses, or the stiffnesses, off \
         by that factor?",
        names.join(", ")
    );
    let remedy = "look at powers of ten of masses and stiffnesses, at `mass` and `rotational_stiffness` under `units:`, and at `gravity`; if \
                  the declared stiffnesses are guesses, go on with --force";
    Some(Diagnostic::warning(message).code(Code::WrongUnits).remedy(remedy).figure("factor", mean.exp()))
}
