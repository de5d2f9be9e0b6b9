//! Springs that a fit moved far from what is declared, up to what no instrument tells from free or rigid, though readings hardly
//! tell them.
//!
//! Where noise outweighs what a spring does, the best fit may lie anywhere between rigid and soft. Such a spring is held as
//! declared instead, unless the weighted squares of the readings rise by it (likelihood ratio; Seber and Wild, *Nonlinear
//! Regression*, 1989, sec. 5.3) by more than a declared value that far off is unlikely.

use super::calibration::calibrate_as_asked;
use super::determined::{calibrate_determined, predicts_as_well, with_noise_found};
use super::far::squares;
use super::result::{Calibration, CalibrationError, Estimate};
use super::settings::Settings;
use super::shared::SharedError;
use super::task::Request;
use crate::description::campaign::Campaign;
use crate::identifiability::Why;
use crate::least_squares::Progress;
use crate::math::quantiles::f_tail;
use crate::model::Model;
use crate::parameter::{Group, Kind, Slot};

/// Calibrates `model` on the readings of `campaign` that are not `held_out`, weighed by the noise that they have: of a campaign
/// that comes from [`super::weighed`]. Springs that would end far off without need are held as declared, and count as weak.
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
    let request = Request { model, campaign, held_out, settings };
    let of_noise = with_noise_found(request, progress)?;
    let settings = of_noise.as_ref().unwrap_or(settings);
    let request = request.with(settings);
    let mut found = calibrate_determined(request, progress)?;
    let mut held: Vec<Slot> = Vec::new();
    while found.converged() {
        let far: Vec<(Slot, f64)> =
            far_off(model, &found, settings).into_iter().filter(|(slot, _)| !held.contains(slot)).collect();
        let alone = far.iter().map(|one| vec![*one]).filter(|_| far.len() > 1);
        let tried = (!far.is_empty()).then(|| far.clone()).into_iter().chain(alone);
        let mut refit = |more: Vec<(Slot, f64)>| {
            let all: Vec<Slot> = held.iter().copied().chain(more.iter().map(|(slot, _)| *slot)).collect();
            let names = all.iter().map(|slot| model.registry[*slot].name.clone());
            let hold = settings.hold.iter().cloned().chain(names).collect();
            let asked = Settings { hold, ..settings.clone() };
            let other = calibrate_as_asked(request.with(&asked), progress).ok()?;
            let unlikely: f64 = more.iter().map(|(_, unlikely)| unlikely).sum();
            let chance = f_tail(unlikely / more.len() as f64, more.len() as f64, MANY);
            let is_needed = rise_by_chance(campaign, &found, &other, more.len()) < chance;
            // One that is not far off is held only where readings held out are no worse for it.
            let is_far = more.iter().all(|(_, unlikely)| *unlikely > 1.0);
            let is_borne = is_far || predicts_as_well(&other, &found);
            (other.converged() && !is_needed && is_borne).then_some((all, other))
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

/// Springs among `only` that [`calibrate_as_weighed`] holds as declared, and that `found`, which holds none that end within their bounds, has
/// fitted far off; empty where it does not converge.
pub fn held_springs(model: &Model, campaign: &Campaign, found: &Calibration, only: &[Slot]) -> Vec<Slot> {
    let settings = Settings { only: Some(only.to_vec()), second_order: false, ..Settings::default() };
    if far_off(model, found, &settings).is_empty() {
        return Vec::new();
    }
    let Ok(other) = calibrate_as_weighed(model, campaign, &found.held_out, &settings, &mut |_| {}) else {
        return Vec::new();
    };
    let others = if other.converged() { other.kept_slots() } else { return Vec::new() };
    let is_held = |slot: &Slot| model.registry[*slot].group == Group::Elastic && !others.contains(slot);
    found.kept_slots().into_iter().filter(is_held).collect()
}

/// Standard deviation of the logarithm of a declared spring: data sheets, sections of beams and springs of like robots tell it to a
/// factor of three or so. A judgement; the readings of a usual campaign outweigh it by far.
const SPREAD: f64 = 3.0;

/// Squares of standard deviations that suffice against any declared value: noise reaches them once in twenty times, as with the
/// usual intervals.
const USUAL: f64 = 3.84;

/// The same where a fit ends at what no instrument tells from free or rigid: once in a thousand times.
const CERTAIN: f64 = 10.83;

/// Degrees of freedom of a variance that is known.
const MANY: f64 = 1e6;

/// Springs that ended further off than the spread, and the squares of standard deviations by which their declared values would be
/// off. Those at a bound of their own are where a description wants them.
fn far_off(model: &Model, found: &Calibration, settings: &Settings) -> Vec<(Slot, f64)> {
    let of = |own: &Estimate| {
        let parameter = &model.registry[own.slot];
        let is_end = own.at_bound && parameter.is_own_bound(own.value);
        let is_declared = own.nominal > 0.0 && parameter.kind != Kind::Length;
        let is_spring = parameter.group == Group::Elastic && is_declared && own.ci95.is_some() && !is_end;
        let apart = (own.value / own.nominal).ln().abs() / SPREAD.ln();
        let unlikely = if own.at_bound { CERTAIN } else { apart.powi(2).min(USUAL) };
        // An interval that holds twice what is declared, and nothing of it, says no more than the description.
        let is_unknown = own.ci95.is_some_and(|half| half > own.nominal.max(own.value));
        let is_far = own.at_bound || settings.hold_far_springs && (apart > 1.0 || is_unknown);
        (is_spring && is_far).then_some((own.slot, unlikely))
    };
    found.estimates.iter().filter_map(of).collect()
}

/// Probability that the squares of the fitted readings rise as they do where so many springs are held, if these are as declared.
fn rise_by_chance(campaign: &Campaign, free: &Calibration, held: &Calibration, count: usize) -> f64 {
    let (before, freedom) = (squares(campaign, free), free.degrees_of_freedom.max(1.0));
    let shared = free.shared.map_or(1.0, |error| design_effect(campaign, &free.held_out, &error));
    let ratio = (squares(campaign, held) - before) / (count as f64 * shared * before / freedom);
    f_tail(ratio, count as f64, freedom)
}

/// How many times as far as independent readings would let it, a mean scatters whose readings share errors with others of their
/// configuration: the design effect of groups of unequal size (Kish, *Survey Sampling*, 1965, sec. 5.4), 1 where each stands alone.
fn design_effect(campaign: &Campaign, held_out: &[bool], error: &SharedError) -> f64 {
    let first = campaign.configurations();
    let mut counts = vec![0.0; campaign.poses.len()];
    let fitted = campaign.readings.iter().zip(held_out).filter(|(_, held_out)| !**held_out);
    fitted.for_each(|(reading, _)| counts[first[reading.pose]] += 1.0);
    let [all, squares] = [1, 2].map(|power| counts.iter().map(|count: &f64| count.powi(power)).sum::<f64>());
    let (own, shared) = (error.own.powi(2), error.shared.powi(2));
    (own + squares / f64::max(all, 1.0) * shared) / (own + shared).max(f64::MIN_POSITIVE)
}
