//! `backlash`: lost motion of a joint, by the side of approach, by the sign of the load, or by both: friction holds the flank of
//! the approach until the load overcomes it.

use std::sync::Arc;

use super::law::{Law, nothing};
use crate::model::{Change, Condition, EffectParameter, Family, Nonlinear, NonlinearKind, NonlinearValue, SiteKind};

const APPROACH: &str = "approach";
const LOAD: &str = "load";
const FRICTION: &str = "friction";
nonlinear! {
    BY "by", NonlinearKind::Choice(&[APPROACH, LOAD, FRICTION]), or NonlinearValue::Choice(APPROACH) =>
        "the joint lies on the flank from which it approached, on the one to which the load presses it, or on the former until \
         the load overcomes friction";
    CHANGES_AT "changes_at", NonlinearKind::Real { unit: "N.m", is_continuous: true, is_positive: true }, with "by" LOAD =>
        "the load at which the joint has crossed to the other flank, N.m or N";
    OVERCOME_AT "overcome_at", NonlinearKind::Real { unit: "N.m", is_continuous: true, is_positive: true }, with "by" FRICTION =>
        "the load that overcomes the friction which holds the flank of the approach, N.m or N";
}

/// Loads at which the joint is tried to cross, as shares of the greatest: far below it, where a joint changes its flank
/// near balance.
const SHARES: [f64; 4] = [0.01, 0.02, 0.04, 0.07];

/// Loads that are tried to overcome friction, as shares of the greatest: from where the load decides nearly always to where the
/// approach does.
const OF_FRICTION: [f64; 3] = [0.15, 0.35, 0.7];

/// Over this share of the load that overcomes friction a joint crosses: the law is smooth, so that the load can be fitted.
const CROSSING: f64 = 0.1;

pub(super) static LAW: Law = Law {
    name: "backlash",
    sits_at: SiteKind::Joint,
    family: Some(|nonlinear| match nonlinear.values()[..] {
        [NonlinearValue::Choice(LOAD), ..] => Family::Elastic,
        _ => Family::History,
    }),
    signature: "two populations of one joint: the angle jumps with the side of approach, or with the sign of the load",
    remedy: "approach from one side only; readjust the gear or belt",
    reads: &[Condition::Approach],
    nonlinear: &[&BY, &CHANGES_AT, &OVERCOME_AT],
    candidates: |_, site, survey| {
        let mut candidates = Vec::new();
        let has_sides = site.of(&survey.sides) == Some(&true) && !survey.is_difference;
        if has_sides {
            candidates.push(Nonlinear::new([(&BY, NonlinearValue::Choice(APPROACH))]));
        }
        if let Some(&load) = site.of(&survey.greatest_load).filter(|load| **load > 0.0) {
            let by_load = (&BY, NonlinearValue::Choice(LOAD));
            let at = |share: f64| Nonlinear::new([by_load.clone(), (&CHANGES_AT, NonlinearValue::Real(share * load))]);
            candidates.extend(SHARES.map(at));
            if has_sides {
                let by_both = (&BY, NonlinearValue::Choice(FRICTION));
                let load_of = |share: f64| NonlinearValue::Real(share * load);
                let at = |share: f64| Nonlinear::new([by_both.clone(), (&OVERCOME_AT, load_of(share))]);
                candidates.extend(OF_FRICTION.map(at));
            }
        }
        candidates
    },
    // A joint that crosses under its greatest loads is a soft one.
    is_another_at_ends: |nonlinear| [false, matches!(nonlinear.values()[..], [NonlinearValue::Choice(LOAD), ..])],
    parameters: Some(|_, _, _| vec![EffectParameter::new("half_width", "rad", 3e-4).positive()]),
    changes: |_, site, nonlinear| {
        let Some(v) = site.coordinate else { return nothing() };
        match nonlinear.values()[..] {
            [NonlinearValue::Choice(FRICTION), NonlinearValue::Real(at)] => Arc::new(move |context, out| {
                let flank = |load: f64| ((load + at * context.side[v]) / (CROSSING * at)).tanh();
                out.push((0, Change::Deflection(v, context.of_load(v, flank))));
            }),
            [_, NonlinearValue::Real(at)] => Arc::new(move |context, out| {
                out.push((0, Change::Deflection(v, context.of_load(v, |load| (load / at).tanh()))));
            }),
            _ => Arc::new(move |context, out| out.push((0, Change::Joint(v, context.side[v])))),
        }
    },
    ..Law::NOTHING
};
