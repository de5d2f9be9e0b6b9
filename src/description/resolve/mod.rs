//! Raw -> resolved: names to indices, units to SI, and every fault of the file told in one run.

mod calibration;
mod elastic;
mod elastic_values;
mod fuzzy;
mod motion;
mod sizes;
mod tree;

pub use elastic_values::power;
pub use sizes::doubtful_sizes;

use nalgebra::Vector3;

use super::elastic::Elastic;
use super::raw::{RawPlacement, RawRobot};
use super::robot::{Marker, Placement, Robot, Tool};
use super::units::Units;
use crate::diagnostic::{Diagnostic, Place};

/// Says where a path of the file stands (keys from the top, list positions as numbers).
pub type Locate<'a> = &'a dyn Fn(&[&str]) -> Option<Place>;

/// Says whether what is missing at a path is missing because of a fault that has been told already.
pub type Explained<'a> = &'a dyn Fn(&[&str]) -> bool;

/// Greatest length (m) or angle (rad) that is taken for one.
pub const GREATEST: f64 = 1e9;

/// Collects diagnostics, each with its place.
pub(super) struct Complaints<'a> {
    locate: Locate<'a>,
    explained: Explained<'a>,
    pub diagnostics: Vec<Diagnostic>,
}

impl<'a> Complaints<'a> {
    pub fn new(locate: Locate<'a>, explained: Explained<'a>) -> Self {
        Self { locate, explained, diagnostics: Vec::new() }
    }

    /// Whether what is missing at `path` has been told as faulty.
    pub fn explained(&self, path: &[&str]) -> bool {
        (self.explained)(path)
    }

    /// Files an error about an owner at `path` that has no `key`, unless the key is there and faulty.
    pub fn lacking(&mut self, path: &[&str], key: &str, message: impl Into<String>) -> Option<&mut Diagnostic> {
        let mut wanted = path.to_vec();
        wanted.push(key);
        if self.explained(&wanted) {
            return None;
        }
        Some(self.error(path, message))
    }

    pub fn place(&self, path: &[&str]) -> Option<Place> {
        (self.locate)(path)
    }

    /// Files an error about the value at `path`; the caller may add to it.
    pub fn error(&mut self, path: &[&str], message: impl Into<String>) -> &mut Diagnostic {
        self.file(Diagnostic::error(message).at(self.place(path)))
    }

    fn file(&mut self, diagnostic: Diagnostic) -> &mut Diagnostic {
        let last = self.diagnostics.len();
        self.diagnostics.push(diagnostic);
        &mut self.diagnostics[last]
    }

    /// An unknown name, with the nearest valid one.
    ///
    /// Says nothing of a name whose declaration is there and faulty.
    pub fn unknown<'n>(&mut self, path: &[&str], kind: &str, name: &str, valid: impl IntoIterator<Item = &'n str>) {
        let sections: &[&str] = match kind {
            "frame" | "joint" => &["frames"],
            "node" => &["nodes", "frames"],
            "section" => &["sections"],
            "material" => &["materials"],
            "actuator" => &["actuators"],
            "parameter" => &["frames", "actuators", "markers", "springs", "joint_stiffness"],
            _ => &[],
        };
        let owner = if kind == "parameter" { name.rsplit_once('.').map_or(name, |(owner, _)| owner) } else { name };
        let owner_of = |section: &str| {
            if section == "joint_stiffness" { owner.trim_start_matches("joint") } else { owner }
        };
        if sections.iter().any(|section| self.told_faulty(section, owner_of(section))) {
            return;
        }
        let diagnostic =
            Diagnostic::error(format!("unknown {kind} `{name}`")).at(self.place(path)).suggest(name, valid);
        self.diagnostics.push(diagnostic);
    }

    /// Whether a section, or the entry under exactly this name in it, was set aside as faulty.
    fn told_faulty(&self, section: &str, name: &str) -> bool {
        self.explained(&[section]) || self.explained(&[section, name])
    }

    /// `value * factor`, complaining unless it is a finite number that a length or an angle can be.
    pub fn finite(&mut self, path: &[&str], value: Option<f64>, factor: f64) -> f64 {
        let value = value.unwrap_or(0.0);
        if !value.is_finite() {
            self.error(path, format!("`{value}` where a finite number is needed"));
            return 0.0;
        }
        if (value * factor).abs() > GREATEST {
            self.error(path, format!("`{value:e}` is too great")).remedy = Some("check the value and `units:`".into());
            return 0.0;
        }
        value * factor
    }

    pub fn vector(&mut self, path: &[&str], value: Option<[f64; 3]>, factor: f64) -> Vector3<f64> {
        let value = value.unwrap_or_default();
        if let Some(bad) = value.iter().find(|v| !v.is_finite()) {
            self.error(path, format!("`{bad}` where a finite number is needed"));
            return Vector3::zeros();
        }
        if let Some(bad) = value.iter().find(|v| (**v * factor).abs() > GREATEST) {
            self.error(path, format!("`{bad:e}` is too great")).remedy = Some("check the value and `units:`".into());
            return Vector3::zeros();
        }
        Vector3::from(value) * factor
    }

    /// Limits of a joint or a stroke: an interval of lengths or angles, infinite where there is none.
    pub fn limits(&mut self, path: &[&str], value: Option<[f64; 2]>, factor: f64) -> Option<[f64; 2]> {
        let limits = self.interval(path, value, factor, true)?;
        if let Some(bad) = limits.iter().find(|v| v.is_finite() && v.abs() > GREATEST) {
            let shown = bad / factor;
            self.error(path, format!("`{shown:e}` is too great")).remedy =
                Some("write `.inf` where there is no limit".into());
            return None;
        }
        Some(limits)
    }

    /// Limits or bounds: numbers, in order; infinite ones only where `open`.
    pub fn interval(&mut self, path: &[&str], value: Option<[f64; 2]>, factor: f64, open: bool) -> Option<[f64; 2]> {
        let [low, high] = value?;
        if low.is_nan() || high.is_nan() || !(open || low.is_finite() && high.is_finite()) {
            self.error(
                path,
                format!("[{low}, {high}]: both ends must be {}numbers", if open { "" } else { "finite " }),
            );
            return None;
        }
        if low >= high {
            self.error(path, format!("[{low}, {high}]: the lower end is not below the upper one")).remedy.replace(
                if low > high { format!("write [{high}, {low}]") } else { "give an interval that is not empty".into() },
            );
            return None;
        }
        Some([low * factor, high * factor])
    }
}

/// Resolves a raw description. The robot is `None` when any diagnostic is an error.
pub fn resolve(raw: &RawRobot, locate: Locate) -> (Option<Robot>, Vec<Diagnostic>) {
    resolve_explained(raw, locate, &|_| false)
}

/// As [`resolve`], of a description some entries of which were set aside as faulty: what is missing through them is not
/// told again.
pub fn resolve_explained(raw: &RawRobot, locate: Locate, explained: Explained) -> (Option<Robot>, Vec<Diagnostic>) {
    let mut diagnostics = Complaints::new(locate, explained);
    let units = &raw.units;
    let tree = tree::resolve(raw, &mut diagnostics);
    let name = raw.robot.clone().unwrap_or_else(|| "robot".into());
    let frames = &tree.frames;
    let frame_named = |name: &str| frames.iter().position(|frame| frame.name == name);
    let names: Vec<String> = frames.iter().map(|frame| frame.name.clone()).collect();
    let placed = |diagnostics: &mut Complaints, path: &[&str], given: &Option<String>, default: usize| match given {
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
        || diagnostics.diagnostics.iter().any(|diagnostic| diagnostic.message.contains("antecedent"));
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
    let calibration = calibration::resolve(raw, &tree, &mut diagnostics);
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

fn placement(diagnostics: &mut Complaints, owner: &str, raw: &RawPlacement, units: &Units) -> Placement {
    Placement {
        position: diagnostics.vector(&[owner, "at"], raw.at, units.length.factor()),
        rotation: diagnostics.vector(&[owner, "rotation"], raw.rotation, units.angle.factor()),
    }
}

/// A parameter is named `<owner>.<symbol>`, so no two owners may share a name, whatever they are.
fn unique_owners(raw: &RawRobot, diagnostics: &mut Complaints) {
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
