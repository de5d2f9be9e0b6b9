//! What `pose` finds: where frames, markers and tool are. SI, base frame.

use std::collections::BTreeMap;

use indexmap::IndexMap;
use serde::Serialize;

use super::own_weight::OwnWeight;
use crate::compensation::six;
use crate::kinematics::{Geometry, Placements, Transform};

/// Homogeneous transform, by row.
pub type Homogeneous = [[f64; 4]; 4];

/// A robot at a configuration.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Pose {
    /// All moving joints, rad and m.
    pub joints: IndexMap<String, f64>,
    /// Pose of each frame but the base, nothing deflected.
    pub frames: IndexMap<String, Homogeneous>,
    /// Positions.
    pub markers: IndexMap<String, [f64; 3]>,
    /// Pose of the tool centre point.
    pub tool: Homogeneous,
    /// Whether tool and markers stand where own weight puts them; frames are never deflected.
    pub own_weight: OwnWeight,
    /// Effects of the description that are not in: they are where own weight is.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub effects_left_out: Vec<String>,
    /// Standard uncertainty of the tool's position along x, y, z, m, where the description says how it was fitted.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub standard_uncertainty: Option<[f64; 3]>,
    /// Displacement and rotation vector of tool and markers under a load.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub deflection: Option<BTreeMap<String, [f64; 6]>>,
    /// The same in the order of the description.
    #[serde(skip)]
    pub deflected: Vec<(String, [f64; 6])>,
    /// By joint: whether it is an angle.
    #[serde(skip)]
    pub angles: Vec<bool>,
    /// Frames and tool: name, position and rotation vector.
    #[serde(skip)]
    pub placed: Vec<(String, [f64; 6])>,
}

impl Pose {
    /// At placed frames.
    pub fn new(geometry: &Geometry, placements: &Placements) -> Self {
        let model = geometry.model;
        let moving = model.frames.iter().zip(&placements.joints).filter(|(frame, _)| frame.moves());
        let (joints, angles) = moving
            .map(|(frame, q)| {
                let is_angle = frame.joint == crate::description::raw::JointKind::Revolute;
                ((frame.name.clone(), *q), is_angle)
            })
            .unzip();
        let tool = placements.frames[model.tool.0] * geometry.tool();
        let frames = || model.frames.iter().zip(&placements.frames).skip(1);
        let mut placed: Vec<(String, [f64; 6])> = frames().map(|(frame, at)| (frame.name.clone(), six(at))).collect();
        placed.push(("tool".into(), six(&tool)));
        let marker = |m: usize| {
            let point = placements.frames[model.markers[m].frame] * geometry.marker(m);
            (model.markers[m].name.clone(), [point.x, point.y, point.z])
        };
        Self {
            joints,
            frames: frames().map(|(frame, at)| (frame.name.clone(), matrix(at))).collect(),
            markers: (0..model.markers.len()).map(marker).collect(),
            tool: matrix(&tool),
            own_weight: OwnWeight::nominal(model, false),
            effects_left_out: model.effects.iter().map(|on| on.entry.effect.name().to_string()).collect(),
            standard_uncertainty: None,
            deflection: None,
            deflected: Vec::new(),
            angles,
            placed,
        }
    }

    /// The same with the deflection of tool and markers.
    #[must_use]
    pub fn deflected(self, deflected: Vec<(String, [f64; 6])>) -> Self {
        Self { deflection: Some(deflected.iter().cloned().collect()), deflected, ..self }
    }

    /// The same with the tool and the markers (in the model's order) where loads put them.
    #[must_use]
    pub fn loaded(mut self, own_weight: OwnWeight, tool: &Transform, markers: &[Transform]) -> Self {
        self.own_weight = own_weight;
        self.effects_left_out.clear();
        self.tool = matrix(tool);
        if let Some((_, placed)) = self.placed.last_mut() {
            *placed = six(tool);
        }
        for (at, marker) in self.markers.values_mut().zip(markers) {
            *at = marker.translation.vector.into();
        }
        self
    }
}

fn matrix(t: &Transform) -> Homogeneous {
    let m = t.to_homogeneous();
    std::array::from_fn(|i| std::array::from_fn(|j| m[(i, j)]))
}

/// Poses of a table of configurations.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Poses {
    /// By row of the table.
    pub poses: Vec<Pose>,
}
