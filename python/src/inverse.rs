//! Joints for many targets.

use elastogeo::compensation::deflected;
use elastogeo::kinematics::{Geometry, Hold, InverseError, InverseSettings, Target, solve};
use elastogeo::prediction::SinglePredictor;
use nalgebra::{Point3, Rotation3, Vector3};
use pyo3::prelude::*;
use rayon::prelude::*;

use crate::arrays::Rows;
use crate::error::fault;
use crate::work::brief;

/// Targets between two looks for signals: a tenth of a second.
const BLOCK: usize = 64;

/// How solutions are sought.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct Search {
    /// Whether the deflected robot is to meet the target.
    pub weight: bool,
    pub restarts: usize,
    pub seed: u64,
    /// Whether a target out of reach gets joints that are no numbers, instead of an error.
    pub leaves_gaps: bool,
}

/// Positions and rotation vectors of the tool in the base frame, and configurations from which the nearest solution is sought:
/// one for each target, or one for all.
pub struct Targets<'a> {
    pub positions: &'a Rows,
    pub rotations: Option<&'a Rows>,
    pub starts: &'a Rows,
}

impl Targets<'_> {
    /// Joints of each target, in order, whatever the number of threads; of the deflected robot with a predictor.
    pub fn solve(
        &self,
        py: Python<'_>,
        geometry: &Geometry<'_>,
        predictor: Option<&SinglePredictor<'_>>,
        search: &Search,
    ) -> PyResult<Vec<f64>> {
        let variables = geometry.model.variables.len().max(1);
        let count = self.positions.values.len() / 3;
        let starts: Vec<&[f64]> = self.starts.values.chunks_exact(variables).collect();
        if !self.starts.is_single && starts.len() != count {
            let message = format!("start: {} rows, and {count} targets", starts.len());
            return Err(fault(py, message, "give one start of shape (joints,), or one for each target"));
        }
        let start = |row: usize| starts.get(if self.starts.is_single { 0 } else { row }).copied().unwrap_or_default();
        let mut joints = Vec::with_capacity(count * variables);
        for first in (0..count).step_by(BLOCK) {
            let rows = first..count.min(first + BLOCK);
            let found = brief(py, || {
                let found = rows.into_par_iter().map(|row| {
                    let settings = InverseSettings {
                        restarts: search.restarts,
                        seed: search.seed,
                        from: Some(start(row).to_vec()),
                        ..InverseSettings::default()
                    };
                    match one(geometry, predictor, &self.target(row), &settings) {
                        Err(error) if search.leaves_gaps && is_out_of_reach(&error) => Ok(vec![f64::NAN; variables]),
                        found => found.map_err(|error| error.at(format!("row {row}"))),
                    }
                });
                found.collect::<Vec<_>>().into_iter().collect::<Result<Vec<_>, _>>()
            })?;
            joints.extend(found.into_iter().flatten());
            py.check_signals()?;
        }
        Ok(joints)
    }

    fn target(&self, row: usize) -> Target {
        let vector = |rows: &Rows| rows.values.get(3 * row..3 * row + 3).map(Vector3::from_column_slice);
        let position = Point3::from(vector(self.positions).unwrap_or_default());
        let rotation = self.rotations.and_then(vector).map(Rotation3::new);
        Target { position, rotation, hold: if rotation.is_some() { Hold::POSE } else { Hold::POSITION } }
    }
}

fn is_out_of_reach(error: &elastogeo::Error) -> bool {
    matches!(error, elastogeo::Error::Inverse(InverseError::OutOfReach { .. }) | elastogeo::Error::Refusal(_))
}

/// Joints of the nearest solution.
fn one(
    geometry: &Geometry<'_>,
    predictor: Option<&SinglePredictor<'_>>,
    target: &Target,
    settings: &InverseSettings,
) -> Result<Vec<f64>, elastogeo::Error> {
    let nothing = || elastogeo::Error::input("no solution was found", "try another start");
    let found = solve(geometry, target, settings)?.into_iter().next().ok_or_else(nothing)?;
    Ok(match predictor {
        Some(predictor) => deflected(predictor, target, &found, &mut predictor.workspace())?.joints,
        None => found.joints,
    })
}
