//! Loads with which motors hold their joints, for readings of torques.

use std::borrow::Cow;

use super::error::PredictionError;
use super::terms::measured_frames;
use crate::description::campaign::Campaign;
use crate::description::robot::FrameIndex;
use crate::elements::{Spring, SpringState};
use crate::kinematics::{Transform, shift};
use crate::model::Model;
use crate::state::{JointLoadPlan, Loads, Mechanics};
use nalgebra::Vector3;

/// Puts the holding load of its variable into each reading of a torque: what the motor supplies (N.m, N) against own weight,
/// payload, wrench and springs between bodies, by virtual work with the description's values, nothing deflected. Where loads
/// of joints are measured, puts the described ones of every reading next to them.
///
/// # Errors
/// A configuration that cannot be assembled.
pub fn fill_holding_loads(model: &Model, campaign: &mut Campaign) -> Result<(), PredictionError> {
    fill(model, campaign, &model.registry.nominal())
}

/// The campaign with the holding loads, and the described ones, at `values` (all slots, SI), such as those of a calibration; as it is where
/// no load of a joint is measured.
///
/// # Errors
/// As [`fill_holding_loads`].
pub fn with_holding_loads<'c>(
    model: &Model,
    campaign: &'c Campaign,
    values: &[f64],
) -> Result<Cow<'c, Campaign>, PredictionError> {
    if !measures_loads(campaign) {
        return Ok(Cow::Borrowed(campaign));
    }
    let mut filled = campaign.clone();
    fill(model, &mut filled, values)?;
    Ok(Cow::Owned(filled))
}

/// Whether loads of joints are read, or measured next to other readings.
fn measures_loads(campaign: &Campaign) -> bool {
    campaign.conditions.torques.iter().any(Option::is_some)
        || campaign.readings.iter().any(|reading| reading.observes.by_variable().is_some())
}

fn fill(model: &Model, campaign: &mut Campaign, values: &[f64]) -> Result<(), PredictionError> {
    if !measures_loads(campaign) {
        return Ok(());
    }
    let is_measured = campaign.conditions.torques.iter().any(Option::is_some);
    if is_measured {
        campaign.conditions.described_loads = vec![vec![f64::NAN; campaign.readings.len()]; model.variables.len()];
    }
    let mechanics = Mechanics::new(model, values, Loads { weight: false, wrench: false }, &[])?;
    let springs = model.structure.springs.iter().map(AsRef::as_ref);
    let springs: Vec<&Spring> = springs.filter(|spring: &&Spring| spring.spring.free_length.is_some()).collect();
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
        let pulls: Vec<_> = springs.iter().map(|spring| Pull::new(spring, values, &state.placements.frames)).collect();
        let driven = |variable: usize| {
            let own = loads.total[variable] * loads.joint_rate[variable];
            pulls.iter().fold(own, |driven, pull| driven - pull.power(|frame| loads.twists.of(frame)[variable]))
        };
        for (variable, described) in campaign.conditions.described_loads.iter_mut().enumerate() {
            described[index] = driven(variable);
        }
        let named = campaign.variable_read(&reading);
        if let Some(variable) = model.variables.iter().position(|variable| Some(variable.name.as_str()) == named) {
            campaign.readings[index].load = -driven(variable);
        }
    }
    Ok(())
}

/// The pull of a spring between two bodies, N, and where it acts.
struct Pull<'s> {
    spring: &'s Spring,
    force: f64,
    along: Vector3<f64>,
    /// From the origin of each body's frame to its anchor, base axes, m.
    arms: [Vector3<f64>; 2],
}

impl<'s> Pull<'s> {
    fn new(spring: &'s Spring, values: &[f64], frames: &[Transform]) -> Self {
        let at = SpringState::new(spring, values, frames);
        let arm = |k: usize| {
            let [x, y, z] = [0, 1, 2].map(|axis| values[spring.slots[2 + 3 * k + axis]]);
            frames[spring.spring.bodies[k]].rotation * Vector3::new(x, y, z)
        };
        Self { spring, force: at.rate * (at.length - values[spring.slots[1]]), along: at.along, arms: [arm(0), arm(1)] }
    }

    /// Its power where frames move with these twists.
    fn power(&self, twist: impl Fn(FrameIndex) -> [f64; 6]) -> f64 {
        let [a, b] = [0, 1].map(|k| shift(&twist(self.spring.spring.bodies[k]), &self.arms[k]));
        self.force * self.along.dot(&(b - a))
    }
}
