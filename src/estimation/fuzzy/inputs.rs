//! What a compliance may depend on where nobody says.

use super::task::Structure;
use crate::description::campaign::Campaign;
use crate::description::fuzzy::Input;
use crate::kinematics::{Geometry, Placements};
use crate::math::extremes;
use crate::model::Model;
use crate::prediction::PredictionError;

/// Change, rad or m, below which a variable or joint stands still: what files round.
const STILL: f64 = 1e-6;

/// All variables that change in the readings, and for a tree the joints that these move otherwise than in step: more inputs
/// cost a tree nothing, and a loop's joint may say in one what two strokes say together.
///
/// # Errors
/// A configuration that cannot be assembled.
pub fn changing_inputs(
    model: &Model,
    campaign: &Campaign,
    structure: Option<Structure>,
) -> Result<Vec<Input>, PredictionError> {
    let configurations: Vec<&[f64]> = (0..campaign.readings.len()).map(|k| campaign.configuration(k)).collect();
    let changes = |k: &usize| spread(configurations.iter().map(|q| q[*k])) > STILL;
    let variables: Vec<usize> = (0..model.variables.len()).filter(changes).collect();
    let mut inputs: Vec<Input> = variables.iter().copied().map(Input::Variable).collect();
    if structure.unwrap_or(Structure::of(inputs.len())) == Structure::Grid {
        return Ok(inputs);
    }
    let geometry = Geometry::nominal(model)?;
    let mut placements = Placements::default();
    let mut joints: Vec<Vec<f64>> = Vec::with_capacity(configurations.len());
    for q in &configurations {
        geometry.place(q, &mut placements)?;
        joints.push(placements.joints.clone());
    }
    let pairs = || configurations.iter().zip(&joints);
    let is_own = |joint: usize| {
        let in_step = |&k: &usize| {
            [1.0, -1.0].iter().any(|sign| spread(pairs().map(|(q, joints)| joints[joint] - sign * q[k])) < STILL)
        };
        spread(joints.iter().map(|joints| joints[joint])) > STILL && !variables.iter().any(in_step)
    };
    let moving = (1..model.frames.len()).filter(|&joint| model.frames[joint].moves() && is_own(joint));
    inputs.extend(moving.map(Input::Joint));
    Ok(inputs)
}

fn spread(values: impl Iterator<Item = f64>) -> f64 {
    let [low, high] = extremes(values);
    high - low
}
