//! `hysteresis`: lost motion of a joint that builds up over its path, as friction in gears and bearings does.
//!
//! Dahl's law (*A solid friction model*, 1968): the state `h` tends to the direction of motion over a distance, `dh/dq = (sign
//! dq - h) / distance`, so that small moves change it by a part and former moves are forgotten as new ones are made.

use std::sync::Arc;

use super::law::{Law, nothing};
use crate::model::{Change, Condition, EffectParameter, Nonlinear, NonlinearKind, NonlinearValue, SiteKind};

nonlinear! {
    DISTANCE "distance", NonlinearKind::Real { unit: "rad or m", is_continuous: true, is_positive: true } =>
        "the motion over which the joint comes to the other flank, rad or m";
}

/// Distances that are tried, as shares of the greatest move: from a jump with the side of approach to what a lag is.
const SHARES: [f64; 4] = [0.01, 0.05, 0.2, 0.6];

pub(super) static LAW: Law = Law {
    name: "hysteresis",
    sits_at: SiteKind::Joint,
    signature: "an angle of one joint that depends on the path by which it came, less on small moves than on large ones",
    remedy: "approach all poses from one side and from far; look at friction and preload of the gear",
    reads: &[Condition::LastMove],
    nonlinear: &[&DISTANCE],
    cancels_in_differences: true,
    candidates: |_, site, survey| {
        let greatest = site.of(&survey.greatest_moves).copied().filter(|greatest| *greatest > 0.0);
        let Some(greatest) = greatest else { return Vec::new() };
        SHARES.map(|share| Nonlinear::new([(&DISTANCE, NonlinearValue::Real(share * greatest))])).to_vec()
    },
    // A jump with the side of approach, and a lag in proportion to the last move.
    is_another_at_ends: |_| [true; 2],
    parameters: Some(|_, _, _| vec![EffectParameter::new("half_width", "rad", 3e-4).positive()]),
    changes: |_, site, nonlinear| {
        let [NonlinearValue::Real(distance)] = nonlinear.values()[..] else { return nothing() };
        let Some(variable) = site.coordinate else { return nothing() };
        Arc::new(move |context, out| {
            let (mut state, mut memory) = (0.0, 1.0);
            for moved in context.moves(variable) {
                let kept = (-moved.abs() / distance).exp();
                state += memory * moved.signum() * (1.0 - kept);
                memory *= kept;
            }
            // Friction keeps the joint behind: on the side from which it came.
            out.push((0, Change::Joint(variable, -state)));
        })
    },
    ..Law::NOTHING
};
