//! Raw -> resolved: names to indices, units to SI, and every fault of the file reported in one run.

mod calibration;
mod collector;
mod elastic;
mod elastic_values;
mod fuzzy;
mod motion;
mod sizes;
mod tree;

pub use collector::{Explained, GREATEST, Locate};
pub use sizes::doubtful_sizes;

use super::elastic::Elastic;
use super::raw::{RawPlacement, RawRobot};
use super::robot::{Marker, Placement, Robot, Tool};
use super::units::Units;
use crate::diagnostic::Diagnostic;
use collector::Collector;

/// Resolves a raw description. The robot is `None` when any diagnostic is an error.
pub fn resolve(raw: &RawRobot, locate: Locate) -> (Option<Robot>, Vec<Diagnostic>) {
    resolve_explained(raw, locate, &|_| false)
}

/// As [`resolve`], of a description some entries of which were set aside as faulty: what is missing through them is not
/// told again.
pub fn resolve_explained(raw: &RawRobot, locate: Locate, explained: Explained) -> (Option<Robot>, Vec<Diagnostic>) {
    let mut diagnostics = Collector::new(locate, explained);
    let units = &raw.units;
    let tree = tree::resolve(raw, &mut diagnostics);
    let name = raw.robot.clone().unwrap_or_else(|| "robot".into());
    let frames = &tree.frames;
    let frame_named = |name: &str| frames.iter().position(|frame| frame.name == name);
    let names: Vec<String> = frames.iter().map(|frame| frame.name.clone()).collect();
    let placed = |diagnostics: &mut Collector, path: &[&str], given: &Option<String>, default: usize| match given {
        None => default,
        Some(name) => frame_named(name).unwrap_or_else(|| {
            diagnostics.unknown(path, "frame", name, names.iter().map(String::as_str));
            default
        }),
    };

    let leaves: Vec<usize> = (1..frames.len())
        .filter(|&i| frames.iter().skip(1).all(|frame| frame.antecedent != i))
        .filter(|&i| !raw.loops.values().any(|l| l.frames.iter().flatten().any(|name| *name == frames[i].name)))
        .collect();
    let last = frames.len() - 1;
    let placed_faultily = ["frames", "loops", "tool"].iter().any(|section| diagnostics.explained(&[section]))
        || diagnostics.explained(&["tool", "frame"])
        || raw.frames.keys().any(|name| diagnostics.explained(&["frames", name, "antecedent"]))
        || raw.loops.keys().any(|name| diagnostics.explained(&["loops", name, "frames"]))
        || diagnostics.antecedents_failed;
    if raw.tool.frame.is_none() && leaves.len() != 1 && frames.len() > 1 && !placed_faultily {
        let choices: Vec<&str> = leaves.iter().map(|&i| frames[i].name.as_str()).collect();
        diagnostics
            .error(&["tool"], format!("the tool's frame is not clear: {} frames carry nothing", leaves.len()))
            .remedy
            .replace(format!(
                "add `tool: {{frame: ...}}`{}",
                if choices.is_empty() { String::new() } else { format!(", one of {}", choices.join(", ")) }
            ));
    }
    let tool_frame =
        placed(&mut diagnostics, &["tool", "frame"], &raw.tool.frame, leaves.first().copied().unwrap_or(last));
    let tool_placement = RawPlacement { at: raw.tool.at, rotation: raw.tool.rotation };
    let tool = Tool { frame: tool_frame, placement: placement(&mut diagnostics, "tool", &tool_placement, units) };
    let markers = raw
        .markers
        .iter()
        .map(|(name, marker)| Marker {
            name: name.clone(),
            frame: placed(&mut diagnostics, &["markers", name, "frame"], &marker.frame, tool_frame),
            position: diagnostics.vector(&["markers", name, "at"], marker.at, units.length.factor()),
        })
        .collect();
    let base = placement(&mut diagnostics, "base", &raw.base, units);
    let anchors = raw
        .anchors
        .iter()
        .map(|(name, at)| (name.clone(), diagnostics.vector(&["anchors", name], Some(*at), units.length.factor())))
        .collect();
    unique_owners(raw, &mut diagnostics);
    elastic::validate(raw, &names, &mut diagnostics);
    let calibration = calibration::resolve(raw, &mut diagnostics);
    let fuzzy = fuzzy::resolve(raw, &tree, &mut diagnostics);
    let failed = diagnostics.diagnostics.iter().any(Diagnostic::is_error);
    let elastic = if failed { Elastic::default() } else { elastic_values::resolve(raw, &tree) };
    let robot = Robot {
        name,
        variables: tree.variables,
        frames: tree.frames,
        couplings: tree.couplings,
        loops: tree.loops,
        actuators: tree.actuators,
        base,
        tool,
        markers,
        anchors,
        elastic,
        effects: raw.effects.clone(),
        fuzzy,
        calibration,
    };
    (if failed { None } else { Some(robot) }, diagnostics.diagnostics)
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
                diagnostics.error(&path, format!("`{name}` cannot be a name")).remedy =
                    Some("use letters, digits, `_`, `-`, `/` and `'`".into());
            }
            if matches!(name.as_str(), "base" | "tool" | "instrument") {
                diagnostics.error(&path, format!("`{name}` is a reserved name")).remedy = Some("choose another".into());
            }
            if let Some((other, _)) = seen.iter().find(|(_, known)| known == name) {
                let first = diagnostics.place(&[other, name]);
                let diagnostic =
                    Diagnostic::error(format!("`{name}` names two things; parameters could not be told apart"))
                        .at(diagnostics.place(&path))
                        .related(first, "already named here")
                        .remedy("give one of them another name");
                diagnostics.diagnostics.push(diagnostic);
            }
            seen.push((section, name));
        }
    }
}
