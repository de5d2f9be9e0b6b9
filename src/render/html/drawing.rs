//! A scene as the page's script reads it.

use nalgebra::{Matrix3, Vector3};
use serde_json::{Value, json};

use crate::scene::{PartKind, Scene};

/// The robot at one configuration.
#[derive(Debug, Clone, PartialEq)]
pub struct Shot {
    /// What it is called.
    pub name: String,
    /// Points of the scene, m, base frame.
    pub points: Vec<Vector3<f64>>,
    /// How far load moves each, m; empty where none is shown.
    pub moved: Vec<Vector3<f64>>,
    /// Displacement of the tool centre point by force, m/N, base axes.
    pub compliance: Option<Matrix3<f64>>,
    /// Rows of the readings taken there.
    pub rows: Vec<usize>,
}

/// Name of a kind in the script and in style sheets.
fn kind(kind: PartKind) -> &'static str {
    match kind {
        PartKind::Link => "link",
        PartKind::Joint => "joint",
        PartKind::Frame => "frame",
        PartKind::Cut => "cut",
        PartKind::Actuator => "actuator",
        PartKind::Beam => "beam",
        PartKind::Spring => "spring",
        PartKind::Mass => "mass",
        PartKind::Marker => "marker",
        PartKind::Tool => "tool",
        PartKind::Anchor => "anchor",
    }
}

/// Coordinates in m, to a hundredth of a millimetre: what is drawn needs no more.
fn coordinates(points: &[Vector3<f64>]) -> Value {
    let round = |v: f64| (v * 1e5).round() / 1e5;
    json!(points.iter().map(|p| [round(p.x), round(p.y), round(p.z)]).collect::<Vec<_>>())
}

fn fine(points: &[Vector3<f64>]) -> Value {
    let round = |v: f64| (v * 1e8).round() / 1e8;
    json!(points.iter().map(|p| [round(p.x), round(p.y), round(p.z)]).collect::<Vec<_>>())
}

/// Parts of a scene.
pub fn parts_json(scene: &Scene) -> Value {
    let part = |part: &crate::scene::Part| {
        let mut value = json!({"kind": kind(part.kind), "name": part.name, "words": part.words, "points": part.points});
        if !part.form.is_empty() {
            value["form"] = json!(part.form);
        }
        if !part.drive.is_empty() {
            value["drive"] = json!(part.drive);
        }
        if !part.sites.is_empty() {
            value["sites"] = json!(part.sites);
        }
        value
    };
    json!(scene.parts.iter().map(part).collect::<Vec<_>>())
}

/// A configuration.
pub fn shot_json(shot: &Shot) -> Value {
    let mut value = json!({"name": shot.name, "points": coordinates(&shot.points)});
    if !shot.moved.is_empty() {
        value["moved"] = fine(&shot.moved);
    }
    if let Some(compliance) = &shot.compliance {
        value["compliance"] = json!((0..3).map(|i| [0, 1, 2].map(|j| compliance[(i, j)])).collect::<Vec<_>>());
    }
    if !shot.rows.is_empty() {
        value["rows"] = json!(shot.rows);
    }
    value
}
