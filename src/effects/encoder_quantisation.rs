//! `encoder-quantisation`: a joint stands where its encoder's step puts it, not where it was commanded.
//!
//! The angle is rounded to steps, or cut off to the one below; the error is a saw tooth of the step's length.

use std::sync::Arc;

use super::law::{Law, nothing};
use crate::model::{Change, EffectParameter, Nonlinear, NonlinearKind, NonlinearValue, SiteKind};

const ROUNDED: &str = "rounded";
const CUT_OFF: &str = "cut-off";
nonlinear! {
    TO "to", NonlinearKind::Choice(&[ROUNDED, CUT_OFF]), or NonlinearValue::Choice(ROUNDED) =>
        "the nearest step, or the one below";
    STEP "step", NonlinearKind::Real { unit: "rad", is_continuous: false, is_positive: true } =>
        "the step, rad";
}

/// Bits of a turn: coarser encoders are not built into robots, finer ones are negligible against a robot's repeatability.
const BITS: std::ops::RangeInclusive<i32> = 8..=13;

pub(super) static LAW: Law = Law {
    name: "encoder-quantisation",
    sits_at: SiteKind::Joint,
    signature: "an angle of one joint that is off by up to half a step, as a saw tooth over the joint",
    remedy: "command values that are whole steps; evaluate at what the encoder reads; fit a finer encoder",
    nonlinear: &[&TO, &STEP],
    cancels_in_differences: true,
    candidates: |model, site, _| {
        let turns = model.frames[site.frame].joint == crate::description::raw::JointKind::Revolute;
        if !turns {
            return Vec::new();
        }
        let of = |to: &'static str, bits: i32| {
            let step = std::f64::consts::TAU / 2.0_f64.powi(bits);
            Nonlinear::new([(&TO, NonlinearValue::Choice(to)), (&STEP, NonlinearValue::Real(step))])
        };
        BITS.flat_map(|bits| [of(ROUNDED, bits), of(CUT_OFF, bits)]).collect()
    },
    parameters: Some(|_, _, _| vec![EffectParameter::new("share", "1", 1.0)]),
    changes: |_, site, nonlinear| {
        let [NonlinearValue::Choice(to), NonlinearValue::Real(step)] = nonlinear.values()[..] else {
            return nothing();
        };
        let (Some(variable), is_cut) = (site.coordinate, to == CUT_OFF) else { return nothing() };
        Arc::new(move |context, out| {
            let steps = context.q[variable] / step;
            // A constant half step is the joint's zero, which is calibrated.
            let whole = if is_cut { steps.floor() + 0.5 } else { steps.round() };
            out.push((0, Change::Joint(variable, (whole - steps) * step)));
        })
    },
    ..Law::NOTHING
};
