//! `joint-offset`: the encoder zero of a joint.

use crate::description::robot::Motion;
use crate::model::{Effect, Family, Model, Nonlinear, Site, SiteKind};
use crate::parameter::Slot;

/// See the module.
pub struct JointOffset;

impl Effect for JointOffset {
    fn name(&self) -> &'static str {
        "joint-offset"
    }

    fn family(&self, _nonlinear: &Nonlinear) -> Family {
        Family::Geometry
    }

    fn sits_at(&self) -> SiteKind {
        SiteKind::Joint
    }

    /// Joints that follow others as well: a belt gives, and has a phase. What a loop moves is held by the loop.
    fn sites(&self, model: &Model) -> Vec<Site> {
        model.joints_moved_by(|motion| motion != Motion::Passive)
    }

    fn signature(&self) -> &'static str {
        "a constant angle of one joint, in all readings alike"
    }

    fn remedy(&self) -> &'static str {
        "re-master the joint, or add the offset to the controller"
    }

    fn constants(&self, model: &Model, site: &Site, _nonlinear: &Nonlinear) -> Vec<Slot> {
        let frame = &model.frames[site.frame];
        match model.actuators.iter().find(|actuator| actuator.joint == site.frame) {
            Some(actuator) => vec![actuator.slot],
            None => vec![frame.moving_slot()],
        }
    }
}
