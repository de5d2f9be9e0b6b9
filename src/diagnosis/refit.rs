//! The causes found, fitted once more with everything that is calibrated, not to first order only.

use super::competition::Competition;
use super::inputs::Inputs;
use super::linear_fit::{FittedParameter, LinearFit, entry};
use crate::estimation::{Calibration, Settings, bounds, calibrate_as_weighed, describes, predicts_as_well};
use crate::identifiability::{Criterion, DEFAULT_TOLERANCE};
use crate::model::Model;
use crate::parameter::Slot;

/// What is left over the stated noise below which that noise is not the readings' own: as it is doubted (`plausibility::Limits::noise`).
const FAR_BELOW: f64 = 0.2;

/// A fit of the model with its causes.
pub struct Refit {
    /// Values of the model without the causes.
    pub values: Vec<f64>,
    /// Parameters of each cause.
    pub parameters: Vec<Vec<FittedParameter>>,
}

/// Calibrates nuisance and members together, from their linear fit; the linear fit where that cannot be done. A curve at the site of a law
/// can do all that the law does: it is fitted to what the law leaves, so that the law's amount is what it is without the curve. What the
/// noise hides of the nuisance is held as described, as a calibration holds it: a step along it can be degrees long, and is of first order
/// only.
pub fn refit(inputs: &Inputs, competition: &Competition, members: &[usize], linear: &LinearFit) -> Refit {
    in_order(inputs, competition, members, linear).unwrap_or_else(|| Refit {
        values: with_nuisance(inputs.model, competition, linear),
        parameters: (0..members.len()).map(|step| linear.parameters(step)).collect(),
    })
}

/// The laws first where curves hold some of them, then those curves.
fn in_order(inputs: &Inputs, competition: &Competition, members: &[usize], linear: &LinearFit) -> Option<Refit> {
    let hypotheses = &competition.problem.hypotheses;
    let holds = |curve: usize| members.iter().any(|&law| hypotheses[curve].holds(&hypotheses[law]));
    let (curves, laws): (Vec<usize>, Vec<usize>) = members.iter().partition(|&&member| holds(member));
    let all: Vec<(usize, Vec<FittedParameter>)> =
        members.iter().enumerate().map(|(step, &member)| (member, linear.parameters(step))).collect();
    if curves.is_empty() {
        return calibrated(inputs, competition, &all, &[], linear.noise);
    }
    let of_laws = linear.of(&laws);
    let start: Vec<(usize, Vec<FittedParameter>)> =
        laws.iter().enumerate().map(|(step, &law)| (law, of_laws.parameters(step))).collect();
    let found = calibrated(inputs, competition, &start, &[], linear.noise)?;
    // Laws elsewhere are fitted with the curves: without these they take up part of what the curves are.
    let is_held = |law: usize| curves.iter().any(|&curve| hypotheses[curve].holds(&hypotheses[law]));
    let (held, elsewhere): (Vec<_>, Vec<_>) =
        laws.into_iter().zip(found.parameters).partition(|(law, _)| is_held(*law));
    let own = all.into_iter().filter(|(member, _)| curves.contains(member));
    let free: Vec<(usize, Vec<FittedParameter>)> = own.chain(elsewhere).collect();
    let Refit { values, parameters } = calibrated(inputs, competition, &free, &held, linear.noise)?;
    let fitted = free.iter().map(|(member, _)| *member).zip(parameters);
    let known: Vec<(usize, Vec<FittedParameter>)> = fitted.chain(held).collect();
    let of = |member: &usize| known.iter().find(|(own, _)| own == member).map(|(_, parameters)| parameters.clone());
    Some(Refit { values, parameters: members.iter().map(of).collect::<Option<Vec<_>>>()? })
}

/// Nuisance and members calibrated from amounts of these, others held. `noise` is over the sigmas, for where none is stated.
fn calibrated(
    inputs: &Inputs,
    competition: &Competition,
    members: &[(usize, Vec<FittedParameter>)],
    held: &[(usize, Vec<FittedParameter>)],
    noise: f64,
) -> Option<Refit> {
    let hypotheses = &competition.problem.hypotheses;
    let mut model = inputs.model.clone();
    for (member, parameters) in held {
        model.switch_on(entry(&hypotheses[*member], parameters));
    }
    let mut slots: Vec<Vec<Slot>> = Vec::new();
    for (member, parameters) in members {
        let hypothesis = &hypotheses[*member];
        if hypothesis.constants.is_empty() {
            model.switch_on(entry(hypothesis, parameters));
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
    let fitted = |criterion: Criterion| {
        let only = Some(only.clone());
        let asked = Settings { only, criterion, second_order: false, hold_far_springs: false, ..Settings::default() };
        calibrate_as_weighed(&model, &competition.campaign, &competition.held_out, &asked, &mut |_| {})
            .ok()
            .filter(Calibration::converged)
    };
    // Noise that is not stated is what is left. Holding all that a millimetre hides may predict better, and then is preferred.
    let found = match competition.campaign.sigma {
        Some(_) => {
            // A noise that is stated far too great would hide all that the readings show.
            let left = competition.calibration.as_ref().map(|of| of.noise_ratio).filter(|left| *left < FAR_BELOW);
            let coarse = fitted(left.map_or(Criterion::Noise, Criterion::NoiseTimes))?;
            // What the noise would hide of a described robot may be needed where constants are far from the description.
            let is_enough = !members.is_empty() || describes(&competition.campaign, &coarse);
            let fine =
                || fitted(Criterion::Relative(DEFAULT_TOLERANCE)).filter(|fine| describes(&competition.campaign, fine));
            if is_enough { coarse } else { fine().unwrap_or(coarse) }
        }
        None => {
            let [coarse, fine] = [1.0, noise].map(|times| fitted(Criterion::NoiseTimes(times)));
            let is_better =
                coarse.as_ref().zip(fine.as_ref()).is_none_or(|(coarse, fine)| predicts_as_well(coarse, fine));
            if is_better { coarse.or(fine) } else { fine }?
        }
    };
    let mut values = found.values.clone();
    let mut parameters = Vec::new();
    for ((member, start), slots) in members.iter().zip(&slots) {
        let is_constant = !hypotheses[*member].constants.is_empty();
        let mut own = start.clone();
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
