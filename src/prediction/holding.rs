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
/// payload, wrench and springs between bodies, by virtual work with the description's values, nothing deflected. Where loads
/// of joints are measured, puts the described ones of every reading next to them.
///
/// # Errors
/// A configuration that cannot be assembled.
pub fn fill_holding_loads(model: &Model, campaign: &mut Campaign) -> Result<(), PredictionError> {
    let is_measured = campaign.conditions.torques.iter().any(Option::is_some);
    if !is_measured && campaign.readings.iter().all(|reading| reading.observes.by_variable().is_none()) {
        return Ok(());
    }
    if is_measured {
        campaign.conditions.described_loads = vec![vec![f64::NAN; campaign.readings.len()]; model.variables.len()];
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
        let is_torque = campaign.readings[index].observes.by_variable().is_some();
        if !is_torque && !is_measured {
            continue;
        }
        let placed = mechanics.place(campaign.configuration(index), &mut state);
        placed.map_err(|source| PredictionError::at(campaign, index, source))?;
        plan.place(&mechanics, &mut state, &mut loads);
        let reading = campaign.readings[index];
        plan.load(&state, &mechanics.point(&state, &reading, &reading.wrench), &mut loads);
        let of_springs: Vec<(f64, SpringState, &Spring)> = springs
            .iter()
            .map(|spring| {
                let at = SpringState::new(spring, &values, &state.placements.frames);
                (at.rate * (at.length - values[spring.slots[1]]), at, *spring)
            })
            .collect();
        let driven = |variable: usize| {
            let mut driven = loads.total[variable] * loads.joint_rate[variable];
            for (pull, at, spring) in &of_springs {
                let moved = |k: usize| -> Vector3<f64> {
                    let frame = spring.spring.bodies[k];
                    let [x, y, z] = [0, 1, 2].map(|axis| values[spring.slots[2 + 3 * k + axis]]);
                    let arm = state.placements.frames[frame].rotation * Point3::new(x, y, z).coords;
                    shift(&loads.twists.of(frame)[variable], &arm)
                };
                driven -= pull * at.along.dot(&(moved(1) - moved(0)));
            }
            driven
        };
        for (variable, described) in campaign.conditions.described_loads.iter_mut().enumerate() {
            described[index] = driven(variable);
        }
        let named = campaign.targets.get(reading.target).map(|target| target.member.0.as_str());
        let variable = model.variables.iter().position(|variable| Some(variable.name.as_str()) == named);
        if let Some(variable) = variable.filter(|_| is_torque) {
            campaign.readings[index].load = -driven(variable);
        }
    }
    Ok(())
}
