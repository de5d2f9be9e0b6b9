//! Numbers and lists on the command line.

use crate::Error;
use crate::description::columns::TOOL_POINT;
use crate::description::resolve::GREATEST;
use crate::description::units::Units;
use crate::diagnostic::Diagnostic;
use crate::files::LoadedRobot;
use crate::kinematics::Hold;
use crate::model::Model;

/// `a=1,b=2` in the description's units, to SI; variables not named are zero, or the middle of limits that exclude zero.
/// A list without names gives all of them in order.
pub fn joints(model: &Model, units: &Units, text: &str) -> Result<Vec<f64>, Error> {
    let mut q: Vec<f64> = model
        .variables
        .iter()
        .zip(model.middle())
        .map(|(variable, middle)| match variable.limits {
            Some([low, high]) if low > 0.0 || high < 0.0 => middle,
            _ => 0.0,
        })
        .collect();
    let mut diagnostics = Vec::new();
    let mut named = std::collections::HashSet::new();
    let entries: Vec<&str> = text.split(',').map(str::trim).filter(|entry| !entry.is_empty()).collect();
    let in_order = entries.len() == q.len() && entries.iter().all(|entry| !entry.contains('='));
    for (k, entry) in entries.into_iter().enumerate() {
        let (name, value) = match entry.split_once('=') {
            Some((name, value)) => (name.trim(), value.trim()),
            None if in_order => (model.variables[k].name.as_str(), entry),
            None => {
                let names: Vec<String> = model.variables.iter().map(|v| format!("{}=..", v.name)).collect();
                return Err(Error::input(
                    format!("`{entry}` is not of the form name=value"),
                    format!("write {}, in any order; or {} numbers without names", names.join(","), q.len()),
                ));
            }
        };
        let Some(index) = model.variables.iter().position(|variable| variable.name == name) else {
            diagnostics.push(
                Diagnostic::error(format!("unknown variable `{name}`"))
                    .suggest(name, model.variables.iter().map(|v| v.name.as_str())),
            );
            continue;
        };
        if !named.insert(index) {
            diagnostics.push(Diagnostic::error(format!("variable `{name}` is given twice")).remedy("give each once"));
        }
        let factor = if model.variables[index].is_angle { units.angle.factor() } else { units.length.factor() };
        match value.parse::<f64>() {
            Ok(value) if value.abs() * factor <= GREATEST => q[index] = value * factor,
            Ok(value) if value.is_finite() => {
                let message = format!("`{value:e}` is too great (variable `{name}`)");
                diagnostics.push(Diagnostic::error(message).remedy("give it in the description's units"));
            }
            _ => {
                let unit = if model.variables[index].is_angle { units.angle.symbol() } else { units.length.symbol() };
                diagnostics.push(
                    Diagnostic::error(format!("`{value}` is no finite number (variable `{name}`)")).remedy(
                        if value.contains('=') {
                            "separate the variables by commas: a=1,b=2".to_owned()
                        } else {
                            format!("write the number alone, in {unit}: {name}=1.5")
                        },
                    ),
                );
            }
        }
    }
    if diagnostics.is_empty() { Ok(q) } else { Err(Error::from(diagnostics)) }
}

/// Refuses the value of an option that is not within its range; `remedy` says which.
pub fn within(flag: &str, value: f64, is_within: impl Fn(f64) -> bool, remedy: &str) -> Result<(), Error> {
    if is_within(value) { Ok(()) } else { Err(Error::input(format!("{flag} `{value}`"), remedy)) }
}

/// `name=low:high`
fn range<'t>(flag: &str, entry: &'t str) -> Result<(&'t str, f64, f64), Error> {
    let parsed = entry.split_once('=').and_then(|(name, range)| {
        let (low, high) = range.split_once(':')?;
        Some((name.trim(), low.trim().parse::<f64>().ok()?, high.trim().parse::<f64>().ok()?))
    });
    parsed
        .filter(|(_, low, high)| (high - low).is_finite())
        .ok_or_else(|| Error::input(format!("{flag} `{entry}`"), "write name=low:high, two numbers"))
}

/// The box of the variables: a share of their limits, and narrower ones; warnings of those that reach out of it.
pub fn ranges(
    flag: &str,
    loaded: &LoadedRobot,
    mut within: Vec<[f64; 2]>,
    ranges: &[String],
) -> Result<(Vec<[f64; 2]>, Vec<Diagnostic>), Error> {
    let (model, units): (&Model, _) = (&loaded.model, &loaded.raw.units);
    let mut diagnostics = Vec::new();
    for entry in ranges {
        let (name, low, high) = range(flag, entry)?;
        if low >= high {
            return Err(Error::input(
                format!("{flag} `{entry}`: low must be below high"),
                format!("write {name}={high}:{low}"),
            ));
        }
        let Some(k) = model.variables.iter().position(|variable| variable.name == name) else {
            let known = model.variables.iter().map(|variable| variable.name.as_str());
            return Err(Error::unknown(format!("{flag}: unknown variable `{name}`"), name, known));
        };
        let factor = if model.variables[k].is_angle { units.angle.factor() } else { units.length.factor() };
        let narrowed = [within[k][0].max(low * factor), within[k][1].min(high * factor)];
        if narrowed[0] >= narrowed[1] {
            let [low, high] = within[k].map(|v| v / factor);
            return Err(Error::input(
                format!("{flag} `{entry}` is outside the variable's limits"),
                format!("`{name}` goes from {low:.4} to {high:.4}"),
            ));
        }
        if narrowed != [low * factor, high * factor] {
            let [least, most] = narrowed.map(|v| v / factor);
            let message = format!("{flag} `{entry}` is narrowed to {least:.4}:{most:.4}");
            let remedy = "beyond these are the variable's limits, or the --share of them";
            diagnostics.push(Diagnostic::warning(message).remedy(remedy));
        }
        within[k] = narrowed;
    }
    Ok((within, diagnostics))
}

/// How far a workpiece may be moved: `x=-200:200,rz=-30:30` along x, y, z and about rx, ry, rz, to SI; not at all in what is not named.
pub fn movement(flag: &str, units: &Units, entries: &[String]) -> Result<[[f64; 2]; 6], Error> {
    let mut within = [[0.0; 2]; 6];
    for entry in entries {
        let (name, low, high) = range(flag, entry)?;
        let Some(k) = Hold::NAMES.iter().position(|known| *known == name) else {
            return Err(Error::unknown(format!("{flag}: `{name}` is no direction"), name, Hold::NAMES));
        };
        if !(low <= 0.0 && 0.0 <= high && low < high) {
            let remedy = "let the range hold 0, the place given; shift the path's own points for another start";
            return Err(Error::input(format!("{flag} `{entry}`"), remedy));
        }
        if within[k] != [0.0; 2] {
            return Err(Error::input(format!("{flag}: `{name}` is given twice"), "give each once"));
        }
        let (factor, most) =
            if k < 3 { (units.length.factor(), GREATEST) } else { (units.angle.factor(), std::f64::consts::PI + 1e-9) };
        within[k] = [low * factor, high * factor];
        if within[k].iter().any(|v| v.abs() > most) {
            return Err(Error::input(
                format!("{flag} `{entry}` is too far"),
                "turn by half a turn at most; check the units",
            ));
        }
    }
    Ok(within)
}

/// A list of finite numbers of one of the lengths allowed.
pub fn numbers(flag: &str, text: &str, lengths: &[usize]) -> Result<Vec<f64>, Error> {
    let parsed: Option<Vec<f64>> =
        text.split(',').map(|n| n.trim().parse().ok().filter(|v: &f64| v.abs() <= GREATEST)).collect();
    match parsed {
        Some(numbers) if lengths.contains(&numbers.len()) => Ok(numbers),
        _ => {
            let wanted: Vec<String> = lengths.iter().map(ToString::to_string).collect();
            Err(Error::input(
                format!("{flag} `{text}`"),
                format!("give {} finite numbers, separated by commas", wanted.join(" or ")),
            ))
        }
    }
}

/// What `--hold` names: whole sets of directions, and single ones.
pub fn hold(names: &[String]) -> Result<Hold, Error> {
    let mut held = [false; 6];
    for name in names.iter().map(|name| name.trim()) {
        let whole = [("pose", Hold::POSE), ("axis", Hold::AXIS), ("position", Hold::POSITION)];
        let single = Hold::NAMES.iter().position(|known| *known == name);
        match (whole.into_iter().find(|(known, _)| *known == name), single) {
            (Some((_, Hold(more))), _) => (0..6).for_each(|k| held[k] |= more[k]),
            (_, Some(k)) => held[k] = true,
            _ => {
                let known = whole.iter().map(|(known, _)| *known).chain(Hold::NAMES);
                return Err(Error::unknown(format!("--hold: `{name}` is no direction"), name, known));
            }
        }
    }
    Ok(Hold(held))
}

/// Greatest force (N) or moment (N.m) that is taken for one.
const GREATEST_LOAD: f64 = 1e9;

/// A wrench in the description's units, to SI; three numbers are a force.
pub fn wrench(units: &Units, text: &str) -> Result<[f64; 6], Error> {
    let given = numbers("--wrench", text, &[3, 6])?;
    let mut wrench = [0.0; 6];
    for (k, value) in given.into_iter().enumerate() {
        wrench[k] = value * if k < 3 { units.force.factor() } else { units.torque.factor() };
        if wrench[k].abs() > GREATEST_LOAD {
            return Err(Error::input(
                format!("--wrench `{text}`: {value:e} is no load that a robot bears"),
                "give force and moment in the description's units, `units: {force: .., torque: ..}`",
            ));
        }
    }
    Ok(wrench)
}

/// The refusal of a question that a rigid robot cannot answer.
pub fn nothing_elastic(so: &str) -> Error {
    Error::Impossible {
        message: format!("the description declares nothing elastic{so}"),
        remedy: "give `joint_stiffness`, `beams` or `base_stiffness`",
    }
}

/// Refuses names that are no parameters of the model.
pub fn known_parameters<'a>(model: &Model, names: impl IntoIterator<Item = &'a str>) -> Result<(), Error> {
    let unknown: Vec<Diagnostic> = names
        .into_iter()
        .filter(|name| model.registry.slot(name).is_none())
        .map(|name| {
            Diagnostic::error(format!("unknown parameter `{name}`"))
                .suggest(name, model.registry.all().iter().map(|p| p.name.as_str()))
        })
        .collect();
    if unknown.is_empty() { Ok(()) } else { Err(Error::from(unknown)) }
}

/// Units with some of them replaced: `length=mm,angle=deg`.
pub fn units_with(units: &Units, text: Option<&str>) -> Result<Units, Error> {
    let mut all = serde_json::to_value(units)?;
    for entry in text.unwrap_or_default().split(',').map(str::trim).filter(|entry| !entry.is_empty()) {
        let Some((kind, unit)) = entry.split_once('=').map(|(kind, unit)| (kind.trim(), unit.trim())) else {
            return Err(Error::input(format!("--units `{entry}`"), "write kind=unit, as `length=mm`"));
        };
        let kinds: Vec<String> = all.as_object().map(|all| all.keys().cloned().collect()).unwrap_or_default();
        if !kinds.iter().any(|known| known == kind) {
            let message = format!("--units: unknown quantity `{kind}`");
            return Err(Error::unknown(message, kind, kinds.iter().map(String::as_str)));
        }
        all[kind] = serde_json::Value::String(unit.into());
        if let Err(error) = serde_json::from_value::<Units>(all.clone()) {
            return Err(Error::input(format!("--units `{entry}`: {error}"), "write kind=unit, as `length=mm`"));
        }
    }
    Ok(serde_json::from_value(all)?)
}

/// Markers of a robot by name, `TCP` the tool centre point; that where none is named.
///
/// # Errors
/// No such marker.
pub fn markers(model: &Model, names: &[String]) -> Result<Vec<Option<usize>>, Error> {
    if names.is_empty() {
        return Ok(vec![None]);
    }
    let mut markers = Vec::new();
    for name in names {
        match model.marker(name) {
            Some(marker) => markers.push(Some(marker)),
            None if TOOL_POINT.contains(&name.as_str()) => markers.push(None),
            None => {
                let valid = model.markers.iter().map(|marker| marker.name.as_str()).chain(["TCP"]);
                return Err(Error::unknown(format!("unknown marker `{name}`"), name, valid));
            }
        }
    }
    Ok(markers)
}
