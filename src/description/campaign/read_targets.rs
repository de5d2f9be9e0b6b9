//! What the readings of a campaign file refer to, from its `anchors:`, `contacts:` and `distances:`.

use nalgebra::Vector3;

use super::raw::{ContactKind, OrUnknown, RawAnchor, RawCampaign, RawContact};
use super::source::Source;
use super::targets::{Constraint, Target, TargetValue};
use crate::description::resolve::Locate;
use crate::description::robot::Robot;
use crate::diagnostic::Diagnostic;
use crate::observation::{Observes, PLANE, SOCKET, SPHERE};
use crate::parameter::Kind;

/// One sigma of a distance that is stated as known, m: what a drilled or measured plate keeps.
const DISTANCE_SIGMA: f64 = 1e-5;

/// Values with symbols: known, or parameters of their owner.
fn values(owner: &str, of: &[(&str, Kind, OrUnknown<f64>, f64)]) -> Vec<TargetValue> {
    let value = |&(symbol, kind, given, start): &(&str, Kind, OrUnknown<f64>, f64)| TargetValue {
        value: given.known().unwrap_or(start),
        kind,
        parameter: given.known().is_none().then(|| format!("{owner}.{symbol}")),
    };
    of.iter().map(value).collect()
}

/// What the readings of a campaign refer to.
pub(super) fn targets(
    raw: &RawCampaign,
    robot: &Robot,
    sources: &[Source],
    kinds: &[Observes],
    locate: Locate,
    diagnostics: &mut Vec<Diagnostic>,
) -> Vec<Target> {
    let mut targets = Vec::new();
    let needs = |column: &str| kinds.iter().any(|kind| kind.target_column() == Some(column));
    if needs("anchor") {
        let declared = |name: &String| raw.anchors.contains_key(name);
        let own = robot.anchors.iter().filter(|(name, _)| !declared(name));
        targets.extend(own.map(|(name, at)| Target::anchor(name, at)));
        targets.extend(raw.anchors.iter().map(|(name, anchor)| self::anchor(name, anchor, raw.units.length.factor())));
    }
    if needs("contact") {
        for (name, contact) in &raw.contacts {
            for group in groups(contact, sources) {
                targets.push(self::contact(name, contact, group, raw.units.length.factor()));
            }
        }
    }
    let taken = |target: &&Target| {
        let owner = target.name.as_str();
        let is_owner = robot.markers.iter().any(|marker| marker.name == owner)
            || robot.frames.iter().any(|frame| frame.name == owner)
            || ["base", "tool"].contains(&owner);
        target.is_estimated() && is_owner
    };
    for target in targets.iter().filter(taken) {
        let key = format!("{}s", target.column);
        let message = format!(
            "{} `{}` has the name of a part of the robot, and its parameters would too",
            target.column, target.name
        );
        diagnostics.push(Diagnostic::error(message).at(locate(&[&key, &target.name])).remedy("name it otherwise"));
    }
    for column in ["anchor", "contact"].into_iter().filter(|column| needs(column)) {
        if !targets.iter().any(|target| target.column == column) {
            let observes =
                kinds.iter().find(|kind| kind.target_column() == Some(column)).map_or("", |kind| kind.name());
            let (message, remedy) = match column {
                "anchor" => (
                    format!("{observes}s are measured from a fixed anchor, and none is declared"),
                    "add `anchors: {name: [x, y, z]}`, in the measurement frame; `{at: unknown}` where it is not known",
                ),
                _ => (
                    "contacts are observed, and none is declared".to_string(),
                    "add `contacts: {name: {kind: socket}}` (or plane, sphere)",
                ),
            };
            diagnostics.push(Diagnostic::error(message).at(locate(&["observes"])).remedy(remedy));
        }
    }
    targets
}

fn anchor(name: &str, raw: &RawAnchor, length: f64) -> Target {
    let (at, zero, near) = match raw {
        RawAnchor::At(at) => (OrUnknown::Known(*at), None, None),
        RawAnchor::Declared(declared) => (declared.at, declared.zero, declared.near),
    };
    let start = near.unwrap_or_default();
    let coordinate = |k: usize| match at {
        OrUnknown::Known(at) => OrUnknown::Known(at[k] * length),
        OrUnknown::Unknown(word) => OrUnknown::Unknown(word),
    };
    let zero = match zero {
        Some(OrUnknown::Known(zero)) => OrUnknown::Known(zero * length),
        Some(unknown) => unknown,
        None => OrUnknown::Known(0.0),
    };
    let point = ["x", "y", "z"].into_iter().enumerate();
    let mut of: Vec<_> = point.map(|(k, symbol)| (symbol, Kind::Length, coordinate(k), start[k] * length)).collect();
    of.push(("zero", Kind::Length, zero, 0.0));
    Target {
        name: name.into(),
        column: "anchor",
        member: (name.into(), None),
        observes: None,
        values: values(name, &of),
        has_start: near.is_some(),
    }
}

/// Members of the group of a contact, in the order in which the files name them; one without a name where it has none.
fn groups(contact: &RawContact, sources: &[Source]) -> Vec<Option<[String; 2]>> {
    let Some(column) = &contact.group else { return vec![None] };
    let mut members: Vec<String> = Vec::new();
    for source in sources {
        let texts = source.table.texts(column).map_or(&[][..], |texts| texts.texts());
        members.extend(texts.iter().filter(|text| !members.contains(text)).cloned().collect::<Vec<_>>());
    }
    members.into_iter().map(|member| Some([column.clone(), member])).collect()
}

fn contact(name: &str, raw: &RawContact, group: Option<[String; 2]>, length: f64) -> Target {
    use super::raw::Unknown;
    let unknown = OrUnknown::Unknown(Unknown::Unknown);
    let owner = group.as_ref().map_or_else(|| name.to_string(), |[_, member]| format!("{name}@{member}"));
    let at = raw.at.and_then(OrUnknown::known).map(|at| at.map(|v| v * length));
    let normal = raw.normal.and_then(OrUnknown::known);
    let radius = raw.radius.map(|radius| radius.known().map(|radius| radius * length));
    let or_unknown = |value: Option<f64>| value.map_or(unknown, OrUnknown::Known);
    let points = |symbols: [&'static str; 3], given: Option<[f64; 3]>, kind: Kind, start: [f64; 3]| {
        [0, 1, 2].map(|k| (symbols[k], kind, or_unknown(given.map(|given| given[k])), start[k]))
    };
    let centre = || points(["x", "y", "z"], at, Kind::Length, [0.0; 3]).to_vec();
    let (observes, of) = match raw.kind {
        ContactKind::Socket => (SOCKET, centre()),
        ContactKind::Sphere => {
            let mut of = centre();
            of.push(("radius", Kind::Length, or_unknown(radius.flatten()), 0.0));
            (SPHERE, of)
        }
        ContactKind::Plane => {
            let mut of = points(["nx", "ny", "nz"], normal, Kind::Other(""), [0.0, 0.0, 1.0]).to_vec();
            let along = at.zip(normal).map(|(at, n)| {
                let n = Vector3::from(n);
                n.dot(&Vector3::from(at)) / n.norm().max(f64::MIN_POSITIVE) + radius.flatten().unwrap_or(0.0)
            });
            of.push(("offset", Kind::Length, or_unknown(along), 0.0));
            (PLANE, of)
        }
    };
    let values = values(&owner, &of);
    Target {
        name: owner,
        column: "contact",
        member: (name.into(), group),
        observes: Some(observes),
        values,
        has_start: false,
    }
}

/// Distances between the contacts of each group; unknown ones are appended to the targets.
pub(super) fn constraints(
    raw: &RawCampaign,
    targets: &mut Vec<Target>,
    locate: Locate,
    diagnostics: &mut Vec<Diagnostic>,
) -> Vec<Constraint> {
    let mut constraints = Vec::new();
    for (key, &distance) in &raw.distances {
        let mut fault = |message: String, remedy: &str| {
            diagnostics.push(Diagnostic::error(message).at(locate(&["distances", key])).remedy(remedy));
        };
        let pair = key.match_indices('-').find_map(|(at, _)| {
            let (one, other) = (&key[..at], &key[at + 1..]);
            (raw.contacts.contains_key(one) && raw.contacts.contains_key(other)).then_some([one, other])
        });
        let Some([one, other]) = pair else {
            fault(format!("`{key}` names no two contacts"), "write `a-b: distance`, a and b as in `contacts`");
            continue;
        };
        if let Some(distance) = distance.known().filter(|distance| !(distance.is_finite() && *distance > 0.0)) {
            let remedy = "give it in the length unit, or write `unknown`";
            fault(format!("the distance `{distance}` must be a finite number above 0"), remedy);
            continue;
        }
        let of = |name: &str| -> Vec<(usize, &Target)> {
            targets.iter().enumerate().filter(|(_, target)| target.member.0 == name).collect()
        };
        let before = constraints.len();
        let length = distance.known().is_none().then_some(targets.len());
        for (i, first) in of(one) {
            for (j, _) in of(other).into_iter().filter(|(_, second)| second.member.1 == first.member.1) {
                let distance = distance.known().unwrap_or(0.0) * raw.units.length.factor();
                constraints.push(Constraint { targets: [i, j], distance, length, sigma: DISTANCE_SIGMA });
            }
        }
        if length.is_some() && constraints.len() > before {
            targets.push(Target::distance(key));
        }
        if constraints.len() == before && targets.iter().any(|target| target.column == "contact") {
            fault(format!("`{one}` and `{other}` are never in one group"), "give both the same `group:`");
        }
    }
    constraints
}
