//! What a description starts from: a URDF, or a chain of it, beneath what its own file says.

use std::collections::HashSet;
use std::path::{Component, Path, PathBuf};

use serde_json::Value;

use super::place::{BUNDLED, Place};
use super::reader::Reader;
use crate::description::coupling::parse_coupling;
use crate::description::raw::{JointKind, RawRobot, RawUrKinematics, RawUrdf};
use crate::description::ur_kinematics;
use crate::description::urdf::{self, Imported, Request};
use crate::description::yaml::Document;
use crate::diagnostic::{Diagnostic, Diagnostics, Locate, Place as Location};

/// What is reported in the place of a description, or together with one.
type Reported = Vec<Diagnostic>;

/// A URDF as a robot by itself; what concerns the whole of it is located at its start.
pub(super) fn whole_urdf(place: &Place, text: &str) -> Result<(RawRobot, Reported), Reported> {
    let name = place.name();
    let (mut robot, diagnostics) = urdf::import(&name, text).map_err(|mut reported| {
        let unplaced = reported.iter_mut().filter(|diagnostic| diagnostic.place.is_none());
        unplaced.for_each(|diagnostic| diagnostic.place = Some(Location::in_text(&name, text, 0..0)));
        reported
    })?;
    robot.urdf = Some(RawUrdf { file: Some(name), merged: true, ..RawUrdf::default() });
    Ok((robot, diagnostics))
}

/// A description with the URDF that it names beneath it. Its `urdf` then says so, with the file's path as the program
/// finds it.
pub(super) fn with_urdf(
    reader: &Reader,
    place: &Place,
    mut raw: RawRobot,
    document: &Document,
) -> Result<(RawRobot, Reported), Reported> {
    let Some(keys) = raw.urdf.take() else { return Ok((raw, Vec::new())) };
    let Some(file) = &keys.file else {
        if document.explains_absence(&["urdf", "file"]) {
            return Ok((raw, Vec::new()));
        }
        let diagnostic = Diagnostic::error("`urdf` names no file").at(document.place_of_key(&["urdf"]));
        return Err(vec![diagnostic.remedy("write `urdf: {file: arm.urdf, from: base_link, to: tool0}`")]);
    };
    let found = place.next_to(file);
    let kept = RawUrdf { file: Some(found.name()), merged: true, ..keys.clone() };
    if keys.merged {
        return Ok((RawRobot { urdf: Some(kept), ..raw }, Vec::new()));
    }
    let locate = |path: &[&str]| document.place_of_value(path);
    let weighed: Vec<&str> = raw.bodies.keys().map(String::as_str).collect();
    let request = Request { keys: &keys, units: raw.units, weighed: &weighed, locate: &locate };
    let imported = found.text(reader).and_then(|text| urdf::import_chain(&found.name(), &text, &request));
    let mut imported = imported.map_err(|reported| named_by(document, "urdf", reported))?;
    let reported = std::mem::take(&mut imported.diagnostics);
    if raw.tool.frame.is_none()
        && let Some(end) = &keys.to
    {
        // What has no frame of its own is in that of the link that carries the tool.
        if raw.tool != Default::default() {
            raw.tool.frame = Some(end.clone());
        }
        raw.markers.values_mut().for_each(|marker| _ = marker.frame.get_or_insert_with(|| end.clone()));
    }
    let strange = unknown_links(&imported, &raw, &locate);
    if !strange.is_empty() {
        return Err(strange);
    }
    add_links(&mut imported, &mut raw);
    Ok((RawRobot { urdf: Some(kept), ..merge(imported.robot, raw) }, reported))
}

/// Name and text of the URDF that a description came from, or why it cannot be read; `None` where it came from none.
///
/// # Errors
/// Why the file cannot be read.
pub fn source_urdf(robot: &RawRobot) -> Option<(String, Result<String, Diagnostics>)> {
    let name = robot.urdf.as_ref()?.file.clone()?;
    let place = match name.strip_prefix(BUNDLED) {
        Some(path) => Place::Bundled(path.into()),
        None => Place::Disk(name.clone().into()),
    };
    let text = place.text(&Reader::default()).map_err(Diagnostics::from);
    Some((name, text))
}

/// A description as it is written to the file `to`: from there the URDF that it came from has another path. Of a bundled
/// URDF, which has none, nothing is kept.
#[must_use]
pub fn moved_to(robot: &RawRobot, to: &Path) -> RawRobot {
    let mut robot = robot.clone();
    let file = robot.urdf.as_mut().and_then(|keys| keys.file.as_mut());
    if file.as_ref().is_some_and(|file| file.starts_with(BUNDLED)) {
        robot.urdf = None;
    } else if let Some(file) = file {
        let folder = to.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        if let (Ok(found), Ok(folder)) = (Path::new(&*file).canonicalize(), folder.canonicalize()) {
            let shared = found.components().zip(folder.components()).take_while(|(a, b)| a == b).count();
            let up = folder.components().skip(shared).map(|_| Component::ParentDir);
            let path: PathBuf = up.chain(found.components().skip(shared)).collect();
            // Of files that share no folder the whole path is the clearer name.
            *file = if shared > 1 { path } else { found }.display().to_string();
        }
    }
    robot
}

/// What a file that a description names under `key` could not be read for, at that key.
fn named_by(document: &Document, key: &str, mut reported: Reported) -> Reported {
    for diagnostic in reported.iter_mut().filter(|diagnostic| diagnostic.place.is_none()) {
        diagnostic.place = document.place_of_value(&[key]);
        diagnostic.remedy.get_or_insert_with(|| "paths are relative to the description that names them".into());
    }
    reported
}

/// A description with the file of kinematics that it names beneath it. Its `ur_kinematics` then holds the hash alone.
pub(super) fn with_ur_kinematics(
    reader: &Reader,
    place: &Place,
    mut raw: RawRobot,
    document: &Document,
) -> Result<(RawRobot, Reported), Reported> {
    let Some(keys) = raw.ur_kinematics.take() else { return Ok((raw, Vec::new())) };
    let Some(file) = &keys.file else { return Ok((RawRobot { ur_kinematics: Some(keys), ..raw }, Vec::new())) };
    if raw.urdf.is_some() {
        let diagnostic = Diagnostic::error("`ur_kinematics` and `urdf` both give frames");
        let diagnostic = diagnostic.at(document.place_of_key(&["ur_kinematics"]));
        return Err(vec![diagnostic.remedy("leave one of them out; a URDF is made of such a file by its own package")]);
    }
    let found = place.next_to(file);
    let text = found.text(reader).map_err(|reported| named_by(document, "ur_kinematics", reported))?;
    let (imported, reported) = ur_kinematics::read(&found.name(), &text)?;
    let hash = keys.hash.or_else(|| imported.ur_kinematics.as_ref()?.hash.clone());
    let kept = Some(RawUrKinematics { file: None, hash });
    Ok((RawRobot { ur_kinematics: kept, ..merge(imported, raw) }, reported))
}

/// Names of frames that are neither the description's nor those of a joint or a link of its URDF.
fn unknown_links(imported: &Imported, raw: &RawRobot, locate: Locate) -> Reported {
    let markers = raw.markers.iter().map(|(name, marker)| (vec!["markers", name, "frame"], marker.frame.as_ref()));
    let bodies = raw.bodies.keys().map(|name| (vec!["bodies", name], Some(name)));
    let named = markers.chain(bodies).chain([(vec!["tool", "frame"], raw.tool.frame.as_ref())]);
    let known = || raw.frames.keys().chain(imported.robot.frames.keys()).chain(imported.link_frames.keys());
    let strange = named.filter_map(|(path, name)| Some((path, name.filter(|name| *name != "0")?)));
    let strange = strange.filter(|(_, name)| known().all(|known| known != *name));
    let diagnostic = |(path, name): (Vec<&str>, &String)| {
        let message = format!("unknown frame `{name}`: neither a frame nor a link beyond `from`");
        Diagnostic::error(message).at(locate(&path)).suggest(name, known().map(String::as_str))
    };
    strange.map(diagnostic).collect()
}

/// Adds the frames of those links that the description names anywhere. Where they stand in their body is what they are:
/// nothing to calibrate.
fn add_links(imported: &mut Imported, raw: &mut RawRobot) {
    let mut named = HashSet::new();
    names(&serde_json::to_value(&*raw).unwrap_or_default(), &mut named);
    let links = std::mem::take(&mut imported.link_frames).into_iter();
    for (name, frame) in links.filter(|(name, _)| named.contains(name)) {
        // A joint has the name.
        if imported.robot.frames.contains_key(&name) {
            continue;
        }
        let given = raw.frames.contains_key(&name);
        if !given {
            let symbols = ["beta", "alpha", "d", "r"].map(|symbol| format!("{name}.{symbol}"));
            raw.calibration.fixed.extend(symbols.into_iter().filter(|name| !raw.calibration.free.contains(name)));
        }
        imported.robot.frames.insert(name, frame);
    }
}

/// Every text of a value, its keys too, and what stands behind the colon of a site (`link:forearm`).
fn names(value: &Value, found: &mut HashSet<String>) {
    match value {
        Value::String(text) => {
            found.extend(text.split(':').map(str::to_owned));
            found.insert(text.clone());
        }
        Value::Array(list) => list.iter().for_each(|value| names(value, found)),
        Value::Object(entries) => entries.iter().for_each(|(key, value)| {
            found.insert(key.clone());
            names(value, found);
        }),
        _ => {}
    }
}

/// A description in YAML laid over what a URDF gave: single keys of a frame override, whole entries elsewhere.
fn merge(imported: RawRobot, over: RawRobot) -> RawRobot {
    let (length, angle) = (over.units.length.factor(), over.units.angle.factor());
    let mut merged = over.clone();
    let mut frames = imported.frames;
    for frame in frames.values_mut() {
        // From SI into the units of the file that is merged in.
        let joint_unit = if frame.joint == Some(JointKind::Prismatic) { length } else { angle };
        for value in [&mut frame.beta, &mut frame.gamma, &mut frame.alpha, &mut frame.theta].into_iter().flatten() {
            *value /= angle;
        }
        for value in [&mut frame.b, &mut frame.d, &mut frame.r].into_iter().flatten() {
            *value /= length;
        }
        frame.offset = frame.offset.map(|v| v / joint_unit);
        frame.limits = frame.limits.map(|limits| limits.map(|v| v / joint_unit));
    }
    for (name, given) in over.frames {
        let frame = frames.entry(name).or_default();
        macro_rules! take { ($($key:ident),*) => { $(if given.$key.is_some() { frame.$key = given.$key; })* } }
        take!(antecedent, joint, variable, direction, coaxial, beta, gamma, b, alpha, d, theta, r, offset, limits);
        frame.passive |= given.passive;
    }
    merged.robot = over.robot.or(imported.robot);
    merged.gravity = over.gravity.or(imported.gravity);
    if over.tool == Default::default() {
        merged.tool = imported.tool;
        merged.tool.at = merged.tool.at.map(|at| at.map(|v| v / length));
        merged.tool.rotation = merged.tool.rotation.map(|r| r.map(|v| v / angle));
    }
    let prismatic = |name: &str| frames.get(name).is_some_and(|frame| frame.joint == Some(JointKind::Prismatic));
    let unit = |name: &str| if prismatic(name) { length } else { angle };
    let mut couplings: Vec<String> = imported
        .couplings
        .into_iter()
        .map(|coupling| match parse_coupling(&coupling) {
            // A slide that follows a turn, or a turn that follows a slide.
            Ok((name, terms)) if terms.iter().any(|(_, master)| prismatic(master) != prismatic(name)) => {
                let terms =
                    terms.iter().map(|(factor, master)| format!("{} * {master}", factor * unit(master) / unit(name)));
                // Of an imported file, which knows mechanisms only.
                format!("{name} = {}", terms.collect::<Vec<_>>().join(" + "))
            }
            _ => coupling,
        })
        .collect();
    couplings.extend(over.couplings);
    (merged.couplings, merged.frames) = (couplings, frames);
    for (name, mut body) in imported.bodies {
        body.mass = body.mass.map(|mass| mass / over.units.mass.factor());
        body.com = body.com.map(|com| com.map(|v| v / length));
        merged.bodies.entry(name).or_insert(body);
    }
    merged
}
