//! `joint-coupling`: a joint moves with another joint.

use std::sync::Arc;

use super::law::{Law, nothing};
use crate::model::{Change, EffectParameter, Nonlinear, NonlinearKind, NonlinearValue, SiteKind};

nonlinear! {
    VARIABLE "variable", NonlinearKind::Variable =>
        "the one that the joint follows";
}

pub(super) static LAW: Law = Law {
    name: "joint-coupling",
    sits_at: SiteKind::Joint,
    signature: "an angle of one joint that grows in proportion to another joint",
    remedy: "check the coupling matrix of the wrist or linkage in the controller",
    nonlinear: &[&VARIABLE],
    misplaced: |site, nonlinear| {
        let is_itself = site.coordinate.is_some_and(|own| nonlinear.values() == [NonlinearValue::Variable(own)]);
        is_itself.then_some((VARIABLE.name, "name another variable: a joint's own ratio is `gear-ratio`"))
    },
    candidates: |model, site, _| {
        let others = (0..model.variables.len()).filter(|&other| model.only_driver(site.frame) != Some(other));
        others.map(|variable| Nonlinear::new([(&VARIABLE, NonlinearValue::Variable(variable))])).collect()
    },
    parameters: Some(|_, _, _| vec![EffectParameter::new("ratio", "1", 1e-3)]),
    changes: |_, site, nonlinear| {
        let Some(variable) = site.coordinate else { return nothing() };
        match nonlinear.values()[..] {
            [NonlinearValue::Variable(other)] => {
                Arc::new(move |context, out| out.push((0, Change::Joint(variable, context.q[other]))))
            }
            _ => nothing(),
        }
    },
    ..Law::NOTHING
};
