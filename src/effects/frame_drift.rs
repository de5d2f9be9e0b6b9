//! `frame-drift`: the measurement frame moves with time, or jumps.

use std::sync::Arc;

use super::law::{Law, base_moves};
use crate::model::{Condition, EffectParameter, Nonlinear, NonlinearKind, NonlinearValue, SiteKind, Survey};

const STEADY: &str = "steady";
const JUMP: &str = "jump";
nonlinear! {
    COURSE "course", NonlinearKind::Choice(&[STEADY, JUMP]), or NonlinearValue::Choice(STEADY) =>
        "the frame moves steadily, or all at once";
    JUMP_AT "jump_at", NonlinearKind::Real { unit: "s", is_continuous: false, is_positive: false }, with "course" JUMP =>
        "the time of the jump, s";
}

/// Most times of a jump that are tried: readings between the true one and the nearest tried are outliers to the law.
pub(super) const MOST_TIMES: usize = 60;
/// Configurations before and after a jump, at least: fewer than three are outliers.
const LEAST_BEFORE: usize = 3;

pub(super) static LAW: Law = Law {
    name: "frame-drift",
    sits_at: SiteKind::Base,
    signature: "all readings move together with time, steadily or at one time, whatever the posture",
    remedy: "fasten tracker and robot; measure a fixed target between poses",
    reads: &[Condition::Time],
    nonlinear: &[&COURSE, &JUMP_AT],
    is_of_the_measurement: true,
    cancels_in_differences: true,
    candidates: |_, _, survey| {
        let (Some(&first), Some(&last)) = (survey.times.first(), survey.times.last()) else { return Vec::new() };
        if last <= first {
            return Vec::new();
        }
        let steady = Nonlinear::new([(&COURSE, NonlinearValue::Choice(STEADY))]);
        let jumps = jumps(survey, MOST_TIMES)
            .map(|at| Nonlinear::new([(&COURSE, NonlinearValue::Choice(JUMP)), (&JUMP_AT, NonlinearValue::Real(at))]));
        std::iter::once(steady).chain(jumps).collect()
    },
    parameters: Some(|_, _, nonlinear| {
        let (length, angle, scale) = match jump_at(nonlinear) {
            None => ("m/s", "rad/s", 1e-8),
            Some(_) => ("m", "rad", 1e-4),
        };
        let units = [("x", length), ("y", length), ("z", length), ("rx", angle), ("ry", angle), ("rz", angle)];
        units.map(|(symbol, unit)| EffectParameter::new(symbol, unit, scale)).to_vec()
    }),
    changes: |_, _, nonlinear| {
        let jump_at = jump_at(nonlinear);
        Arc::new(move |context, out| {
            let Some(time) = context.time else { return };
            let amount = jump_at.map_or(time, |at| f64::from(u8::from(time >= at)));
            base_moves(context, amount, 0, out);
        })
    },
    ..Law::NOTHING
};

/// At most so many times between two configurations at which something may have jumped, s.
pub(super) fn jumps(survey: &Survey, most: usize) -> impl Iterator<Item = f64> {
    let times = &survey.times[..];
    let between = times.len().saturating_sub(2 * LEAST_BEFORE);
    let most = most.min(between);
    (1..=most).map(move |k| {
        let after = LEAST_BEFORE + between * k / (most + 1);
        0.5 * (times[after - 1] + times[after])
    })
}

/// Time of the jump, s; none of a steady drift.
fn jump_at(nonlinear: &Nonlinear) -> Option<f64> {
    match nonlinear.values()[..] {
        [_, NonlinearValue::Real(at)] => Some(at),
        _ => None,
    }
}
