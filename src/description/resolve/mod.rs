//! Raw -> resolved: names to indices, units to SI, and every fault of the file reported in one run.

mod calibration;
mod collector;
mod couplings;
mod drivers;
mod elastic;
mod elastic_values;
mod fuzzy;
mod keep_out;
mod limits;
mod loops;
mod motion;
mod payload;
mod sizes;
mod tree;
mod validity;

pub use crate::diagnostic::{Explained, Locate};
pub use collector::GREATEST;
pub use payload::{no_mass, payloads};
pub use sizes::{doubtful_sizes, doubtful_urdf, heaviest};

use indexmap::IndexMap;

use super::columns::{OWNERS, TOOL_POINT};
use super::convention::khalil_kleinfinger;
use super::frame::FrameIndex;
use super::parameters::{Owner, parameters};
use super::raw::{RawPlacement, RawRobot};
use super::robot::{Marker, Placement, Robot, Tool};
use super::units::Units;
use crate::diagnostic::Diagnostic;
use collector::Collector;
use tree::Tree;

/// Resolves a raw description. The robot is `None` when any diagnostic is an error.
pub fn resolve(raw: &RawRobot, locate: Locate) -> (Option<Robot>, Vec<Diagnostic>) {
    resolve_explained(raw, locate, &|_| false)
}

/// As [`resolve`], of a description some entries of which were left out as faulty: what is missing through them is not
/// reported again.
pub fn resolve_explained(raw: &RawRobot, locate: Locate, explained: Explained) -> (Option<Robot>, Vec<Diagnostic>) {
    let mut diagnostics = Collector::new(locate, explained);
    let (written, faults) = khalil_kleinfinger(raw, locate, explained);
    diagnostics.diagnostics.extend(faults);
    let raw = &written;
    let mut tree = tree::resolve(raw, &mut diagnostics);
    gear_ratios(raw, &mut tree, &mut diagnostics);
    let names: Vec<String> = tree.frames.iter().map(|frame| frame.name.clone()).collect();
    let tool = tool(raw, &tree, &names, &mut diagnostics);
    let length = raw.units.length.factor();
    let markers = raw.markers.iter().map(|(name, marker)| Marker {
        name: name.clone(),
        frame: frame_of(&["markers", name, "frame"], marker.frame.as_deref(), &names, tool.frame, &mut diagnostics),
        position: diagnostics.vector(&["markers", name, "at"], marker.at, length),
    });
    let markers = markers.collect();
    let base = placement(&mut diagnostics, "base", &raw.base, &raw.units);
    let anchor =
        |(name, at): (&String, &[f64; 3])| (name.clone(), diagnostics.vector(&["anchors", name], Some(*at), length));
    let anchors = raw.anchors.iter().map(anchor).collect();
    unique_owners(raw, &mut diagnostics);
    unique_parameters(raw, &mut diagnostics);
    elastic::validate(raw, &names, &mut diagnostics);
    let calibration = calibration::resolve(raw, &mut diagnostics);
    let (fuzzy, spring_rules) = fuzzy::resolve(raw, &tree, &mut diagnostics);
    let limits = limits::resolve(raw, &tree, &mut diagnostics);
    let keep_out = keep_out::resolve(raw, &mut diagnostics);
    validity::validate(raw, &tree, &mut diagnostics);
    for (name, _) in raw.payloads.iter().filter(|(_, payload)| payload.mass.is_none()) {
        let message = payload::no_mass(name);
        if let Some(found) = diagnostics.lacking(&["payloads", name], "mass", message) {
            found.remedy = Some("add `mass: ...`".into());
        }
    }
    if diagnostics.diagnostics.iter().any(Diagnostic::is_error) {
        return (None, diagnostics.diagnostics);
    }
    let mut robot = Robot {
        name: raw.robot.clone().unwrap_or_else(|| "robot".into()),
        elastic: elastic_values::resolve(raw, &tree),
        variables: tree.variables,
        frames: tree.frames,
        couplings: tree.couplings,
        loops: tree.loops,
        limits,
        keep_out,
        actuators: tree.actuators,
        base,
        tool,
        markers,
        anchors,
        payloads: Vec::new(),
        effects: raw.effects.clone(),
        fuzzy,
        spring_rules,
        calibration,
    };
    robot.payloads = payload::payloads(&raw.payloads, &raw.units, &robot, locate, &mut diagnostics.diagnostics);
    let is_sound = !diagnostics.diagnostics.iter().any(Diagnostic::is_error);
    (is_sound.then_some(robot), diagnostics.diagnostics)
}

/// Gear ratios as declared; those of no variable, and those that are none, are reported.
fn gear_ratios(raw: &RawRobot, tree: &mut Tree, diagnostics: &mut Collector) {
    for (name, ratio) in &raw.gear_ratios {
        let path = ["gear_ratios", name.as_str()];
        match tree.variables.iter_mut().find(|variable| variable.name == *name) {
            Some(variable) if ratio.is_finite() && *ratio > 0.0 => variable.gear_ratio = Some(*ratio),
            Some(_) => diagnostics.reject(
                &path,
                format!("{ratio} is no gear ratio"),
                "give the turns of the motor in a turn of the joint, above 0",
            ),
            None => diagnostics.unknown(&path, "variable", name, tree.variables.iter().map(|v| v.name.as_str())),
        }
    }
}

/// The frame of a name, or the default where none is given or it is unknown.
fn frame_of(
    path: &[&str],
    given: Option<&str>,
    names: &[String],
    default: FrameIndex,
    diagnostics: &mut Collector,
) -> FrameIndex {
    let Some(name) = given else { return default };
    names.iter().position(|known| known == name).unwrap_or_else(|| {
        diagnostics.unknown(path, "frame", name, names.iter().map(String::as_str));
        default
    })
}

/// The tool: in the frame declared, or in the only frame that carries nothing.
fn tool(raw: &RawRobot, tree: &Tree, names: &[String], diagnostics: &mut Collector) -> Tool {
    let frames = &tree.frames;
    let in_loop = |name: &str| raw.loops.values().any(|l| l.frames.iter().flatten().any(|known| known == name));
    let leaves: Vec<FrameIndex> = (1..frames.len())
        .filter(|&i| frames.iter().skip(1).all(|frame| frame.antecedent != i) && !in_loop(&frames[i].name))
        .collect();
    let unclear = ["frames", "loops", "tool"].iter().any(|section| diagnostics.explained(&[section]))
        || diagnostics.explained(&["tool", "frame"])
        || raw.frames.keys().any(|name| diagnostics.explained(&["frames", name, "antecedent"]))
        || raw.loops.keys().any(|name| diagnostics.explained(&["loops", name, "frames"]))
        || diagnostics.antecedents_failed;
    if raw.tool.frame.is_none() && leaves.len() != 1 && frames.len() > 1 && !unclear {
        let choices: Vec<&str> = leaves.iter().map(|&i| names[i].as_str()).collect();
        let choices = if choices.is_empty() { String::new() } else { format!(", one of {}", choices.join(", ")) };
        let message = format!("the tool's frame is not clear: {} frames carry nothing", leaves.len());
        diagnostics.reject(&["tool"], message, format!("add `tool: {{frame: ...}}`{choices}"));
    }
    let default = leaves.first().copied().unwrap_or(frames.len() - 1);
    let frame = frame_of(&["tool", "frame"], raw.tool.frame.as_deref(), names, default, diagnostics);
    let given = RawPlacement { at: raw.tool.at, rotation: raw.tool.rotation };
    Tool { frame, placement: placement(diagnostics, "tool", &given, &raw.units) }
}

fn placement(diagnostics: &mut Collector, owner: &str, raw: &RawPlacement, units: &Units) -> Placement {
    Placement {
        position: diagnostics.vector(&[owner, "at"], raw.at, units.length.factor()),
        rotation: diagnostics.vector(&[owner, "rotation"], raw.rotation, units.angle.factor()),
    }
}

/// A parameter is named `<owner>.<symbol>`, so no two owners may share a name, whatever they are.
fn unique_owners(raw: &RawRobot, diagnostics: &mut Collector) {
    let sections: [(&str, Vec<&String>); 6] = [
        ("materials", raw.materials.keys().collect()),
        ("sections", raw.sections.keys().collect()),
        ("frames", raw.frames.keys().collect()),
        ("actuators", raw.actuators.keys().collect()),
        ("markers", raw.markers.keys().collect()),
        ("springs", raw.springs.keys().collect()),
    ];
    let mut seen: Vec<(&str, &str)> = Vec::new();
    for (section, names) in &sections {
        for &name in names {
            let path = [section, name.as_str()];
            if !name.chars().all(|c| c.is_alphanumeric() || "_'-/".contains(c)) || name.is_empty() {
                diagnostics.reject(
                    &path,
                    format!("`{name}` cannot be a name"),
                    "use letters, digits, `_`, `-`, `/` and `'`",
                );
            }
            if OWNERS.contains(&name.as_str()) {
                diagnostics.reject(&path, format!("`{name}` is a reserved name"), "choose another");
            } else if *section == "markers" && TOOL_POINT.contains(&name.as_str()) {
                let message = format!("a marker `{name}` would be taken for the tool's own point");
                diagnostics.reject(
                    &path,
                    message,
                    "choose another name; where it is the tool's point, place `tool:` there",
                );
            }
            if let Some((other, _)) = seen.iter().find(|(_, known)| known == name) {
                let message = format!("`{name}` names two things, and parameters are known by name");
                let first = [*other, name.as_str()];
                let is_link = *section == "markers" && *other == "frames" && raw.urdf.is_some();
                let remedy = match is_link {
                    true => {
                        "leave the marker out here, if the URDF holds it as a link (as one that `convert` wrote does); else give it another name"
                    }
                    false => "give one of them another name",
                };
                diagnostics.conflict(&path, message, &first, "already named here", remedy);
            }
            seen.push((section, name));
        }
    }
}

/// No two parameters may have one name: a marker `body6` has a `body6.x`, and so has the body of frame `6`.
fn unique_parameters(raw: &RawRobot, diagnostics: &mut Collector) {
    let mut owners: IndexMap<String, Owner> = IndexMap::new();
    let mut refused: Vec<[Owner; 2]> = Vec::new();
    for key in parameters(raw) {
        match owners.get(&key.name) {
            Some(&first) if first != key.owner && !refused.contains(&[first, key.owner]) => {
                refused.push([first, key.owner]);
                let message = format!("two parameters would be called `{}`", key.name);
                let why = "the other one belongs to this";
                diagnostics.conflict(&key.owner.path(), message, &first.path(), why, "rename one of the two");
            }
            Some(_) => {}
            None => {
                owners.insert(key.name, key.owner);
            }
        }
    }
}
