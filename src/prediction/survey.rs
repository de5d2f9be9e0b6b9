//! What a campaign offers to effects: loads on joints (N.m or N), times, temperatures, sides of approach.

use super::drivers::DriverValues;
use super::error::PredictionError;
use super::terms::measured_frames;
use crate::description::campaign::{Campaign, Reading};
use crate::kinematics::Geometry;
use crate::model::Survey;
use crate::state::{JointLoadPlan, Loads, Mechanics};

/// What a campaign offers: greatest loads on the joints, times, temperatures, sides of approach.
///
/// # Errors
/// The first configuration that cannot be assembled.
pub fn survey(geometry: &Geometry, campaign: &Campaign) -> Result<Survey, PredictionError> {
    let model = geometry.model;
    let nothing = Loads { weight: false, wrench: false };
    let mechanics = Mechanics::new(model, geometry.values(), nothing, &[])?;
    let plan = JointLoadPlan::new(&mechanics, measured_frames(model, campaign), &[]);
    let (mut state, mut loads) = (mechanics.state(), plan.loads());
    let variables = model.variables.len();
    let is_difference = campaign.observes.is_difference();
    let mut drivers = DriverValues::new(campaign, variables);
    let mut survey =
        Survey { greatest_load: vec![0.0; variables], greatest_own_load: vec![0.0; variables], ..Survey::default() };
    for (index, reading) in campaign.readings.iter().enumerate() {
        let q = campaign.configuration(index);
        if index == 0 || campaign.configuration(index - 1) != q {
            let placed = mechanics.place(q, &mut state);
            placed.map_err(|source| PredictionError::at(campaign, index, source))?;
            plan.place(&mechanics, &mut state, &mut loads);
        }
        plan.load(&state, &mechanics.point(&state, reading, &reading.wrench), &mut loads);
        drivers.note(campaign, index, &loads.total, &loads.own);
        for (variable, (load, own)) in loads.total.iter().zip(&loads.own).enumerate() {
            let shown = load - if is_difference { *own } else { 0.0 };
            survey.greatest_load[variable] = survey.greatest_load[variable].max(shown.abs());
            survey.greatest_own_load[variable] = survey.greatest_own_load[variable].max(own.abs());
        }
    }
    let mut times = campaign.conditions.time.clone().unwrap_or_default();
    times.sort_by(f64::total_cmp);
    times.dedup();
    survey.times = times;
    let varies = |all: &[f64]| all.iter().any(|v| (v - all[0]).abs() > 1e-9);
    let mean = |all: &[f64]| varies(all).then(|| all.iter().sum::<f64>() / all.len() as f64).filter(|v| v.is_finite());
    let conditions = &campaign.conditions;
    let temperatures = model.frames.iter().map(|frame| conditions.temperatures_at(&frame.name).and_then(mean));
    survey.mean_temperatures = temperatures.collect();
    let is_varied = |all: &Vec<f64>| {
        let known: Vec<f64> = all.iter().copied().filter(|v| v.is_finite()).collect();
        !known.is_empty() && varies(&known)
    };
    let moves = |variable: usize| conditions.is_ordered && conditions.last_move.get(variable).is_some_and(is_varied);
    survey.moves = (0..variables).map(moves).collect();
    let greatest = |all: &[f64]| all.iter().filter(|v| v.is_finite()).fold(0.0_f64, |most, v| most.max(v.abs()));
    let greatest_move = |variable: usize| if moves(variable) { greatest(&conditions.last_move[variable]) } else { 0.0 };
    survey.greatest_moves = (0..variables).map(greatest_move).collect();
    let range = |variable: usize| {
        let values = (0..campaign.readings.len()).filter_map(|index| campaign.configuration(index).get(variable));
        values.fold([f64::INFINITY, f64::NEG_INFINITY], |[least, most], v| [least.min(*v), most.max(*v)])
    };
    survey.ranges = (0..variables).map(range).collect();
    survey.longest_session = conditions.session_time.as_deref().map(greatest).filter(|longest| *longest > 0.0);
    survey.sides = (0..variables).map(|variable| conditions.sides(variable).is_some_and(varies)).collect();
    survey.loaded = campaign.readings.iter().any(Reading::is_loaded);
    survey.is_difference = is_difference;
    survey.knots = drivers.knots();
    Ok(survey)
}
