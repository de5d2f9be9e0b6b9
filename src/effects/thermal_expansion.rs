//! `thermal-expansion`: the length of a link follows temperature, at once or with a delay.
//!
//! A thermometer in the air, or on the casting, shows what the metal feels later. A body that heats evenly follows with one
//! time constant (lumped capacitance; Incropera et al., *Fundamentals of Heat and Mass Transfer*, sec. 5.1).

use std::sync::Arc;

use super::law::{Law, nothing};
use crate::model::{
    Change, Condition, EffectParameter, Model, Nonlinear, NonlinearKind, NonlinearValue, Site, SiteKind,
};
use crate::parameter::Slot;

nonlinear! {
    /// The default is what versions up to 0.1 assumed. A diagnosis takes the mean of the campaign, in whatever unit its
    /// temperatures are, so that the effect leaves the mean lengths as calibrated.
    REFERENCE "reference", NonlinearKind::Real { unit: "degC or K as measured", is_continuous: false, is_positive: false }, or NonlinearValue::Real(20.0) =>
        "the temperature at which the lengths of the description hold";
}
const AT_ONCE: &str = "at-once";
const DELAYED: &str = "delayed";
nonlinear! {
    COURSE "course", NonlinearKind::Choice(&[AT_ONCE, DELAYED]), or NonlinearValue::Choice(AT_ONCE) =>
        "the link has the temperature that is shown, or comes to it with a delay";
    TIME_CONSTANT "time_constant", NonlinearKind::Real { unit: "s", is_continuous: true, is_positive: true }, with "course" DELAYED =>
        "of the delay, s";
}
/// Time constants that are tried, as shares of the longest session: shorter ones are no delay, longer ones show little of
/// what the thermometer does.
const SHARES: [f64; 2] = [0.05, 0.2];
/// Lengths below this one, m, expand by nothing that shows.
const LEAST_LENGTH: f64 = 1e-3;

pub(super) static LAW: Law = Law {
    name: "thermal-expansion",
    sits_at: SiteKind::Link,
    cancels_in_differences: true,
    signature: "a link grows in step with the temperature, or as the robot warms up",
    remedy: "warm the robot up; measure temperatures and scale the link",
    reads: &[Condition::Temperature],
    nonlinear: &[&REFERENCE, &COURSE, &TIME_CONSTANT],
    candidates: |model, site, survey| {
        let mean = survey.mean_temperature(site).filter(|_| !lengths(model, site).is_empty());
        let Some(mean) = mean else { return Vec::new() };
        let of = |course| vec![(&REFERENCE, NonlinearValue::Real(mean)), (&COURSE, NonlinearValue::Choice(course))];
        let delays = survey.longest_session.into_iter().flat_map(|longest| SHARES.map(|share| share * longest));
        let delayed = delays.map(|delay| {
            Nonlinear::new(of(DELAYED).into_iter().chain([(&TIME_CONSTANT, NonlinearValue::Real(delay))]))
        });
        std::iter::once(Nonlinear::new(of(AT_ONCE))).chain(delayed).collect()
    },
    parameters: Some(|_, _, _| vec![EffectParameter::new("expansion", "1/K", 1.2e-5)]),
    thermal_delay: |nonlinear| nonlinear.continuous(),
    changes: |model, site, nonlinear| {
        let Some(&NonlinearValue::Real(reference)) = nonlinear.values().first() else { return nothing() };
        let lengths = lengths(model, site);
        Arc::new(move |context, out| {
            let Some(temperature) = context.temperature else { return };
            out.extend(
                lengths.iter().map(|&(slot, length)| (0, Change::Slot(slot, length * (temperature - reference)))),
            );
        })
    },
    ..Law::NOTHING
};

/// Lengths of a link, m: constants b, d and r of the frames that it carries.
pub(super) fn lengths(model: &Model, site: &Site) -> Vec<(Slot, f64)> {
    let carried = model.frames.iter().enumerate().skip(1).filter(|(_, frame)| frame.antecedent == site.frame);
    carried
        .flat_map(|(_, frame)| {
            let prismatic = frame.joint == crate::description::raw::JointKind::Prismatic;
            [Some(frame.slots[2]), Some(frame.slots[4]), (!prismatic).then_some(frame.slots[6])]
        })
        .flatten()
        .map(|slot| (slot, model.registry[slot].nominal))
        .filter(|(_, length)| length.abs() > LEAST_LENGTH)
        .collect()
}
