//! What `stiffness` finds at a point. SI, base axes.

use indexmap::IndexMap;
use nalgebra::Matrix6;
use serde::Serialize;

use super::own_weight::OwnWeight;
use crate::elastics::Shares;

/// Compliance and stiffness at a point, and the deflection under a load there.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Stiffness {
    /// Frame or marker.
    pub at: String,
    /// Displacement (m) and rotation vector (rad) by force (N) and moment (N.m).
    pub compliance: [[f64; 6]; 6],
    /// Its inverse; `None` where a direction is rigid.
    pub stiffness: Option<[[f64; 6]; 6]>,
    /// Displacement and rotation vector under the load.
    pub deflection: [f64; 6],
    /// Whether the deflection holds that by own weight.
    pub own_weight: OwnWeight,
    /// At equilibrium: the factor by which the loads could grow until the structure buckles; `None` if they never do, and
    /// without equilibrium.
    pub load_factor: Option<f64>,
    /// Of the strain energy, by element; empty where rules replace the elements.
    pub shares: IndexMap<String, f64>,
    /// Displacement and rotation vector of each node.
    pub nodes: IndexMap<String, [f64; 6]>,
    /// Name of the robot.
    #[serde(skip)]
    pub robot: String,
    /// Whether there is a load.
    #[serde(skip)]
    pub is_loaded: bool,
    /// Whether rules replace springs and beams.
    #[serde(skip)]
    pub by_rules: bool,
}

fn rows(matrix: &Matrix6<f64>) -> [[f64; 6]; 6] {
    std::array::from_fn(|i| std::array::from_fn(|j| matrix[(i, j)]))
}

/// The inverse of a compliance; `None` where a direction is rigid.
fn inverse(compliance: &Matrix6<f64>) -> Option<Matrix6<f64>> {
    // Forces and moments to the same size first.
    let scale = compliance.diagonal().map(|c| if c > 0.0 { c.sqrt().recip() } else { 0.0 });
    let scale = Matrix6::from_diagonal(&scale);
    let even = scale * compliance * scale;
    let least = even.symmetric_eigenvalues().min();
    (least > 1e-12).then(|| even.try_inverse().map(|inverse| scale * inverse * scale)).flatten()
}

impl Stiffness {
    /// Without load at the point `at`; see the fields for what a load adds.
    pub fn new(robot: &str, at: String, compliance: &Matrix6<f64>, shares: Shares, by_rules: bool) -> Self {
        Self {
            at,
            compliance: rows(compliance),
            stiffness: inverse(compliance).map(|stiffness| rows(&stiffness)),
            deflection: [0.0; 6],
            own_weight: OwnWeight::LeftOut,
            load_factor: None,
            shares: if by_rules { IndexMap::new() } else { shares.energy },
            nodes: shares.nodes,
            robot: robot.to_string(),
            is_loaded: false,
            by_rules,
        }
    }
}
