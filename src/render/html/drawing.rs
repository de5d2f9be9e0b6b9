//! A scene as the page's script reads it. Coordinates in m, base frame.

use nalgebra::Vector3;
use serde::Serialize;

use super::arrows::Arrows;
use crate::scene::Part;
use crate::scene::Shot;

/// A configuration.
#[derive(Serialize)]
pub struct DrawnShot {
    name: String,
    /// To a hundredth of a millimetre: what is drawn needs no more.
    points: Vec<[f64; 3]>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    moved: Vec<[f64; 3]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    compliance: Option<[[f64; 3]; 3]>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    rows: Vec<usize>,
}

impl DrawnShot {
    /// A configuration with its coordinates rounded.
    pub fn new(shot: &Shot) -> Self {
        let rounded = |points: &[Vector3<f64>], step: f64| -> Vec<[f64; 3]> {
            points.iter().map(|p| [p.x, p.y, p.z].map(|v| (v * step).round() / step)).collect()
        };
        Self {
            name: shot.name.clone(),
            points: rounded(&shot.points, 1e5),
            moved: rounded(&shot.moved, 1e8),
            compliance: shot.compliance.map(|c| [0, 1, 2].map(|i| [0, 1, 2].map(|j| c[(i, j)]))),
            rows: shot.rows.clone(),
        }
    }
}

/// All that the script draws.
#[derive(Serialize)]
pub struct Drawing<'a> {
    pub unit: &'static str,
    pub axis: f64,
    pub parts: Vec<Part>,
    pub shots: Vec<DrawnShot>,
    pub next: Vec<DrawnShot>,
    pub suspects: Vec<&'a str>,
    pub arrows: Option<Arrows>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub magnified: Option<f64>,
}
