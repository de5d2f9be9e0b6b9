//! `cable-torque`: a cable or hose that is taut beyond some turn of a joint pulls it back.
//!
//! The pull grows in proportion to the turn beyond the slack, on either side of the middle; the joint gives by it. Without slack
//! it is a gear ratio.

use std::sync::Arc;

use super::law::{Law, nothing};
use crate::model::{Change, EffectParameter, Nonlinear, NonlinearKind, NonlinearValue, SiteKind};

nonlinear! {
    SLACK "slack", NonlinearKind::Real { unit: "rad or m", is_continuous: true, is_positive: false } =>
        "the turn to either side of `middle` at which the cable is taut, rad or m";
    MIDDLE "middle", NonlinearKind::Real { unit: "rad or m", is_continuous: false, is_positive: false }, or NonlinearValue::Real(0.0) =>
        "the joint's value at which the cable lies as it was laid, rad or m";
}

/// Slacks that are tried, as shares of half the range.
const SHARES: [f64; 5] = [0.2, 0.35, 0.5, 0.65, 0.8];

pub(super) static LAW: Law = Law {
    name: "cable-torque",
    sits_at: SiteKind::Joint,
    signature: "an angle of one joint that is right in the middle of its range and falls short towards both ends",
    remedy: "lengthen or guide the cable or hose package; measure with it taken off",
    nonlinear: &[&SLACK, &MIDDLE],
    cancels_in_differences: true,
    candidates: |_, site, survey| {
        let Some(&[least, greatest]) = site.of(&survey.ranges) else { return Vec::new() };
        let (middle, half) = (0.5 * (least + greatest), 0.5 * (greatest - least));
        if half.is_nan() || half <= 0.0 {
            return Vec::new();
        }
        let of = |share: f64| {
            let [slack, middle] = [share * half, middle].map(NonlinearValue::Real);
            Nonlinear::new([(&SLACK, slack), (&MIDDLE, middle)])
        };
        SHARES.map(of).to_vec()
    },
    parameters: Some(|_, _, _| vec![EffectParameter::new("pull", "1", 3e-4)]),
    changes: |_, site, nonlinear| {
        let [NonlinearValue::Real(slack), NonlinearValue::Real(middle)] = nonlinear.values()[..] else {
            return nothing();
        };
        let Some(variable) = site.coordinate else { return nothing() };
        Arc::new(move |context, out| {
            let turned = context.q[variable] - middle;
            let taut = (turned.abs() - slack).max(0.0);
            out.push((0, Change::Joint(variable, -turned.signum() * taut)));
        })
    },
    ..Law::NOTHING
};
