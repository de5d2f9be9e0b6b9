//! `joint-offset`: the encoder zero of a joint.

use super::law::Law;
use crate::description::robot::Motion;
use crate::model::{Family, SiteKind};

pub(super) static LAW: Law = Law {
    name: "joint-offset",
    sits_at: SiteKind::Joint,
    family: Some(|_| Family::Geometry),
    signature: "a constant angle of one joint, in all readings alike",
    remedy: "re-master the joint, or add the offset to the controller",
    // Joints that follow others as well: a belt gives, and has a phase. What a loop moves is held by the loop.
    sites: Some(|model| model.joints_moved_by(|motion| motion != Motion::Passive)),
    constants: |model, site, _| {
        let frame = &model.frames[site.frame];
        match model.actuators.iter().find(|actuator| actuator.joint == site.frame) {
            Some(actuator) => vec![actuator.slot],
            None => vec![frame.moving_slot()],
        }
    },
    ..Law::NOTHING
};
