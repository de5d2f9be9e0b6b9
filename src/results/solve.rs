//! What `solve` finds: configurations at which the tool is at a target. SI.

use indexmap::IndexMap;
use serde::Serialize;

use super::own_weight::OwnWeight;
use crate::kinematics::Solution;
use crate::model::Model;

/// A configuration.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct InverseSolution {
    /// rad and m.
    pub joints: IndexMap<String, f64>,
    /// m.
    pub position_error: f64,
    /// rad.
    pub orientation_error: f64,
    /// Standard uncertainty of the tool's position along x, y, z, m, where the description says how it was fitted.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub standard_uncertainty: Option<[f64; 3]>,
    /// Directions in which the robot moves while its tool stands still.
    pub self_motions: usize,
}

/// What `solve` finds.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct InverseSolutions {
    /// Whether the tool is at the target as own weight deflects it, or rigid.
    pub own_weight: OwnWeight,
    /// Configurations found; empty where none is.
    pub solutions: Vec<InverseSolution>,
    /// By variable: whether it is an angle.
    #[serde(skip)]
    pub angles: IndexMap<String, bool>,
}

impl InverseSolutions {
    /// With the variables of a model; `under_weight` if the tool is at the target as own weight deflects it.
    pub fn new(model: &Model, found: &[Solution], under_weight: bool) -> Self {
        let solution = |solution: &Solution| InverseSolution {
            joints: model.variables.iter().zip(&solution.joints).map(|(v, q)| (v.name.clone(), *q)).collect(),
            position_error: solution.position_error,
            orientation_error: solution.orientation_error,
            standard_uncertainty: None,
            self_motions: solution.self_motions,
        };
        Self {
            own_weight: OwnWeight::nominal(model, under_weight),
            solutions: found.iter().map(solution).collect(),
            angles: model.variables.iter().map(|v| (v.name.clone(), v.is_angle)).collect(),
        }
    }
}
