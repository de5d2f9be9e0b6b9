//! `transmission-error`: periodic error of the joint angle (eccentricity, gear mesh).

use std::f64::consts::TAU;
use std::sync::Arc;

use super::law::{Law, nothing};
use crate::model::{Change, Changes, EffectParameter, Nonlinear, NonlinearKind, NonlinearValue, Site, SiteKind};

nonlinear! {
    pub(super) ORDER "order", NonlinearKind::Real { unit: "1", is_continuous: true, is_positive: true } =>
        "periods in a turn of the joint";
}

/// Orders that are tried: eccentricities and the wave generator of a strain wave gear (1, 2) to slow meshes (20). Those
/// of faster meshes would need more configurations than a campaign has.
const ORDERS: [f64; 14] = [1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 10.0, 12.0, 16.0, 20.0];

/// Periods that joints turned through at least, before an order that is no whole number is tried: what repeats is a period. Whole ones are
/// of parts that turn with the joint.
const SEEN: f64 = 2.0;

pub(super) static LAW: Law = Law {
    name: "transmission-error",
    sits_at: SiteKind::Joint,
    signature: "an angle of one joint that swings with the joint, once or several times a turn",
    remedy: "measure the joint over a turn and map it in the controller; inspect bearing seats and gear mesh",
    nonlinear: &[&ORDER],
    candidates: |model, site, _| {
        let turns = model.frames[site.frame].joint == crate::description::raw::JointKind::Revolute;
        let of = |order: f64| Nonlinear::new([(&ORDER, NonlinearValue::Real(order))]);
        if turns { ORDERS.map(of).to_vec() } else { Vec::new() }
    },
    is_identifiable: |site, survey, nonlinear| {
        let order = nonlinear.continuous().unwrap_or_default();
        let range = site.coordinate.and_then(|own| survey.ranges.get(own)).map_or(0.0, |[least, most]| most - least);
        order.fract() == 0.0 || order * range >= SEEN * TAU
    },
    parameters: Some(|_, _, _| ["cos", "sin"].map(|symbol| EffectParameter::new(symbol, "rad", 3e-4)).to_vec()),
    changes: |_, site, nonlinear| {
        let [NonlinearValue::Real(order)] = nonlinear.values()[..] else { return nothing() };
        periodic(site, order)
    },
    period: turn_over_order,
    ..Law::NOTHING
};

/// The period of what swings so many times in a turn.
pub(super) fn turn_over_order(nonlinear: &Nonlinear) -> Option<f64> {
    nonlinear.continuous().filter(|order| *order > 0.0).map(|order| TAU / order)
}

/// A joint's angle swings so many times in its turn: by cosine and sine, rad.
pub(super) fn periodic(site: &Site, order: f64) -> Changes {
    let (Some(variable), joint) = (site.coordinate, site.frame) else { return nothing() };
    Arc::new(move |context, out| {
        let (sine, cosine) = (order * context.joints[joint]).sin_cos();
        out.push((0, Change::Joint(variable, cosine)));
        out.push((1, Change::Joint(variable, sine)));
    })
}
