//! What `view` finds: the robot at a configuration, deflected or not. Lengths in m, base frame.

use indexmap::IndexMap;
use serde::Serialize;

use super::own_weight::OwnWeight;
use super::units::mm;
use crate::model::Model;
use crate::scene::{Part, PartKind, Scene, Shot};

/// Displacement of the tool centre point, mm.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ToolDeflection {
    /// Along x of the base.
    pub x: f64,
    /// Along y of the base.
    pub y: f64,
    /// Along z of the base.
    pub z: f64,
    /// Its length.
    pub norm: f64,
    /// Unit of all of them.
    pub unit: &'static str,
}

/// What `view` finds.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct View {
    /// Name of the robot.
    pub robot: String,
    /// The command that shows it.
    pub source: String,
    /// rad and m.
    pub joints: IndexMap<String, f64>,
    /// Unit of the points and of how far they move.
    pub unit: &'static str,
    /// Parts that are drawn: links, joints, frames, beams, springs and so on.
    pub parts: Vec<Part>,
    /// Points of the parts, nothing deflected; parts refer to them by index.
    pub points: Vec<[f64; 3]>,
    /// How far load moves each point; empty without load.
    pub moved: Vec<[f64; 3]>,
    /// The load in words.
    pub load: Option<String>,
    /// Whether the deflected shape is that under own weight too.
    pub own_weight: OwnWeight,
    /// How many times the deflected shape is drawn magnified.
    pub magnified: f64,
    /// Displacement of the tool centre point; `None` without load.
    pub deflection: Option<ToolDeflection>,
    /// By variable: name, and its value in words.
    #[serde(skip)]
    pub at: Vec<String>,
}

impl View {
    /// A robot at a configuration `q` (rad and m), drawn as `shot`.
    pub fn new(model: &Model, q: &[f64], scene: &Scene, shot: &Shot) -> Self {
        let tool = scene.parts.iter().find(|part| part.kind == PartKind::Tool);
        let moved = tool.and_then(|part| shot.moved.get(*part.points.get(1)?));
        let coordinates = |points: &[nalgebra::Vector3<f64>]| points.iter().map(|p| [p.x, p.y, p.z]).collect();
        let at = model.variables.iter().zip(q);
        let words = |v: &crate::description::robot::Variable, q: f64| {
            if v.is_angle {
                format!("{} {:.2} deg", v.name, q.to_degrees())
            } else {
                format!("{} {:.2} mm", v.name, mm(q))
            }
        };
        Self {
            robot: model.name.clone(),
            source: String::new(),
            joints: at.clone().map(|(variable, q)| (variable.name.clone(), *q)).collect(),
            unit: "m",
            parts: scene.parts.clone(),
            points: coordinates(&shot.points),
            moved: coordinates(&shot.moved),
            load: None,
            own_weight: OwnWeight::nominal(model, false),
            magnified: 1.0,
            deflection: moved.map(|d| {
                let norm = d.norm();
                ToolDeflection { x: mm(d.x), y: mm(d.y), z: mm(d.z), norm: mm(norm), unit: "mm" }
            }),
            at: at.map(|(variable, q)| words(variable, *q)).collect(),
        }
    }
}
