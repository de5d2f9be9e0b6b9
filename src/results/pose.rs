//! What `pose` finds: where frames, markers and tool are. SI, base frame.

use std::collections::BTreeMap;

use indexmap::IndexMap;
use serde::Serialize;

use crate::kinematics::{Geometry, Placements, Transform, rotation_vector};

/// Homogeneous transform, by row.
pub type Homogeneous = [[f64; 4]; 4];

/// A robot at a configuration.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Pose {
    /// All moving joints, rad and m.
    pub joints: IndexMap<String, f64>,
    pub frames: IndexMap<String, Homogeneous>,
    /// Positions.
    pub markers: IndexMap<String, [f64; 3]>,
    pub tool: Homogeneous,
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
        let matrix = |t: &Transform| {
            let m = t.to_homogeneous();
            std::array::from_fn(|i| std::array::from_fn(|j| m[(i, j)]))
        };
        let six = |t: &Transform| {
            let (p, r) = (t.translation.vector, rotation_vector(&t.rotation));
            [p.x, p.y, p.z, r.x, r.y, r.z]
        };
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
}

/// Poses of a table of configurations.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Poses {
    pub poses: Vec<Pose>,
}
