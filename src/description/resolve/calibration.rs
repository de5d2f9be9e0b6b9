//! Parameter names, tolerances and bounds of the `calibration:` block.

use indexmap::IndexMap;

use super::super::parameters::{Key, parameters};
use super::super::raw::RawRobot;
use super::super::robot::{Calibration, Combination};
use super::collector::Collector;
use crate::parameter::Kind;

pub fn resolve(raw: &RawRobot, diagnostics: &mut Collector) -> Calibration {
    let (length, angle) = (raw.units.length.factor(), raw.units.angle.factor());
    let given = &raw.calibration;
    let valid: IndexMap<String, Key> =
        parameters(raw).into_iter().filter(|key| key.declared).map(|key| (key.name.clone(), key)).collect();
    check_names(raw, &valid, diagnostics);
    let factor = |name: &str| valid.get(name).map_or(length, |key| raw.units.of(key.kind));
    let mut positive = |path: &[&str], value: f64, factor: f64| {
        if !(value.is_finite() && value * factor >= LEAST_TOLERANCE) {
            diagnostics.error(path, format!("tolerance `{value}` must be a finite number above 0"));
        }
        value * factor
    };
    let length_tolerance =
        given.length_tolerance.map_or(1e-3, |v| positive(&["calibration", "length_tolerance"], v, length));
    let angle_tolerance =
        given.angle_tolerance.map_or(1e-3, |v| positive(&["calibration", "angle_tolerance"], v, angle));
    let tolerances: IndexMap<String, f64> = given
        .tolerances
        .iter()
        .map(|(name, value)| (name.clone(), positive(&["calibration", "tolerances", name], *value, factor(name))))
        .collect();
    let bounds = given
        .bounds
        .iter()
        .filter_map(|(name, bounds)| {
            let path = ["calibration", "bounds", name.as_str()];
            diagnostics.interval(&path, Some(*bounds), factor(name), true).map(|bounds| (name.clone(), bounds))
        })
        .collect();
    for (name, value) in &given.uncertainties {
        if !(value.is_finite() && *value >= 0.0) {
            let message = format!("uncertainty `{value}` must be a finite number, 0 or more");
            diagnostics.error(&["calibration", "uncertainties", name], message);
        }
    }
    check_fit(raw, &valid, diagnostics);
    Calibration {
        free: given.free.clone(),
        fixed: given.fixed.clone(),
        length_tolerance,
        angle_tolerance,
        tolerances,
        bounds,
        combinations: combinations(raw, &valid, diagnostics),
    }
}

/// The sums in which results are reported too, in SI.
fn combinations(
    raw: &RawRobot,
    valid: &IndexMap<String, Key>,
    diagnostics: &mut Collector,
) -> IndexMap<String, IndexMap<String, Combination>> {
    let mut all: IndexMap<String, IndexMap<String, Combination>> = IndexMap::new();
    for (convention, own) in &raw.combinations {
        for (name, of) in own {
            let path = ["combinations", convention, name];
            for (member, factor) in of {
                let path = [&path[..], &[member.as_str()]].concat();
                diagnostics.known(&path, "parameter", member, valid.keys().map(String::as_str));
                if !factor.is_finite() {
                    diagnostics.error(&path, format!("factor `{factor}` must be a finite number"));
                }
            }
            let mut kinds: Vec<Kind> = Vec::new();
            for kind in of.keys().filter_map(|member| Some(valid.get(member)?.kind)) {
                if !kinds.contains(&kind) {
                    kinds.push(kind);
                }
            }
            let is_sum = matches!(kinds[..], [_] | [Kind::Length, Kind::Angle] | [Kind::Angle, Kind::Length]);
            if !is_sum {
                if kinds.len() > 1 || of.is_empty() {
                    let remedy = "add parameters of one unit, or lengths and angles with their levers";
                    diagnostics.reject(&path, format!("`{name}` is no sum of parameters"), remedy);
                }
                continue;
            }
            let has_lever = kinds.len() > 1;
            let kind = if has_lever { Kind::Length } else { kinds[0] };
            let lever = |member: &str| has_lever && valid.get(member).is_some_and(|key| key.kind == Kind::Angle);
            let of = of.iter().map(|(member, factor)| {
                (member.clone(), if lever(member) { factor * raw.units.length.factor() } else { *factor })
            });
            let combination = Combination { kind, of: of.collect() };
            all.entry(convention.clone()).or_default().insert(name.clone(), combination);
        }
    }
    all
}

/// Rejects a covariance that is none, and one of parameters that the description does not have: left out of it, predicted
/// positions would seem more certain than they are.
fn check_fit(raw: &RawRobot, valid: &IndexMap<String, Key>, diagnostics: &mut Collector) {
    let Some(fit) = &raw.calibration.fit else { return };
    let effects: Vec<String> = raw
        .effects
        .iter()
        .filter_map(|effect| Some(format!("{}@{}", effect.effect.as_ref()?, effect.site.as_ref()?)))
        .collect();
    for (position, name) in fit.parameters.iter().enumerate() {
        let path = ["calibration", "fit", "parameters", &position.to_string()];
        if fit.parameters[..position].contains(name) {
            diagnostics.reject(&path, format!("`{name}` stands here twice"), "give each parameter one row and column");
            continue;
        }
        let of_effect = effects.iter().filter_map(|owner| name.strip_prefix(owner.as_str()));
        if !of_effect.into_iter().any(|rest| rest.starts_with(['.', '#'])) {
            diagnostics.known(&path, "parameter", name, valid.keys().map(String::as_str));
        }
    }
    let path = ["calibration", "fit", "covariance"];
    let is_triangle = fit.covariance.len() == fit.parameters.len()
        && fit.covariance.iter().enumerate().all(|(row, own)| own.len() == row + 1);
    if !is_triangle {
        let n = fit.parameters.len();
        diagnostics.error(&path, format!("the lower triangle for {n} `parameters` has rows of 1 to {n} numbers"));
        return;
    }
    let is_number = |value: &f64| value.is_finite();
    let is_variance = |own: &Vec<f64>| own.last().is_some_and(|variance| *variance >= 0.0);
    if !fit.covariance.iter().all(|own| own.iter().all(is_number) && is_variance(own)) {
        diagnostics.error(&path, "numbers must be finite, and the last of each row, a variance, 0 or more".to_string());
    }
    if !fit.unexplained.iter().all(|value| value.is_finite() && *value >= 0.0) {
        diagnostics.error(&["calibration", "fit", "unexplained"], "must be finite numbers, 0 or more".to_string());
    }
}

/// Rejects names of no parameter, and parameters both free and fixed.
fn check_names(raw: &RawRobot, valid: &IndexMap<String, Key>, diagnostics: &mut Collector) {
    let given = &raw.calibration;
    let mut known = |path: &[&str], name: &str| {
        diagnostics.known(path, "parameter", name, valid.keys().map(String::as_str));
    };
    for (key, list) in [("free", &given.free), ("fixed", &given.fixed)] {
        for (position, name) in list.iter().enumerate() {
            known(&["calibration", key, &position.to_string()], name);
        }
    }
    for (section, names) in
        [("tolerances", given.tolerances.keys().collect::<Vec<_>>()), ("bounds", given.bounds.keys().collect())]
    {
        for name in names {
            known(&["calibration", section, name], name);
        }
    }
    for (position, name) in given.fixed.iter().enumerate() {
        if given.free.contains(name) {
            let path = ["calibration", "fixed", &position.to_string()];
            diagnostics.reject(&path, format!("`{name}` is both free and fixed"), "keep it in one list");
        }
    }
}

/// Tolerances below this (m or rad) are nothing but zero.
const LEAST_TOLERANCE: f64 = 1e-15;
