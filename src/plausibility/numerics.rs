//! Checks of the computation itself.

use super::evidence::{Evidence, Limits};
use crate::diagnostic::Diagnostic;
use crate::estimation::SharedError;
use crate::identifiability::Why;
use crate::least_squares::{Loss, Status};
use crate::parameter::{Group, Kind};

pub(super) fn converged(evidence: &Evidence, _: &Limits) -> Vec<Diagnostic> {
    let Some(found) = evidence.found else { return Vec::new() };
    let why = match &found.ending {
        ending if ending.converged() => return Vec::new(),
        Status::IterationLimit => "the limit of iterations was reached",
        Status::Stalled => "steps shrank to nothing although the model promises progress",
        _ => "it ended without a minimum",
    };
    let error = Diagnostic::error(format!("the fit did not converge: {why}, after {} iterations", found.iterations));
    let wrong = match found.loss {
        Loss::Squares => "look for outliers (--loss huber)",
        _ => "delete outliers, or use another --loss",
    };
    let remedy = format!(
        "hold what the readings hardly show (--hold), let tolerances pull (--prior), {wrong}, use --scheme batch, or measure more \
         configurations"
    );
    vec![error.figure("iterations", found.iterations as f64).remedy(remedy)]
}

pub(super) fn finite(evidence: &Evidence, _: &Limits) -> Vec<Diagnostic> {
    let Some(found) = evidence.found else { return Vec::new() };
    let registry = &evidence.model.registry;
    let lost = found
        .values
        .iter()
        .zip(registry.all())
        .find(|(value, parameter)| !value.is_finite() && (parameter.nominal.is_finite() || value.is_nan()));
    let what = match lost {
        Some((value, parameter)) => format!("`{}` is {value}", parameter.name),
        None if found.residual.iter().any(|r| !r.is_finite()) => "errors of readings are not finite".into(),
        None => return Vec::new(),
    };
    vec![Diagnostic::error(format!("the calibration came to nothing: {what}")).remedy("check readings and description")]
}

pub(super) fn within_reach(evidence: &Evidence, limits: &Limits) -> Vec<Diagnostic> {
    let registry = &evidence.model.registry;
    let is_far = |slot: usize, value: f64| {
        let parameter = &registry[slot];
        let is_place = matches!(parameter.group, Group::Base | Group::Tool | Group::Arrangement);
        let placed = is_place && parameter.kind == Kind::Length;
        placed && value.abs() > limits.farthest.max(10.0 * parameter.nominal.abs())
    };
    let Some(found) = evidence.found else { return Vec::new() };
    let far = found.estimates.iter().find(|estimate| is_far(estimate.slot, estimate.value));
    let diagnostic = far.map(|estimate| {
        let (name, metres) = (&registry[estimate.slot].name, estimate.value);
        Diagnostic::error(format!("`{name}` came out at {metres:.0} m, where no instrument reaches"))
            .figure("value_m", metres)
            .remedy(match registry[estimate.slot].group {
                Group::Arrangement => {
                    "touch or read it from more sides, give its `radius`, or say where it is (`at`): what is read of it is as of a plane"
                }
                _ => "check units and anchors, or state where base and tool are (`estimate: {base: false, tool: false}`)",
            })
    });
    diagnostic.into_iter().collect()
}

pub(super) fn weak_directions(evidence: &Evidence, _: &Limits) -> Vec<Diagnostic> {
    let Some(found) = evidence.found else { return Vec::new() };
    let weak = found.identifiability.dropped.iter().filter_map(|(column, why)| {
        let parameter = &evidence.model.registry[*found.slots.get(*column)?];
        (*why == Why::Weak && matches!(parameter.group, Group::Base | Group::Tool)).then_some(parameter.name.as_str())
    });
    let names: Vec<&str> = weak.collect();
    if names.is_empty() {
        return Vec::new();
    }
    let message =
        format!("the readings hardly show {}: held as described, merged into what is fitted", names.join(", "));
    let remedy = "measure configurations that differ more, or state where base or tool is";
    vec![Diagnostic::warning(message).figure("held", names.len() as f64).remedy(remedy)]
}

/// Shared over own errors from which readings are copies of each other: an instrument resolves a millionth of what it reads at best.
const COPIED: f64 = 1e6;

pub(super) fn dependent(evidence: &Evidence, limits: &Limits) -> Vec<Diagnostic> {
    let is_reported = |error: &SharedError| error.p < limits.chance && error.shared > limits.shared_least;
    let Some(error) = evidence.found.and_then(|found| found.shared).filter(is_reported) else { return Vec::new() };
    let SharedError { shared, own, ratio, between, within, p } = error;
    let message = match shared / own {
        times if times < COPIED => format!(
            "readings of one configuration share an error, {times:.1} times as large as what each has for itself: intervals count \
             it, and repeats narrow them little (F = {ratio:.1} with {between:.0} and {within:.0} degrees of freedom)"
        ),
        _ => {
            "readings of one configuration share their errors to the last digit: no instrument repeats itself so".into()
        }
    };
    let figures = [("shared_in_stated_noise", shared), ("own_in_stated_noise", own), ("ratio", ratio), ("p", p)];
    let warning = figures
        .into_iter()
        .fold(Diagnostic::warning(message), |diagnostic, (name, value)| diagnostic.figure(name, value));
    let remedy = "measure more configurations instead of repeats; `diagnose` looks for what the model misses";
    vec![warning.remedy(remedy)]
}
