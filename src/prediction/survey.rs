//! What a campaign offers to effects: loads on joints (N.m or N), times, temperatures, sides of approach.

use super::drivers::DriverValues;
use super::error::PredictionError;
use super::reading::undeflected_point;
use super::terms::measured_frames;
use crate::description::campaign::{Campaign, Reading};
use crate::kinematics::Geometry;
use crate::math::{distinct, extremes};
use crate::model::{Follower, Survey};
use crate::state::{JointLoadPlan, JointLoads, Loads, Mechanics, State};

/// What a campaign offers: greatest loads on the joints, times, temperatures, sides of approach.
///
/// # Errors
/// The first configuration that cannot be assembled.
pub fn survey(geometry: &Geometry, campaign: &Campaign) -> Result<Survey, PredictionError> {
    let model = geometry.model;
    let (variables, followers) = (model.variables.len(), model.followers());
    let coordinates = variables + followers.len();
    let mut drivers = DriverValues::new(campaign, coordinates);
    let zeros = vec![0.0; coordinates];
    let mut survey = Survey { greatest_load: zeros.clone(), greatest_own_load: zeros, ..Survey::default() };
    each_reading(geometry, campaign, |index, state, loads| {
        let reading = &campaign.readings[index];
        let base = geometry.placement(model.base_slot(reading.session));
        let up = base.rotation * -model.structure.gravity.try_normalize(0.0).unwrap_or_default();
        let is_seen = reading.observes.length_rows() == 3 && !reading.observes.touches();
        let seen = is_seen.then(|| [(base * undeflected_point(geometry, &state.placements, reading)).coords, up]);
        drivers.note(campaign, index, &followers, loads, seen);
        for (coordinate, (load, own)) in shown(loads, reading).zip(&loads.own).enumerate() {
            survey.greatest_load[coordinate] = survey.greatest_load[coordinate].max(load.abs());
            survey.greatest_own_load[coordinate] = survey.greatest_own_load[coordinate].max(own.abs());
        }
    })?;
    of_conditions(&mut survey, campaign, variables, &followers);
    let conditions = &campaign.conditions;
    let temperatures = model.frames.iter().map(|frame| conditions.temperatures_at(&frame.name).and_then(varying_mean));
    survey.mean_temperatures = temperatures.collect();
    survey.markers = distinct(campaign.readings.iter().filter_map(|reading| reading.marker));
    survey.loaded = campaign.readings.iter().any(Reading::is_loaded);
    survey.is_difference = campaign.is_difference();
    survey.knots = drivers.knots();
    Ok(survey)
}

/// Load on the joint of each coordinate in each reading, N.m or N: of a difference what the applied wrench adds.
///
/// # Errors
/// The first configuration that cannot be assembled.
pub fn joint_loads(geometry: &Geometry, campaign: &Campaign) -> Result<Vec<Vec<f64>>, PredictionError> {
    let mut all = Vec::with_capacity(campaign.readings.len());
    each_reading(geometry, campaign, |index, _, loads| all.push(shown(loads, &campaign.readings[index]).collect()))?;
    Ok(all)
}

/// Loads on the joints as a reading shows them.
fn shown(loads: &JointLoads, reading: &Reading) -> impl Iterator<Item = f64> {
    let is_difference = reading.observes.is_difference();
    loads.total.iter().zip(&loads.own).map(move |(load, own)| load - if is_difference { *own } else { 0.0 })
}

/// Places the robot, undeflected, in each reading, with the loads on its joints.
fn each_reading(
    geometry: &Geometry,
    campaign: &Campaign,
    mut note: impl FnMut(usize, &State, &JointLoads),
) -> Result<(), PredictionError> {
    let nothing = Loads { weight: false, wrench: false };
    let mechanics = Mechanics::new(geometry.model, geometry.values(), nothing, &[])?;
    let plan = JointLoadPlan::new(&mechanics, measured_frames(geometry.model, campaign), &[]);
    let (mut state, mut loads) = (mechanics.state(), plan.loads());
    for (index, reading) in campaign.readings.iter().enumerate() {
        let q = campaign.configuration(index);
        if index == 0 || campaign.configuration(index - 1) != q {
            let placed = mechanics.place(q, &mut state);
            placed.map_err(|source| PredictionError::at(campaign, index, source))?;
            plan.place(&mechanics, &mut state, &mut loads);
        }
        plan.load(&state, &mechanics.point(&state, reading, &reading.wrench), &mut loads);
        note(index, &state, &loads);
    }
    Ok(())
}

/// Times, moves, ranges and sides of approach, by coordinate.
fn of_conditions(survey: &mut Survey, campaign: &Campaign, variables: usize, followers: &[Follower]) {
    let mut times = campaign.conditions.time.clone().unwrap_or_default();
    times.sort_by(f64::total_cmp);
    times.dedup();
    survey.times = times;
    // Values of the readings by coordinate, NaN where they are not known.
    let by_coordinate = |of: &dyn Fn(usize, usize) -> Option<f64>| -> Vec<Vec<f64>> {
        let variable = |variable, index| of(variable, index).unwrap_or(f64::NAN);
        let row = |index: usize| -> Vec<f64> { (0..variables).map(|k| variable(k, index)).collect() };
        let rows: Vec<Vec<f64>> = (0..campaign.readings.len()).map(row).collect();
        let own = (0..variables).map(|k| rows.iter().map(|row| row[k]).collect());
        own.chain(followers.iter().map(|follower| rows.iter().map(|row| follower.of(row)).collect())).collect()
    };
    let conditions = &campaign.conditions;
    let is_varied = |all: &Vec<f64>| {
        let known: Vec<f64> = all.iter().copied().filter(|v| v.is_finite()).collect();
        !known.is_empty() && varies(&known)
    };
    let greatest = |all: &[f64]| all.iter().filter(|v| v.is_finite()).fold(0.0_f64, |most, v| most.max(v.abs()));
    let moves = by_coordinate(&|variable, index| conditions.last_move.get(variable)?.get(index).copied());
    survey.moves = moves.iter().map(|all| conditions.is_ordered() && is_varied(all)).collect();
    let greatest_moves = moves.iter().zip(&survey.moves);
    survey.greatest_moves = greatest_moves.map(|(all, is_known)| if *is_known { greatest(all) } else { 0.0 }).collect();
    let positions = by_coordinate(&|variable, index| campaign.configuration(index).get(variable).copied());
    survey.ranges = positions.iter().map(|all| extremes(all.iter().copied())).collect();
    let sides = by_coordinate(&|variable, index| conditions.sides(variable)?.get(index).copied());
    survey.sides = sides.iter().map(is_varied).collect();
    survey.longest_session = conditions.session_time.as_deref().map(greatest).filter(|longest| *longest > 0.0);
}

fn varies(all: &[f64]) -> bool {
    all.iter().any(|v| (v - all[0]).abs() > 1e-9)
}

fn varying_mean(all: &[f64]) -> Option<f64> {
    varies(all).then(|| all.iter().sum::<f64>() / all.len() as f64).filter(|v| v.is_finite())
}
