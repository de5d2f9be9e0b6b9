//! Springs that a fit left where no such spring is, free or rigid, though readings hardly tell them.
//!
//! Where noise outweighs what a spring does, the best fit may lie at the end of what a description can hold, where the spring moves
//! nothing and its interval says nothing, or far from the declared value with an interval that reaches back to it. Such a spring
//! is held as declared instead, unless the weighted squares of the readings certainly rise by it (likelihood ratio; Seber and
//! Wild, *Nonlinear Regression*, 1989, sec. 5.3).

use super::calibration::calibrate_as_asked;
use super::determined::calibrate_determined;
use super::problem::row_sigmas;
use super::result::{Calibration, CalibrationError, Estimate};
use super::settings::Settings;
use crate::description::campaign::Campaign;
use crate::identifiability::Why;
use crate::least_squares::Progress;
use crate::math::quantiles::f_tail;
use crate::model::Model;
use crate::parameter::{Group, Slot};

/// Calibrates `model` on the readings of `campaign` that are not `held_out`, weighed by the noise that they have: of a campaign
/// that comes from [`super::weighed`]. Springs that would end at an implausible value without need are held as declared, and count as
/// weak.
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

/// Factor from what is declared beyond which a spring is implausible: the stiffness of a known kind of joint is seldom guessed
/// further off (as [`crate::plausibility::Limits`] has it of all springs together).
const IMPLAUSIBLE: f64 = 30.0;

/// Greatest probability of a rise by chance at which readings contradict the declared value: an implausible one needs more than
/// the one in twenty of usual intervals.
const CHANCE: f64 = 1e-3;

/// Springs that are described, at an implausible value that is none of their own bounds but rigid, or whose interval reaches
/// plausible ones.
fn ended(model: &Model, found: &Calibration) -> Vec<Slot> {
    let is_implausible = |own: &&Estimate| {
        let parameter = &model.registry[own.slot];
        if parameter.group != Group::Elastic || !(own.nominal > 0.0 && own.nominal.is_finite()) {
            return false;
        }
        let [least, most] = [own.nominal / IMPLAUSIBLE, own.nominal * IMPLAUSIBLE];
        let width = own.ci95.filter(|width| width.is_finite()).unwrap_or(f64::INFINITY);
        let is_bound = own.at_bound && (own.value == 0.0 || !parameter.bounds.contains(&own.value));
        is_bound && !(least..=most).contains(&own.value)
            || own.value < least && own.value + width >= least
            || own.value > most && own.value - width <= most
    };
    found.estimates.iter().filter(is_implausible).map(|own| own.slot).collect()
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
