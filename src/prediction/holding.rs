//! Loads with which motors hold their joints, for readings of torques.

use super::error::PredictionError;
use super::terms::measured_frames;
use crate::description::campaign::Campaign;
use crate::elements::{Spring, SpringState};
use crate::kinematics::shift;
use crate::model::Model;
use crate::state::{JointLoadPlan, Loads, Mechanics};
use nalgebra::{Point3, Vector3};

/// Puts the holding load of its variable into each reading of a torque: what the motor supplies (N.m, N) against own weight,
/// payload, wrench and springs between bodies, by virtual work with the description's values, nothing deflected.
///
/// # Errors
/// A configuration that cannot be assembled.
pub fn fill_holding_loads(model: &Model, campaign: &mut Campaign) -> Result<(), PredictionError> {
    if campaign.readings.iter().all(|reading| reading.observes.by_variable().is_none()) {
        return Ok(());
    }
    let values = model.registry.nominal();
    let mechanics = Mechanics::new(model, &values, Loads { weight: false, wrench: false }, &[])?;
    let springs: Vec<&Spring> = model
        .structure
        .springs
        .iter()
        .map(AsRef::as_ref)
        .filter(|spring| spring.spring.free_length.is_some())
        .collect();
    let mut frames = measured_frames(model, campaign);
    frames.extend(springs.iter().flat_map(|spring| spring.spring.bodies));
    let plan = JointLoadPlan::new(&mechanics, frames, &[]);
    let (mut state, mut loads) = (mechanics.state(), plan.loads());
    for index in 0..campaign.readings.len() {
        if campaign.readings[index].observes.by_variable().is_none() {
            continue;
        }
        let placed = mechanics.place(campaign.configuration(index), &mut state);
        placed.map_err(|source| PredictionError::at(campaign, index, source))?;
        plan.place(&mechanics, &mut state, &mut loads);
        let reading = campaign.readings[index];
        plan.load(&state, &mechanics.point(&state, &reading, &reading.wrench), &mut loads);
        let named = campaign.targets.get(reading.target).map(|target| target.member.0.as_str());
        let variable = model.variables.iter().position(|variable| Some(variable.name.as_str()) == named);
        let Some(variable) = variable else { continue };
        let mut driven = loads.total[variable] * loads.joint_rate[variable];
        for spring in &springs {
            let at = SpringState::new(spring, &values, &state.placements.frames);
            let pull = at.rate * (at.length - values[spring.slots[1]]);
            let moved = |k: usize| -> Vector3<f64> {
                let frame = spring.spring.bodies[k];
                let [x, y, z] = [0, 1, 2].map(|axis| values[spring.slots[2 + 3 * k + axis]]);
                let arm = state.placements.frames[frame].rotation * Point3::new(x, y, z).coords;
                shift(&loads.twists.of(frame)[variable], &arm)
            };
            driven -= pull * at.along.dot(&(moved(1) - moved(0)));
        }
        campaign.readings[index].load = -driven;
    }
    Ok(())
}
