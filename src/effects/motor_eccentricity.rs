//! `motor-eccentricity`: periodic error of the motor's side of a gear: its shaft, its encoder, the first pinion.
//!
//! Once or twice a turn of the motor: that many times the gear ratio in a turn of the joint, which is seldom a whole number. Only
//! where the description gives the ratio: searched for blindly, some such order fits any noise.

use super::law::{Law, nothing};
use super::transmission_error::{ORDER, periodic, turn_over_order};
use crate::model::{Condition, EffectParameter, Nonlinear, NonlinearValue, SiteKind};

/// Periods in a turn of the motor: an eccentric shaft, and an elliptic one or a bent coupling.
const PERIODS: [f64; 2] = [1.0, 2.0];

pub(super) static LAW: Law = Law {
    name: "motor-eccentricity",
    sits_at: SiteKind::Joint,
    signature: "an angle of one joint that swings once or twice a turn of its motor",
    remedy: "measure the joint over one turn of its motor in small steps; look at coupling, encoder and first gear stage",
    reads: &[Condition::GearRatio],
    nonlinear: &[&ORDER],
    cancels_in_differences: true,
    candidates: |model, site, _| {
        let ratio = site.of(&model.variables).and_then(|variable| variable.gear_ratio);
        let Some(ratio) = ratio else { return Vec::new() };
        PERIODS.map(|periods| Nonlinear::new([(&ORDER, NonlinearValue::Real(periods * ratio))])).to_vec()
    },
    parameters: Some(|_, _, _| ["cos", "sin"].map(|symbol| EffectParameter::new(symbol, "rad", 1e-4)).to_vec()),
    changes: |_, site, nonlinear| {
        let [NonlinearValue::Real(order)] = nonlinear.values()[..] else { return nothing() };
        periodic(site, order)
    },
    period: turn_over_order,
    ..Law::NOTHING
};
