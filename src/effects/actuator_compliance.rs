//! `actuator-compliance`: axial spring of a ball screw, so that the joint's stiffness changes with the pose.

use crate::model::{Effect, Family, Model, Nonlinear, Site, SiteKind};
use crate::parameter::Slot;

/// See the module.
pub struct ActuatorCompliance;

impl Effect for ActuatorCompliance {
    fn name(&self) -> &'static str {
        "actuator-compliance"
    }

    fn family(&self, _nonlinear: &Nonlinear) -> Family {
        Family::Elastic
    }

    fn sits_at(&self) -> SiteKind {
        SiteKind::Actuator
    }

    fn signature(&self) -> &'static str {
        "an angle of one joint in proportion to its load over the squared lever of its screw: largest where the lever is short"
    }

    fn remedy(&self) -> &'static str {
        "identify the axial stiffness; preload or replace nut and bearing"
    }

    fn constants(&self, model: &Model, site: &Site, _nonlinear: &Nonlinear) -> Vec<Slot> {
        model.slots_named([format!("{}.axial", model.actuators[site.actuator].name)])
    }
}
