//! Faults and doubts of a campaign file alone, before its tables are read.

use super::columns::kinds;
use super::raw::{
    ContactKind, OrUnknown, RawAnchor, RawCampaign, RawContact, RawEntry, RawInstrument, RawKinds, RawSigma,
};
use crate::description::resolve::{Explained, GREATEST, Locate, no_mass};
use crate::description::units::Units;
use crate::diagnostic::{Code, Diagnostic};
use crate::observation::{Kinds, Observes, POSITION};

/// Least noise (m or rad) above zero: below the resolution of any instrument and above the rounding of a metre.
pub(super) const LEAST_NOISE: f64 = 1e-15;

/// Greatest noise of a length, m: instruments of robot calibration (trackers, cameras, draw wires) reach less, and what is known no better
/// was not measured.
pub(super) const GREATEST_NOISE: f64 = 100.0;

/// Greatest part of the distance by which noise is believed to grow, parts per million: 1 mm in a metre. Tape measures of the coarsest class
/// (III of the directive 2014/32/EU, annex X) are off by at most 0.4 mm for each metre, and 0.6 mm.
const COARSEST: f64 = 1000.0;

/// Faults and doubts of the campaign file alone; `effects` are the names that `calibrate` may list, `kinds` what `observes` may.
pub fn faults(
    raw: &RawCampaign,
    effects: &[&str],
    kinds: &Kinds,
    locate: Locate,
    explained: Explained,
) -> Vec<Diagnostic> {
    let mut diagnostics = Vec::new();
    let is_unread = |k: usize| explained(&["measurements", &k.to_string(), "observes"]);
    let lacks = |(k, entry): (usize, &RawEntry)| entry.observes.is_none() && !is_unread(k);
    let lacks_kind = raw.measurements.as_ref().is_none_or(|all| all.0.iter().enumerate().any(lacks));
    if raw.observes.is_none() && lacks_kind && !explained(&["observes"]) {
        let diagnostic =
            Diagnostic::warning("`observes` is not given; positions are assumed").at(locate(&["observes"]));
        let others: Vec<&str> = kinds.iter().filter(|kind| *kind != POSITION).map(|kind| kind.name()).collect();
        diagnostics.push(diagnostic.remedy(format!("add `observes: position` (or {})", others.join(", "))));
    }
    for (path, name) in raw.unknown_kinds(kinds) {
        let path: Vec<&str> = path.iter().map(String::as_str).collect();
        // A single one is no list.
        let place = locate(&path).or_else(|| locate(&path[..path.len() - 1]));
        let diagnostic = Diagnostic::error(format!("unknown kind of readings `{name}`")).at(place);
        diagnostics.push(diagnostic.suggest(name, kinds.iter().map(|kind| kind.name())));
    }
    diagnostics.extend(no_or_repeated_kinds(raw, locate));
    for (position, effect) in raw.calibrate.iter().flatten().enumerate() {
        if !effects.contains(&effect.as_str()) {
            let diagnostic = Diagnostic::error(format!("unknown effect `{effect}`"))
                .at(locate(&["calibrate", &position.to_string()]));
            diagnostics.push(diagnostic.suggest(effect, effects.iter().copied()));
        }
    }
    let fixed = |anchor: &RawAnchor| anchor.at().unwrap_or_default();
    for (name, at) in raw.anchors.iter().map(|(name, anchor)| (name, fixed(anchor))) {
        if let Some(bad) = at.iter().find(|v| !(0.0..=GREATEST).contains(&(v.abs() * raw.units.length.factor()))) {
            let diagnostic = Diagnostic::error(format!("anchor `{name}`: `{bad}` where a finite length is needed"));
            diagnostics.push(diagnostic.at(locate(&["anchors", name])));
        }
    }
    for (name, contact) in &raw.contacts {
        let own = contact_faults(contact, raw.units.length.factor()).into_iter();
        let located = |(key, fault): (&str, Diagnostic)| fault.at(locate(&["contacts", name, key]));
        diagnostics.extend(own.map(located));
        if contact.kind.is_none() && !explained(&["contacts", name, "kind"]) {
            let kinds = "`socket`, `plane` or `sphere`";
            let diagnostic = Diagnostic::error(format!("`contacts.{name}` lacks `kind`")).code(Code::Missing);
            diagnostics.push(diagnostic.at(locate(&["contacts", name])).remedy(format!("add `kind:`, {kinds}")));
        }
    }
    for (name, _) in raw.payloads.iter().filter(|(_, payload)| payload.mass.is_none()) {
        if !explained(&["payloads", name, "mass"]) {
            let diagnostic = Diagnostic::error(no_mass(name)).code(Code::Missing);
            diagnostics.push(diagnostic.at(locate(&["payloads", name])).remedy("add `mass: ...`"));
        }
    }
    let whole = raw.completed(&RawEntry::default());
    diagnostics.extend(instrument(raw.instrument.as_ref(), &whole, kinds, &[], locate));
    for (k, entry) in raw.measurements.iter().flat_map(|all| &all.0).enumerate() {
        let number = k.to_string();
        diagnostics.extend(instrument(
            entry.instrument.as_ref(),
            &raw.completed(entry),
            kinds,
            &["measurements", &number],
            locate,
        ));
        if entry.on.is_some() {
            let fault =
                Diagnostic::error("`on:` says what fixed reflectors stand on, and these are readings of the robot");
            let fault = fault.at(locate(&["measurements", &number, "on"]));
            diagnostics.push(fault.remedy("leave it out here; under `references:` it has a meaning"));
        }
        for (key, name) in [("session", &entry.session), ("station", &entry.station)] {
            let fault = name.as_deref().and_then(|name| no_name(key, name));
            diagnostics.extend(fault.map(|fault| fault.at(locate(&["measurements", &number, key]))));
        }
    }
    diagnostics
}

/// Lists of kinds that are empty, or name one twice.
fn no_or_repeated_kinds(raw: &RawCampaign, locate: Locate) -> Vec<Diagnostic> {
    let entries = raw.measurements.iter().flat_map(|all| &all.0).enumerate();
    let of_entries = entries.filter_map(|(k, entry)| {
        let path = vec!["measurements".to_owned(), k.to_string(), "observes".to_owned()];
        Some((path, entry.observes.as_ref()?))
    });
    let own = raw.observes.as_ref().map(|kinds| (vec!["observes".to_owned()], kinds));
    let fault = |(path, kinds): (Vec<String>, &RawKinds)| {
        let path: Vec<&str> = path.iter().map(String::as_str).collect();
        let twice = kinds.0.iter().enumerate().find(|(k, name)| kinds.0[..*k].contains(name));
        let (message, remedy) = match (kinds.0.is_empty(), twice) {
            (true, _) => ("`observes` names no kind of reading".into(), "name one: `observes: position`"),
            (_, Some((_, name))) => (format!("`observes` names `{name}` twice"), "name each kind once"),
            _ => return None,
        };
        Some(Diagnostic::error(message).at(locate(&path)).remedy(remedy))
    };
    own.into_iter().chain(of_entries).filter_map(fault).collect()
}

/// What cannot be of a contact, with the key of it; lengths are in a unit of `length` m.
fn contact_faults(contact: &RawContact, length: f64) -> Vec<(&'static str, Diagnostic)> {
    let mut faults = Vec::new();
    if let Some(normal) = contact.normal.and_then(OrUnknown::known) {
        let size = normal.iter().map(|v| v * v).sum::<f64>();
        if !(size > 0.0 && size.is_finite()) {
            let diagnostic = Diagnostic::error(format!("the normal {normal:?} has no direction"));
            faults.push((
                "normal",
                diagnostic.remedy("give a vector towards the ball, or leave it out: it is estimated"),
            ));
        }
    }
    if contact.normal.is_some() && matches!(contact.kind, Some(ContactKind::Socket | ContactKind::Sphere)) {
        let diagnostic = Diagnostic::error("sockets and spheres have a centre, and no normal");
        faults.push(("normal", diagnostic.remedy("leave it out, or write `kind: plane`")));
    }
    let radius = contact.radius.map(OrUnknown::known);
    if radius.is_some() && contact.kind == Some(ContactKind::Socket) {
        let diagnostic = Diagnostic::error("a socket holds the ball's centre at a point, and has no radius");
        faults.push(("radius", diagnostic.remedy("leave it out, or write `kind: sphere`")));
    } else if let Some(radius) = radius.flatten() {
        let least = if contact.kind == Some(ContactKind::Sphere) { f64::MIN_POSITIVE } else { 0.0 };
        if !(least..=GREATEST).contains(&(radius * length)) {
            let diagnostic = Diagnostic::error(format!("the radius `{radius}` is no distance of the ball's centre"));
            faults.push(("radius", diagnostic.remedy("give a positive length, or leave it out")));
        }
    }
    faults
}

/// The fault of a name of a session or station that parameters (`base@NAME.x`) could not have.
pub(super) fn no_name(of: &str, name: &str) -> Option<Diagnostic> {
    let is_name = name.chars().all(|c| c.is_ascii_alphanumeric() || matches!(c, '_' | '-'));
    let diagnostic = || Diagnostic::error(format!("`{name}` is no name of a {of}"));
    (!is_name).then(|| diagnostic().remedy("write letters, digits, `_` and `-` only"))
}

/// Faults of what is stated of an instrument at a path of the file; `entry` is what else holds there.
fn instrument(
    stated: Option<&RawInstrument>,
    entry: &RawEntry,
    known: &Kinds,
    path: &[&str],
    locate: Locate,
) -> Vec<Diagnostic> {
    let Some(stated) = stated else { return Vec::new() };
    let locate = |keys: &[&str]| locate(&[path, keys].concat());
    let observes = kinds(entry, known).first().copied().unwrap_or(POSITION);
    let mut faults = impossible_noise(stated, &entry.units(Units::default()), &locate);
    faults.extend(noise_by_axis(stated, observes, &locate));
    faults.extend(coarse(stated, &locate));
    faults
}

/// A noise that grows by more of the distance than that of any instrument.
fn coarse(instrument: &RawInstrument, locate: Locate) -> Option<Diagnostic> {
    let ppm = instrument.ppm.filter(|ppm| *ppm > COARSEST && *ppm <= 1e6)?;
    let message = format!("`ppm: {ppm}` of the instrument is implausible: a tape measure has less than {COARSEST}");
    let diagnostic = Diagnostic::warning(message).code(Code::Doubtful).at(locate(&["instrument", "ppm"]));
    Some(diagnostic.remedy("give parts per million of the distance: 10 of a tracker is 0.01 mm in a metre"))
}

/// A single length has no noise by axis.
fn noise_by_axis(instrument: &RawInstrument, observes: Observes, locate: Locate) -> Option<Diagnostic> {
    match instrument.sigma {
        Some(RawSigma::ByAxis { x, y, z }) if observes.length_rows() == 1 && (x != y || y != z) => {
            let message = format!("the noise of a {} is one number, not one by axis", observes.name());
            let diagnostic = Diagnostic::error(message).at(locate(&["instrument", "sigma"]));
            Some(diagnostic.remedy("give `sigma:` as one number, that of the length itself"))
        }
        _ => None,
    }
}

/// Noises that are zero, negative or not finite.
fn impossible_noise(instrument: &RawInstrument, units: &Units, locate: Locate) -> Vec<Diagnostic> {
    let [length, angle, torque] = [units.length.factor(), units.angle.factor(), units.torque.factor()];
    let mut stated: Vec<(Vec<&str>, f64, f64)> = Vec::new();
    match instrument.sigma {
        Some(RawSigma::All(value)) => stated.push((vec!["sigma"], value, length)),
        Some(RawSigma::ByAxis { x, y, z }) => {
            stated.extend([("x", x), ("y", y), ("z", z)].map(|(axis, value)| (vec!["sigma", axis], value, length)));
        }
        None => {}
    }
    stated.extend(instrument.orientation.map(|value| (vec!["orientation"], value, angle)));
    stated.extend(instrument.torque.map(|value| (vec!["torque"], value, torque)));
    stated.extend(instrument.ppm.map(|value| (vec!["ppm"], value, 1e-6)));
    // A part of the distance is less than the distance.
    let greatest = |path: &[&str]| match path {
        ["ppm"] => 1.0,
        ["sigma", ..] => GREATEST_NOISE,
        _ => GREATEST,
    };
    stated.retain(|(path, value, factor)| !(LEAST_NOISE..=greatest(path)).contains(&(value * factor)));
    let fault = |(path, value, _): (Vec<&str>, f64, f64)| {
        let is_ppm = path == ["ppm"];
        let message = match is_ppm {
            true => format!("`ppm: {value}` of the instrument, where a number above 0 and up to 1e6 is needed"),
            false if path[0] == "sigma" && value.is_finite() && value * length > GREATEST_NOISE => {
                format!("the instrument's noise is {value}: more than {GREATEST_NOISE} m is no measurement")
            }
            false => format!("the instrument's noise is {value}, and must be a finite number above 0"),
        };
        let remedy = match is_ppm {
            true => {
                "give what is added to `sigma`, in parts per million of the distance; leave it out where that is nothing"
            }
            false => "give one sigma; leave it out to have it estimated from the residuals",
        };
        Diagnostic::error(message).at(locate(&[&["instrument"], &path[..]].concat())).remedy(remedy)
    };
    stated.into_iter().map(fault).collect()
}
