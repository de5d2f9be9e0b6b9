//! `joint-compliance`: torsional spring about a joint's axis.

use crate::description::robot::Motion;
use crate::model::{Effect, Family, Model, Nonlinear, Site, SiteKind};
use crate::parameter::Slot;

/// See the module.
pub struct JointCompliance;

impl Effect for JointCompliance {
    fn name(&self) -> &'static str {
        "joint-compliance"
    }

    fn family(&self, _nonlinear: &Nonlinear) -> Family {
        Family::Elastic
    }

    fn sits_at(&self) -> SiteKind {
        SiteKind::Joint
    }

    /// Joints that follow others as well: a belt gives, and has a phase. What a loop moves is held by the loop.
    fn sites(&self, model: &Model) -> Vec<Site> {
        model.joints_moved_by(|motion| motion != Motion::Passive)
    }

    fn signature(&self) -> &'static str {
        "an angle of one joint in proportion to the load on it"
    }

    fn remedy(&self) -> &'static str {
        "identify the stiffness (`identify --what elastic`) and compensate; inspect the gear"
    }

    fn constants(&self, model: &Model, site: &Site, _nonlinear: &Nonlinear) -> Vec<Slot> {
        let frame = &model.frames[site.frame];
        let symbol = if frame.joint == crate::description::raw::JointKind::Prismatic { "ka" } else { "kar" };
        model.slots_named([format!("joint{}.{symbol}", frame.name)])
    }
}
