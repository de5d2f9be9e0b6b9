//! `joint-stiffening`: a joint spring that is not linear in the torque: soft at small loads, stiff once wound up.

use std::sync::Arc;

use super::law::{Law, nothing};
use crate::model::{Change, EffectParameter, Family, Nonlinear, NonlinearKind, NonlinearValue, SiteKind};

nonlinear! {
    WOUND_UP_AT "wound_up_at", NonlinearKind::Real { unit: "N.m", is_continuous: true, is_positive: true } =>
        "the load at which the soft part is wound up, N.m or N";
}

/// Loads at which the soft part is tried to be wound up, as shares of the greatest; each about 1.5 times the one before,
/// so that the diagnosis refines between them.
const SHARES: [f64; 8] = [0.07, 0.1, 0.15, 0.22, 0.33, 0.5, 0.8, 1.2];

pub(super) static LAW: Law = Law {
    name: "joint-stiffening",
    sits_at: SiteKind::Joint,
    family: Some(|_| Family::Elastic),
    signature: "an angle of one joint that grows with small loads and then hardly any more",
    remedy: "preload the gear; identify at the loads of the process",
    nonlinear: &[&WOUND_UP_AT],
    candidates: |_, site, survey| {
        let greatest = site.of(&survey.greatest_load).copied().unwrap_or_default();
        let at = |share: f64| Nonlinear::new([(&WOUND_UP_AT, NonlinearValue::Real(share * greatest))]);
        if greatest > 0.0 { SHARES.map(at).to_vec() } else { Vec::new() }
    },
    // Wound up by the least loads it is play, by loads beyond all that occur a linear spring.
    is_another_at_ends: |_| [true; 2],
    parameters: Some(|_, _, _| vec![EffectParameter::new("wind_up", "rad", 3e-4).positive()]),
    changes: |_, site, nonlinear| {
        let Some(v) = site.coordinate else { return nothing() };
        let [NonlinearValue::Real(at)] = nonlinear.values()[..] else { return nothing() };
        let at = at.max(f64::MIN_POSITIVE);
        Arc::new(move |context, out| {
            out.push((0, Change::Deflection(v, context.of_load(v, |load| (load / at).tanh()))));
        })
    },
    ..Law::NOTHING
};
