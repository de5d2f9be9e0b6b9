//! Configurations beyond the limits that a description declares: mostly a matter of units.

use std::f64::consts::TAU;

use super::robot::Variable;
use super::units::{Angle, Units};
use crate::diagnostic::{Diagnostic, Place};

/// Beyond its limits by less than this (rad or m) a value counts as rounded.
const ROUNDED: f64 = 1e-4;

/// One warning a variable that some of the `configurations` (rad, m) take beyond its limits: how many, and the first.
///
/// `of` says what they are (`readings`); `units` are those they were given in; `place` says where a row's variable stands.
pub fn beyond<'a>(
    variables: &[Variable],
    units: &Units,
    of: &str,
    configurations: impl Iterator<Item = &'a [f64]>,
    place: impl Fn(usize, &str) -> Option<Place>,
) -> Vec<Diagnostic> {
    // Of each variable: how many, and the first: its row and value.
    let mut found: Vec<Option<(usize, usize, f64)>> = vec![None; variables.len()];
    let mut all = 0;
    for (row, q) in configurations.enumerate() {
        all += 1;
        for ((variable, value), found) in variables.iter().zip(q).zip(&mut found) {
            let Some([low, high]) = variable.limits else { continue };
            if *value < low - ROUNDED || *value > high + ROUNDED {
                *found = Some(found.map_or((1, row, *value), |(count, row, value)| (count + 1, row, value)));
            }
        }
    }
    let found = variables.iter().zip(found).filter_map(|(variable, found)| Some((variable, found?)));
    found.map(|(variable, (count, row, value))| {
        let (kind, unit, factor) = if variable.is_angle {
            ("angles", units.angle.symbol(), units.angle.factor())
        } else {
            ("lengths", units.length.symbol(), units.length.factor())
        };
        let turns = variable.limits.filter(|_| variable.is_angle).and_then(|limits| whole_turns(value, limits));
        let turn = turns.map(|turns| shown(turns * TAU / factor));
        let [low, high] = variable.limits.unwrap_or([f64::NEG_INFINITY, f64::INFINITY]).map(|v| shown(v / factor));
        let value = shown(value / factor);
        let name = &variable.name;
        let message = if all > 1 {
            format!(
                "`{name}` is beyond its limits {low} .. {high} {unit} in {count} of {all} {of}; the first: {value} {unit}"
            )
        } else {
            format!("`{name}` = {value} {unit} is beyond its limits {low} .. {high} {unit}")
        };
        let remedy = if let Some(turn) = turn {
            format!("less {turn} {unit} it is within them: take whole turns off it")
        } else if of == READINGS {
            format!("{kind} here are in {unit}: check the campaign's `units`, or `limits` of the description")
        } else {
            format!("{kind} here are in {unit}: check the values, or `units` and `limits` of the description")
        };
        Diagnostic::warning(message).at(place(row, name)).remedy(remedy)
    })
    .collect()
}

/// A warning of an angle (rad) that is whole turns beyond its limits (rad), shown in units of `unit`; `what` names it with its value.
pub fn turned(what: &str, value: f64, limits: [f64; 2], unit: Angle) -> Option<Diagnostic> {
    let turn = whole_turns(value, limits)? * TAU;
    let [turn, low, high] = [turn, limits[0], limits[1]].map(|angle| shown(angle / unit.factor()));
    let symbol = unit.symbol();
    let message = format!("{what} is whole turns beyond the limits of that joint, {low} .. {high} {symbol}");
    Some(Diagnostic::warning(message).remedy(format!("take {turn} {symbol} off it")))
}

/// Whole turns by which an angle beyond its limits (rad) is off, where without them it is within.
fn whole_turns(value: f64, [low, high]: [f64; 2]) -> Option<f64> {
    let turns = ((value - 0.5 * (low + high)) / TAU).round();
    let within = value - turns * TAU;
    (turns != 0.0 && (low - ROUNDED..=high + ROUNDED).contains(&within)).then_some(turns)
}

/// What rows of a campaign are.
pub const READINGS: &str = "readings";

/// As many digits as serve.
fn shown(value: f64) -> String {
    if value.is_finite() { format!("{}", (value * 1e4).round() / 1e4) } else { format!("{value}") }
}
