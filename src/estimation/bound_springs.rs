//! Springs that a fit left at the end of what a description can hold, free or rigid to any instrument, though readings hardly
//! tell them.
//!
//! Where noise outweighs what a spring does, the best fit may lie at that end, where it moves nothing and its interval says
//! nothing. (A compliance of zero is no such end: it is an estimate like others, with an interval.) Such a spring is held as declared instead, if the readings fit as well with it: their weighted squares do not rise
//! by more than chance (likelihood ratio of one parameter; Seber and Wild, *Nonlinear Regression*, 1989, sec. 5.3), or do so
//! in no more configurations than chance has it.

use super::calibration::calibrate_as_asked;
use super::problem::row_sigmas;
use super::result::{Calibration, CalibrationError};
use super::settings::Settings;
use crate::description::campaign::Campaign;
use crate::identifiability::Why;
use crate::least_squares::Progress;
use crate::math::quantiles::t95;
use crate::model::Model;
use crate::parameter::{Group, Slot};

/// Calibrates `model` on the readings of `campaign` that are not `held_out`, weighed by the noise that they have: of a campaign
/// that comes from [`super::weighed`]. Springs that would end at a bound without need are held as declared, and count as weak.
///
/// # Errors
/// As [`super::calibrate`].
pub fn calibrate_as_weighed(
    model: &Model,
    campaign: &Campaign,
    held_out: &[bool],
    settings: &Settings,
    progress: &mut dyn FnMut(&Progress),
) -> Result<Calibration, CalibrationError> {
    let mut found = calibrate_as_asked(model, campaign, held_out, settings, progress)?;
    let mut held: Vec<Slot> = Vec::new();
    while found.converged() {
        let ended = ended(model, &found);
        let alone = ended.iter().map(|slot| vec![*slot]).filter(|_| ended.len() > 1);
        let tried = (!ended.is_empty()).then(|| ended.clone()).into_iter().chain(alone);
        let mut refit = |more: Vec<Slot>| {
            let all = [held.as_slice(), &more].concat();
            let names = all.iter().map(|slot| model.registry[*slot].name.clone());
            let hold = settings.hold.iter().cloned().chain(names).collect();
            let asked = Settings { hold, ..settings.clone() };
            let other = calibrate_as_asked(model, campaign, held_out, &asked, progress).ok()?;
            (other.converged() && !is_needed(campaign, &found, &other, more.len())).then_some((all, other))
        };
        let Some((all, other)) = tried.into_iter().find_map(&mut refit) else { break };
        (held, found) = (all, other);
    }
    for (column, why) in &mut found.identifiability.dropped {
        if found.slots.get(*column).is_some_and(|slot| held.contains(slot)) {
            *why = Why::Weak;
        }
    }
    Ok(found)
}

/// Springs at a bound that is not one of the parameter's own.
fn ended(model: &Model, found: &Calibration) -> Vec<Slot> {
    let is_end = |slot: Slot, value: f64| {
        let parameter = &model.registry[slot];
        parameter.group == Group::Elastic && !parameter.bounds.contains(&value)
    };
    let ended = found.estimates.iter().filter(|own| own.at_bound && is_end(own.slot, own.value));
    ended.map(|own| own.slot).collect()
}

/// Whether the fitted readings are certainly worse with so many springs held than with them at their bounds.
fn is_needed(campaign: &Campaign, free: &Calibration, held: &Calibration, count: usize) -> bool {
    let sigmas = row_sigmas(campaign);
    let configurations = campaign.configurations();
    let poses = configurations.iter().max().map_or(0, |last| last + 1);
    let by_pose = |found: &Calibration| {
        let weighted: Vec<f64> = found.residual.iter().zip(&sigmas).map(|(left, sigma)| left / sigma).collect();
        let mut squares = vec![0.0; poses];
        for (index, (reading, own)) in campaign.by_reading(&weighted, 1).enumerate() {
            if free.held_out.get(index) != Some(&true) {
                squares[configurations[reading.pose]] += own.iter().map(|left| left * left).sum::<f64>();
            }
        }
        squares
    };
    let (before, after) = (by_pose(free), by_pose(held));
    let rises: Vec<f64> =
        before.iter().zip(&after).filter(|(b, a)| **b > 0.0 || **a > 0.0).map(|(b, a)| a - b).collect();
    let (n, total) = (rises.len() as f64, rises.iter().sum::<f64>());
    let variance = before.iter().sum::<f64>() / free.degrees_of_freedom.max(1.0);
    let limit = t95(free.degrees_of_freedom.max(1.0));
    let scatter = rises.iter().map(|rise| (rise - total / n).powi(2)).sum::<f64>();
    let error = (scatter * n / (n - 1.0).max(1.0)).sqrt();
    total > limit * limit * variance * count as f64 && total > t95((n - 1.0).max(1.0)) * error
}
