//! What the readings of a campaign file refer to, from its `anchors:`, `contacts:` and `distances:`.

use std::f64::consts::PI;

use nalgebra::Vector3;

use super::raw::{ContactKind, OrUnknown, RawAnchor, RawCampaign, RawContact};
use super::sessions::{SESSION, STATION};
use super::source::Source;
use super::targets::{Between, Constraint, Target, TargetValue};
use crate::description::resolve::Locate;
use crate::description::robot::Robot;
use crate::diagnostic::Diagnostic;
use crate::observation::{ANCHOR_COLUMN, CONTACT_COLUMN, Observes, PLANE, SOCKET, SPHERE};
use crate::parameter::Kind;

/// One sigma of a distance that is stated as known, m: what a drilled or measured plate keeps.
const DISTANCE_SIGMA: f64 = 1e-5;
/// One sigma of an angle that is stated as known, rad: squares of grade 0 keep 7 um over 100 mm (DIN 875-1).
const ANGLE_SIGMA: f64 = 7e-5;
/// Least angle of two faces, and of what lacks to a half turn, rad: below it the direction of their edge is none.
const LEAST_ANGLE: f64 = 0.0174;

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
    let length = raw.units.length.factor();
    let mut targets = Vec::new();
    if kinds.iter().any(|kind| kind.needs_anchor()) {
        let own = robot.anchors.iter().filter(|(name, _)| !raw.anchors.contains_key(*name));
        targets.extend(own.map(|(name, at)| Target::anchor(name, at)));
        targets.extend(raw.anchors.iter().map(|(name, own)| anchor(name, own, length)));
    }
    if kinds.iter().any(|kind| kind.touches()) {
        for (name, own) in &raw.contacts {
            let members = groups(own, sources);
            // Where a contact is faulty no file is read.
            let is_read = !sources.is_empty() || raw.contacts.values().all(|contact| contact.kind.is_some());
            diagnostics.extend(own.group.as_ref().filter(|_| members.is_empty() && is_read).map(|column| {
                let message =
                    format!("the contact `{name}` is one of a group by the column `{column}`, which names none");
                let key = if [SESSION, STATION].contains(&column.as_str()) {
                    format!(" or `{column}:` to their entry in `measurements:`")
                } else {
                    String::new()
                };
                let remedy = format!("add the column `{column}` to the readings{key}, or leave `group:` out");
                Diagnostic::error(message).at(locate(&["contacts", name, "group"])).remedy(remedy)
            }));
            targets.extend(members.into_iter().map(|group| contact(name, own, group, length)));
        }
    }
    diagnostics.extend(named_as_parts(&targets, robot, locate));
    diagnostics.extend(lacking(&targets, raw, kinds, locate));
    targets
}

/// Unknown targets whose parameters would have the names of those of a part of the robot.
fn named_as_parts(targets: &[Target], robot: &Robot, locate: Locate) -> Vec<Diagnostic> {
    let is_taken = |target: &&Target| {
        let owner = target.name.as_str();
        let is_owner = robot.markers.iter().any(|marker| marker.name == owner)
            || robot.frames.iter().any(|frame| frame.name == owner)
            || ["base", "tool"].contains(&owner);
        target.is_estimated() && is_owner
    };
    let fault = |target: &Target| {
        let key = format!("{}s", target.column);
        let message = format!(
            "{} `{}` has the name of a part of the robot, and its parameters would too",
            target.column, target.name
        );
        Diagnostic::error(message).at(locate(&[&key, &target.name])).remedy("name it otherwise")
    };
    targets.iter().filter(is_taken).map(fault).collect()
}

/// Kinds of readings that refer to something of which nothing is declared.
fn lacking(targets: &[Target], raw: &RawCampaign, kinds: &[Observes], locate: Locate) -> Vec<Diagnostic> {
    let at = || locate(&["observes"]);
    let from_anchor = kinds.iter().find(|kind| kind.needs_anchor()).filter(|_| !targets.iter().any(Target::is_anchor));
    let no_anchor = from_anchor.map(|kind| {
        let message = format!("{}s are measured from a fixed anchor, and none is declared", kind.name());
        let remedy =
            "add `anchors: {name: [x, y, z]}`, in the measurement frame; `{at: unknown}` where it is not known";
        Diagnostic::error(message).at(at()).remedy(remedy)
    });
    let touches = kinds.iter().any(|kind| kind.touches());
    let no_contact = (touches && raw.contacts.is_empty()).then(|| {
        let remedy = "add `contacts: {name: {kind: socket}}` (or plane, sphere)";
        Diagnostic::error("contacts are observed, and none is declared").at(at()).remedy(remedy)
    });
    let has_scale = !kinds.is_empty() && kinds.iter().all(|kind| kind.touches()) && raw.estimate.scale.0.is_some();
    let no_instrument = has_scale.then(|| {
        let remedy = "leave it out: the size comes from known `distances:` between contacts, or from the description";
        Diagnostic::error("contacts are read by no instrument whose scale could be estimated")
            .at(locate(&["estimate", "scale"]))
            .remedy(remedy)
    });
    no_anchor.into_iter().chain(no_contact).chain(no_instrument).collect()
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
        column: ANCHOR_COLUMN,
        member: (name.into(), None),
        observes: None,
        values: values(name, &of),
        has_start: near.is_some(),
        is_near: near.is_some(),
    }
}

/// Members of the group of a contact, in the order in which the files name them; one without a name where it has none.
fn groups(contact: &RawContact, sources: &[Source]) -> Vec<Option<[String; 2]>> {
    let Some(column) = &contact.group else { return vec![None] };
    let mut members: Vec<String> = Vec::new();
    for source in sources {
        let texts: Vec<&str> = match source.table.texts(column) {
            Some(texts) => texts.texts().iter().map(String::as_str).collect(),
            None => source.entry.named(column).into_iter().collect(),
        };
        for text in texts {
            if !text.is_empty() && !members.iter().any(|known| known == text) {
                members.push(text.to_owned());
            }
        }
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
    let near = raw.near.unwrap_or_default().map(|v| v * length);
    let centre = || points(["x", "y", "z"], at, Kind::Length, near).to_vec();
    // One without a kind is refused; until then it is what asks for nothing.
    let (observes, of) = match raw.kind.unwrap_or(ContactKind::Socket) {
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
            let normal = normal.map_or_else(Vector3::z, Vector3::from);
            let start = normal.dot(&Vector3::from(near)) / normal.norm().max(f64::MIN_POSITIVE);
            of.push(("offset", Kind::Length, or_unknown(along), start));
            (PLANE, of)
        }
    };
    let values = values(&owner, &of);
    Target {
        name: owner,
        column: CONTACT_COLUMN,
        member: (name.into(), group),
        observes: Some(observes),
        values,
        has_start: false,
        is_near: raw.near.is_some(),
    }
}

/// Distances and angles between the contacts of each group; unknown ones are appended to the targets.
pub(super) fn constraints(
    raw: &RawCampaign,
    targets: &mut Vec<Target>,
    locate: Locate,
    diagnostics: &mut Vec<Diagnostic>,
) -> Vec<Constraint> {
    let between = |key: &String| match faces(raw, key) {
        true => Between::Faces,
        false => Between::Points,
    };
    let distances = raw.distances.iter().map(|(key, value)| (between(key), key, *value));
    let angles = raw.angles.iter().map(|(key, value)| (Between::Normals, key, OrUnknown::Known(*value)));
    let mut constraints = Vec::new();
    for (between, key, value) in distances.chain(angles) {
        match constraint(raw, targets, between, key, value) {
            Ok((own, unknown)) => {
                diagnostics
                    .extend(contradicted(raw, targets, &own).map(|fault| fault.at(locate(&[list(between), key]))));
                let parallel = own.iter().filter(|constraint| constraint.between == Between::Faces);
                parallel.for_each(|constraint| Target::make_parallel(targets, constraint.targets));
                constraints.extend(own);
                targets.extend(unknown);
            }
            Err((message, remedy)) => {
                diagnostics.push(Diagnostic::error(message).at(locate(&[list(between), key])).remedy(remedy));
            }
        }
    }
    if !diagnostics.iter().any(Diagnostic::is_error) {
        diagnostics.extend(unreachable(raw, locate));
    }
    constraints
}

/// The key that lists a constraint.
fn list(between: Between) -> &'static str {
    if between == Between::Normals { "angles" } else { "distances" }
}

/// A known distance of points that are known, and farther apart or nearer.
fn contradicted(raw: &RawCampaign, targets: &[Target], constraints: &[Constraint]) -> Option<Diagnostic> {
    let point = |target: usize| {
        let values = targets[target].values.get(..3)?;
        let is_known = values.iter().all(|value| value.parameter.is_none());
        is_known.then(|| Vector3::from_fn(|k, _| values[k].value))
    };
    let is_of_points = |own: &&Constraint| own.between == Between::Points && own.length.is_none();
    constraints.iter().filter(is_of_points).find_map(|own| {
        let [a, b] = own.targets.map(point);
        let apart = (a? - b?).norm();
        let length = raw.units.length.factor();
        let message =
            format!("the distance is {}, and the points given are {:.4} apart", own.value / length, apart / length);
        let remedy = "correct one of them, or leave the distance out: the points say it";
        ((apart - own.value).abs() > 3.0 * own.sigma).then(|| Diagnostic::error(message).remedy(remedy))
    })
}

/// Known distances that are longer than a way along others.
fn unreachable(raw: &RawCampaign, locate: Locate) -> Vec<Diagnostic> {
    let length = raw.units.length.factor();
    let names: Vec<&String> = raw.contacts.keys().collect();
    let at = |name: &str| names.iter().position(|known| *known == name);
    let known: Vec<(&String, [usize; 2], f64)> = raw
        .distances
        .iter()
        .filter(|(key, _)| !faces(raw, key))
        .filter_map(|(key, value)| {
            let [(one, _), (other, _)] = pair(raw, key)?;
            Some((key, [at(one)?, at(other)?], value.known()? * length))
        })
        .collect();
    let count = names.len();
    let mut shortest = vec![vec![f64::INFINITY; count]; count];
    for &(_, [a, b], distance) in &known {
        shortest[a][b] = distance.min(shortest[a][b]);
        shortest[b][a] = shortest[a][b];
    }
    // Floyd and Warshall.
    for via in 0..count {
        for a in 0..count {
            for b in 0..count {
                shortest[a][b] = shortest[a][b].min(shortest[a][via] + shortest[via][b]);
            }
        }
    }
    let is_too_long =
        |(_, [a, b], distance): &&(&String, [usize; 2], f64)| *distance > shortest[*a][*b] + 3.0 * DISTANCE_SIGMA;
    let fault = |(key, [a, b], distance): &(&String, [usize; 2], f64)| {
        let message = format!(
            "`{key}`: {} is longer than the way along other known distances, {}",
            distance / length,
            shortest[*a][*b] / length
        );
        Diagnostic::error(message)
            .at(locate(&["distances", key]))
            .remedy("measure these distances again, or write `unknown`")
    };
    known.iter().filter(is_too_long).map(fault).collect()
}

/// The two contacts that a key `a-b` names.
fn pair<'r>(raw: &'r RawCampaign, key: &'r str) -> Option<[(&'r str, &'r RawContact); 2]> {
    key.match_indices('-').find_map(|(at, _)| {
        let (one, other) = (&key[..at], &key[at + 1..]);
        Some([(one, raw.contacts.get(one)?), (other, raw.contacts.get(other)?)])
    })
}

/// Whether a key names two faces.
fn faces(raw: &RawCampaign, key: &str) -> bool {
    pair(raw, key).is_some_and(|both| both.iter().all(|(_, contact)| contact.kind == Some(ContactKind::Plane)))
}

/// Sum of the radii (m) of the balls on two faces at a known distance: a ball's centre is at its radius outside of its face.
fn radii(
    raw: &RawCampaign,
    key: &str,
    faces: [(&str, &RawContact); 2],
    distance: OrUnknown<f64>,
) -> Result<f64, (String, String)> {
    if distance.known().is_none() {
        let remedy = "leave the entry out where it is not known";
        return Err((format!("`{key}`: the distance of two faces must be known"), remedy.into()));
    }
    let mut radii = 0.0;
    for (name, face) in faces {
        let Some(radius) = face.radius.and_then(OrUnknown::known) else {
            let message =
                format!("`{key}`: the radius of the ball on `{name}` is not known, and its faces' distance needs it");
            return Err((message, format!("give `radius:` of `{name}`, the ball's")));
        };
        radii += radius * raw.units.length.factor();
    }
    Ok(radii)
}

/// A distance (m) or an angle (rad) as given; what is wrong with it, and a remedy.
fn in_range(raw: &RawCampaign, between: Between, given: f64) -> Result<f64, (String, String)> {
    if between == Between::Normals {
        let angle = given * raw.units.angle.factor();
        let remedy = "give it in the angle unit; parallel faces have no angle to fit";
        return match (LEAST_ANGLE..=PI - LEAST_ANGLE).contains(&angle) {
            true => Ok(angle),
            false => Err((format!("the angle `{given}` must be between 1 and 179 deg"), remedy.into())),
        };
    }
    let distance = given * raw.units.length.factor();
    let remedy = "give it in the length unit, or write `unknown`";
    match distance.is_finite() && distance > 0.0 {
        true => Ok(distance),
        false => Err((format!("the distance `{given}` must be a finite number above 0"), remedy.into())),
    }
}

/// Whether a key names these two contacts, in either order.
fn is_of_pair(raw: &RawCampaign, key: &str, [one, other]: [&str; 2]) -> bool {
    pair(raw, key).is_some_and(|[(a, _), (b, _)]| [a, b] == [one, other] || [b, a] == [one, other])
}

/// What is wrong with an entry of one contact, or of two for which an entry before it stands; and a remedy.
fn once(
    raw: &RawCampaign,
    between: Between,
    key: &str,
    [one, other]: [&str; 2],
    what: &str,
) -> Result<(), (String, String)> {
    if one == other {
        return Err((format!("`{key}` names one contact twice"), format!("write `a-b: {what}` of two contacts")));
    }
    let list: Vec<&String> = match between {
        Between::Normals => raw.angles.keys().collect(),
        _ => raw.distances.keys().collect(),
    };
    let mut before = list.into_iter().take_while(|known| *known != key);
    match before.find(|known| is_of_pair(raw, known, [one, other])) {
        Some(again) => Err((format!("`{key}` is the {what} that `{again}` gives"), "leave one of the two out".into())),
        None => Ok(()),
    }
}

/// One entry of `distances:` or `angles:` in each group, and the target that holds it if it is unknown; what is wrong with it,
/// and a remedy.
fn constraint(
    raw: &RawCampaign,
    targets: &[Target],
    between: Between,
    key: &str,
    value: OrUnknown<f64>,
) -> Result<(Vec<Constraint>, Option<Target>), (String, String)> {
    let what = if between == Between::Normals { "angle" } else { "distance" };
    let Some([(one, first), (other, second)]) = pair(raw, key) else {
        return Err((
            format!("`{key}` names no two contacts"),
            format!("write `a-b: {what}`, a and b as in `contacts`"),
        ));
    };
    once(raw, between, key, [one, other], what)?;
    let is_same_pair = |known: &String| is_of_pair(raw, known, [one, other]);
    let is_plane = |contact: &RawContact| contact.kind == Some(ContactKind::Plane);
    if is_plane(first) != is_plane(second) || between == Between::Normals && !is_plane(first) {
        let shapes = if between == Between::Normals { "planes" } else { "sockets or spheres, or two planes" };
        let remedy =
            "`distances:` are between sockets or spheres, or between parallel planes; `angles:` between planes";
        return Err((format!("`{key}`: a known {what} is between two {shapes}"), remedy.into()));
    }
    if between == Between::Faces && raw.angles.keys().any(is_same_pair) {
        let remedy = "leave one of the two out: a distance is that of parallel faces";
        return Err((format!("`{key}`: faces at an angle have no distance, and `angles:` gives one"), remedy.into()));
    }
    let radii = match between {
        Between::Faces => radii(raw, key, [(one, first), (other, second)], value)?,
        _ => 0.0,
    };
    let sigma = if between == Between::Normals { ANGLE_SIGMA } else { DISTANCE_SIGMA };
    let known = value.known().map(|given| in_range(raw, between, given)).transpose()?;
    let of = |name: &str| -> Vec<(usize, &Target)> {
        targets.iter().enumerate().filter(|(_, target)| target.member.0 == name).collect()
    };
    let (of_one, of_other) = (of(one), of(other));
    let length = known.is_none().then_some(targets.len());
    let mut constraints = Vec::new();
    for (i, first) in of_one {
        for (j, _) in of_other.iter().filter(|(_, second)| second.member.1 == first.member.1) {
            let value = known.map_or(0.0, |value| value + radii);
            let targets = [i, *j];
            constraints.push(Constraint { targets, between, value, length, sigma });
        }
    }
    if constraints.is_empty() && targets.iter().any(Target::is_contact) {
        return Err((format!("`{one}` and `{other}` are never in one group"), "give both the same `group:`".into()));
    }
    let unknown = length.filter(|_| !constraints.is_empty()).map(|_| Target::distance(key));
    Ok((constraints, unknown))
}
