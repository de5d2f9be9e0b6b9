//! Errors and effects that the command puts into the robot.

use indexmap::IndexMap;

use crate::Error;
use crate::cli::values::known_parameters;
use crate::description::raw::{RawAmount, RawEffect};
use crate::diagnostic::{Diagnostic, Severity};
use crate::effects::EffectEntry;
use crate::files::LoadedRobot;
use crate::model::Model;
use crate::parameter::{Kind, Parameter};

/// `EFFECT@SITE:parameter=value,...`, SI.
pub fn effect(model: &Model, text: &str) -> Result<EffectEntry, Error> {
    let refused = |diagnostic: Diagnostic| {
        let message = format!("--effect `{text}`: {}", diagnostic.message);
        Error::from(Diagnostic { message, severity: Severity::Error, ..diagnostic })
    };
    let (name, rest) = text.split_once('@').unwrap_or((text, ""));
    // A site may hold a colon of its own: what follows the last one with `=` in it are parameters.
    let (site, stated) = match rest.rsplit_once(':') {
        Some((site, stated)) if stated.contains('=') => (site, stated),
        _ => (rest, ""),
    };
    let mut parameters = IndexMap::new();
    for entry in stated.split(',').filter(|entry| !entry.trim().is_empty()) {
        let Some((key, value)) = entry.split_once('=') else {
            return Err(Error::input(format!("--effect `{text}`: `{entry}`"), "write parameter=value, SI"));
        };
        let value = value.trim();
        let value = value.parse::<f64>().map_or_else(|_| value.into(), RawAmount::from);
        parameters.insert(key.trim().to_string(), value);
    }
    let raw =
        RawEffect { effect: Some(name.trim().into()), site: Some(site.into()), parameters, ..RawEffect::default() };
    let entry = model.resolve_effect(&raw).map_err(|fault| refused(fault.diagnostic))?;
    match entry.doubt(model) {
        Some(doubt) if entry.amounts.is_empty() => Err(refused(doubt)),
        _ => Ok(entry),
    }
}

/// `name=value`, added to what the description says.
///
/// # Errors
/// No such parameter, or no such value of it.
pub fn set_errors(loaded: &LoadedRobot, set: &[String], values: &mut [f64]) -> Result<(), Error> {
    let model = &loaded.model;
    for entry in set {
        let Some((name, value)) = entry.split_once('=') else {
            return Err(Error::input(format!("--set `{entry}`"), "write name=value"));
        };
        known_parameters(model, [name.trim()])?;
        let Some(slot) = model.registry.slot(name.trim()) else { continue };
        let parameter = &model.registry[slot];
        let factor = loaded.raw.units.of(parameter.shown_kind());
        match value.trim().parse::<f64>() {
            // A stiffness without end is a compliance of zero.
            Ok(value) if value == f64::INFINITY && parameter.inverted => values[slot] = 0.0,
            Ok(value) if value.abs() * factor <= crate::description::resolve::GREATEST => {
                let declared = parameter.shown(parameter.nominal);
                // Nothing adds to what is rigid: the value is then the stiffness itself.
                let changed = if declared.is_finite() { declared + value * factor } else { value * factor };
                stays_possible(entry, parameter, changed, factor)?;
                // Shown and held are each other's inverse, or the same.
                values[slot] = parameter.shown(changed);
            }
            _ => {
                return Err(Error::input(
                    format!("--set `{entry}`: `{value}` is no finite number"),
                    "write name=value",
                ));
            }
        }
    }
    Ok(())
}

/// Refuses a change after which a stiffness or the like would be negative; `changed` as it is shown, SI.
fn stays_possible(entry: &str, parameter: &Parameter, changed: f64, factor: f64) -> Result<(), Error> {
    let declared = parameter.shown(parameter.nominal);
    // What is left of a value and its inverse is nothing.
    let changed = if declared.is_finite() && changed.abs() < 1e-9 * declared.abs() { 0.0 } else { changed };
    let must = match parameter.shown_kind() {
        Kind::LinearStiffness | Kind::RotationalStiffness | Kind::Pressure if changed <= 0.0 => "be above 0",
        Kind::LinearCompliance | Kind::RotationalCompliance | Kind::Mass if changed < 0.0 => "not be below 0",
        _ => return Ok(()),
    };
    let name = &parameter.name;
    let [changed, declared] = [changed, declared].map(|v| format!("{:.6e}", v / factor).parse().unwrap_or(v / factor));
    Err(Error::input(
        format!("--set `{entry}` makes `{name}` {changed}, and it must {must}"),
        format!("--set adds to what the description says, {declared}"),
    ))
}
