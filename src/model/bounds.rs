//! Bounds of single parameters against the values that the description declares.

use super::{Fault, Model};
use crate::description::raw::RawRobot;
use crate::diagnostic::Diagnostic;

/// Part of a value by which it may lie outside its bounds: what is left of changing units there and back.
const ROUNDING: f64 = 1e-9;

/// Entries of `calibration.bounds` that a declared value contradicts, in the file's units.
#[must_use]
pub fn contradictions(raw: &RawRobot, model: &Model) -> Vec<Fault> {
    let mut faults = Vec::new();
    for (name, &[low, high]) in &raw.calibration.bounds {
        let Some(slot) = model.registry.slot(name) else { continue };
        let parameter = &model.registry[slot];
        let kind = parameter.shown_kind();
        let value = parameter.shown(parameter.nominal) / raw.units.of(kind);
        let slack = if value.is_finite() { ROUNDING * value.abs() } else { 0.0 };
        let path = ["calibration", "bounds", name];
        let (message, remedy) = if kind.is_spring() && low < 0.0 {
            (format!("`{name}` cannot be below 0, as its bound {low} is"), "begin its bounds at 0 or above")
        } else if !(low - slack..=high + slack).contains(&value) {
            (
                format!("`{name}` is declared as {}, outside its bounds [{low}, {high}]", short(value)),
                "widen the bounds, or declare a value within them",
            )
        } else {
            continue;
        };
        faults.push(Fault::new(&path, Diagnostic::error(message).remedy(remedy)));
    }
    faults
}

/// A value without the last digits, which units changed there and back may have spoiled.
fn short(value: f64) -> f64 {
    format!("{value:.11e}").parse().unwrap_or(value)
}
