//! The robot at one configuration, as it is drawn. Lengths in m, base frame.

use nalgebra::{Matrix3, Vector3};

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
