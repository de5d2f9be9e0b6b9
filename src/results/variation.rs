//! How what pushes on the tool moves it along a path depends on what is declared. SI.

use crate::math::norm;
use serde::Serialize;

use super::Distances;

/// Displacements of the points of a path.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PathDeviations {
    /// Along x, y, z of the base, by point; `None` where no equilibrium was found.
    pub points: Vec<Option<[f64; 3]>>,
    /// Of their size.
    pub distance: Distances,
    /// Along x, y and z.
    pub greatest: [f64; 3],
    /// Root mean square displacements along x, y and z.
    pub rms: [f64; 3],
}

impl PathDeviations {
    /// From the displacements by point.
    pub fn new(points: Vec<Option<[f64; 3]>>) -> Self {
        let along = |axis: usize| Distances::of(points.iter().flatten().map(move |by| by[axis].abs()));
        let all = [0, 1, 2].map(along);
        Self {
            distance: Distances::of(points.iter().flatten().map(norm)),
            greatest: all.map(|of| of.max),
            rms: all.map(|of| of.rms),
            points,
        }
    }
}

/// The path with something declared otherwise.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Varied {
    /// What, as asked for.
    pub what: String,
    /// By what it is multiplied; `None` where path and process are moved.
    pub factor: Option<f64>,
    /// By how far path and process are moved, m.
    pub moved: Option<f64>,
    /// Where the numbers stand that this changes.
    pub places: Vec<String>,
    /// Displacements of the points then.
    #[serde(flatten)]
    pub deviations: PathDeviations,
    /// Change of the logarithm of the rms distance over that of the factor: -1 of the only spring that gives.
    pub elasticity: Option<f64>,
}

/// What `compensate --vary` finds.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Variation {
    /// Unit of lengths.
    pub unit: &'static str,
    /// With everything as it is declared.
    pub declared: PathDeviations,
    /// The path with one thing at a time declared otherwise.
    pub varied: Vec<Varied>,
    /// Name of the robot.
    #[serde(skip)]
    pub robot: String,
}
