//! Springs that a fit left at the end of what a description can hold, free or rigid to any instrument, though readings hardly
//! tell them.
//!
//! Where noise outweighs what a spring does, the best fit may lie at that end, where it moves nothing and its interval says
//! nothing. (A compliance of zero is no such end: it is an estimate like others, with an interval.) Such a spring is held as
//! declared instead, unless the weighted squares of the readings certainly rise by it (likelihood ratio; Seber and Wild,
//! *Nonlinear Regression*, 1989, sec. 5.3).

use super::calibration::calibrate_as_asked;
use super::determined::calibrate_determined;
use super::problem::row_sigmas;
use super::result::{Calibration, CalibrationError};
use super::settings::Settings;
use crate::description::campaign::Campaign;
use crate::identifiability::Why;
use crate::least_squares::Progress;
use crate::math::quantiles::f_tail;
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
    let mut found = calibrate_determined(model, campaign, held_out, settings, progress)?;
    let mut held: Vec<Slot> = Vec::new();
    while found.converged() {
        let ended: Vec<Slot> = ended(model, &found).into_iter().filter(|slot| !held.contains(slot)).collect();
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

/// Greatest probability of a rise by chance at which readings contradict the declared value: no spring at all, or one that nothing
/// bends, needs more than the one in twenty of usual intervals.
const CHANCE: f64 = 1e-3;

/// Springs at a bound that is not one of the parameter's own.
fn ended(model: &Model, found: &Calibration) -> Vec<Slot> {
    let is_end = |slot: Slot, value: f64| {
        let parameter = &model.registry[slot];
        parameter.group == Group::Elastic && !parameter.bounds.contains(&value)
    };
    let ended = found.estimates.iter().filter(|own| own.at_bound && is_end(own.slot, own.value));
    ended.map(|own| own.slot).collect()
}

/// Whether the fitted readings are certainly worse with so many springs held than with them at their bounds. Readings of one
/// configuration that share an error count once.
fn is_needed(campaign: &Campaign, free: &Calibration, held: &Calibration, count: usize) -> bool {
    let sigmas = row_sigmas(campaign);
    let squares = |found: &Calibration| -> f64 {
        let weighted: Vec<f64> = found.residual.iter().zip(&sigmas).map(|(left, sigma)| left / sigma).collect();
        let own = campaign.by_reading(&weighted, 1).zip(&free.held_out).filter(|(_, held_out)| !**held_out);
        own.flat_map(|((_, own), _)| own).map(|left| left * left).sum()
    };
    let (before, freedom) = (squares(free), free.degrees_of_freedom.max(1.0));
    let shared = free.shared.map_or(1.0, |error| error.ratio.max(1.0));
    let ratio = (squares(held) - before) / (count as f64 * shared * before / freedom);
    f_tail(ratio, count as f64, freedom) < CHANCE
}
