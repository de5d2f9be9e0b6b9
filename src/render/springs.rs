//! Springs as an identification tells of them: those that act as one, and those that show nothing.

use serde_json::{Value, json};

use super::table::{Screen, mm};
use crate::description::campaign::Campaign;
use crate::estimation::{Calibration, Equivalence, Estimate, Together};
use crate::model::Model;
use crate::parameter::{Kind, Parameter, Slot};

/// Whether an elastic parameter's value moves no reading by as much as a third of the noise.
pub fn insensitive(campaign: &Campaign, estimate: &Estimate) -> bool {
    let noise = campaign.sigma.map_or(3e-6, |sigma| sigma.into_iter().fold(0.0, f64::max));
    estimate.moves.is_some_and(|moves| moves < noise / 3.0)
}

/// What is said of a parameter that moves no reading.
pub fn any_value(parameter: &Parameter, estimate: &Estimate) -> String {
    let least = estimate.moves.map_or(0.0, mm);
    match parameter.kind {
        Kind::LinearCompliance | Kind::RotationalCompliance => {
            let from = 1.0 / (estimate.value + estimate.ci95.unwrap_or(0.0));
            let unit = parameter.kind.inverse().unit();
            format!("moves no reading by more than {least:.0e} mm: any stiffness above {from:.1e} {unit} fits")
        }
        _ => format!("moves no reading by more than {least:.0e} mm: any value near it fits"),
    }
}

/// The elastic parameters that were dropped and would show nothing if they were not.
pub fn insensitive_text(model: &Model, campaign: &Campaign, found: &Calibration) -> String {
    let rows = found.estimates.iter().filter(|e| !e.identifiable() && insensitive(campaign, e));
    let said: Vec<String> =
        rows.filter_map(|e| Some(format!("{} {:.0e} mm", model.registry[e.slot].name, mm(e.moves?)))).collect();
    if said.is_empty() {
        return String::new();
    }
    format!("move no reading by more than: {}; any value as stiff or stiffer fits\n", said.join(", "))
}

/// Whether no member of a group moves any reading.
fn all_insensitive(campaign: &Campaign, found: &Calibration, group: &Equivalence) -> bool {
    let of = |slot: Slot| found.estimates.iter().find(|estimate| estimate.slot == slot);
    group.springs.members.iter().all(|&(slot, _)| of(slot).is_some_and(|estimate| insensitive(campaign, estimate)))
}

/// The equivalent as it is spoken of: a stiffness, with its unit, and its interval's half width.
fn equivalent(model: &Model, group: &Equivalence) -> (&'static str, f64, f64) {
    let kind = model.registry[group.springs.members[0].0].kind;
    match group.springs.together {
        Together::Series => (kind.inverse().unit(), 1.0 / group.value, group.ci95 / (group.value * group.value)),
        Together::Parallel => {
            let stiffness = matches!(kind, Kind::LinearStiffness | Kind::RotationalStiffness);
            (if stiffness { kind } else { kind.inverse() }.unit(), group.value, group.ci95)
        }
    }
}

/// Names of a group's members, the kept one first.
fn members<'m>(model: &'m Model, group: &Equivalence) -> Vec<&'m str> {
    group.springs.members.iter().map(|&(slot, _)| model.registry[slot].name.as_str()).collect()
}

/// JSON of a group, SI.
pub fn equivalence_json(model: &Model, campaign: &Campaign, found: &Calibration, group: &Equivalence) -> Value {
    let (unit, value, ci95) = equivalent(model, group);
    let kind = if group.springs.together == Together::Series { "series" } else { "parallel" };
    let weights: Vec<f64> = group.springs.members.iter().map(|(_, weight)| *weight).collect();
    json!({"members": members(model, group), "kind": kind, "equivalent": value, "ci95": ci95, "unit": unit,
           "weights": weights, "insensitive": all_insensitive(campaign, found, group)})
}

/// A table of the groups.
pub fn equivalence_text(model: &Model, campaign: &Campaign, found: &Calibration, screen: Screen) -> String {
    let groups = &found.equivalences;
    if groups.is_empty() {
        return String::new();
    }
    let rows = groups.iter().map(|group| {
        let (unit, value, ci95) = equivalent(model, group);
        let how = if group.springs.together == Together::Series { "in series" } else { "side by side" };
        let diagnostic =
            if all_insensitive(campaign, found, group) { "moves no reading: any stiffer fits" } else { "" };
        let [value, ci95] = [format!("{value:.4e}"), format!("{ci95:.1e}")];
        vec![members(model, group).join(", "), how.into(), value, ci95, unit.into(), diagnostic.into()]
    });
    format!(
        "\nsprings that these readings see as one\n{}",
        screen.table(&["members", "act", "as one of", "95 % +-", "unit", ""], rows)
    )
}
