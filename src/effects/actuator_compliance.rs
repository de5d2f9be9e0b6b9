//! `actuator-compliance`: axial spring of a ball screw, so that the joint's stiffness changes with the pose.

use super::law::Law;
use crate::model::{Family, SiteKind};

pub(super) static LAW: Law = Law {
    name: "actuator-compliance",
    sits_at: SiteKind::Actuator,
    family: Some(|_| Family::Elastic),
    signature: "an angle of one joint in proportion to its load over the squared lever of its screw: largest where the lever is short",
    remedy: "identify the axial stiffness; preload or replace nut and bearing",
    constants: |model, site, _| {
        let actuator = site.actuator.and_then(|actuator| model.actuators.get(actuator));
        model.slots_named(actuator.map(|actuator| format!("{}.axial", actuator.name)))
    },
    ..Law::NOTHING
};
