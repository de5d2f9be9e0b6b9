//! The causes found, fitted once more with everything that is calibrated, not to first order only.

use super::competition::Competition;
use super::inputs::Inputs;
use super::linear_fit::{FittedParameter, LinearFit, entry};
use crate::estimation::{Calibration, Settings, bounds, calibrate_as_weighed};
use crate::model::Model;
use crate::parameter::Slot;

/// A fit of the model with its causes.
pub struct Refit {
    /// Values of the model without the causes.
    pub values: Vec<f64>,
    /// Parameters of each cause.
    pub parameters: Vec<Vec<FittedParameter>>,
}

/// Calibrates nuisance and members together, from their linear fit; the linear fit where that cannot be done.
pub fn refit(inputs: &Inputs, competition: &Competition, members: &[usize], linear: &LinearFit) -> Refit {
    let found = if members.is_empty() { None } else { calibrated(inputs, competition, members, linear) };
    found.unwrap_or_else(|| Refit {
        values: with_nuisance(inputs.model, competition, linear),
        parameters: (0..members.len()).map(|step| linear.parameters(step)).collect(),
    })
}

fn calibrated(inputs: &Inputs, competition: &Competition, members: &[usize], linear: &LinearFit) -> Option<Refit> {
    let mut model = inputs.model.clone();
    let mut slots: Vec<Vec<Slot>> = Vec::new();
    for (step, &member) in members.iter().enumerate() {
        let hypothesis = &competition.problem.hypotheses[member];
        if hypothesis.constants.is_empty() {
            model.switch_on(entry(hypothesis, &linear.parameters(step)));
            slots.push(model.effects.last()?.slots.iter().copied().flatten().collect());
        } else {
            slots.push(hypothesis.constants.clone());
        }
    }
    let mut only = [inputs.nuisance.clone(), slots.concat()].concat();
    only.sort_unstable();
    only.dedup();
    if only.is_empty() {
        return None;
    }
    let asked = Settings { only: Some(only), second_order: false, hold_far_springs: false, ..Settings::default() };
    let found = calibrate_as_weighed(&model, &competition.campaign, &competition.held_out, &asked, &mut |_| {})
        .ok()
        .filter(Calibration::converged)?;
    let mut values = found.values.clone();
    let mut parameters = Vec::new();
    for (step, (&member, slots)) in members.iter().zip(&slots).enumerate() {
        let is_constant = !competition.problem.hypotheses[member].constants.is_empty();
        let mut own = linear.parameters(step);
        for (parameter, &slot) in own.iter_mut().zip(slots) {
            // What a cause changes stands in its entry, and not in the values.
            let before = if is_constant { competition.values[slot] } else { 0.0 };
            parameter.value = found.values[slot] - before;
            if is_constant {
                values[slot] = before;
            }
        }
        parameters.push(own);
    }
    values.truncate(inputs.model.registry.all().len());
    Some(Refit { values, parameters })
}

/// Calibrated values with the changes of the nuisance by a linear fit; what its members change stands in their entries.
pub fn with_nuisance(model: &Model, competition: &Competition, linear: &LinearFit) -> Vec<f64> {
    let mut values = competition.values.clone();
    for (&slot, change) in competition.kept.iter().zip(&linear.x) {
        // A linear step knows of no bounds: a spring near rigid would end negative.
        let [low, high] = bounds(model, slot);
        values[slot] = (values[slot] + change).max(low).min(high);
    }
    values
}
