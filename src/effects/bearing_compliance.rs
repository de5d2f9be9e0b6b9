//! `bearing-compliance`: tilt and radial compliance across a joint's axis.

use crate::model::{Effect, Family, Model, Nonlinear, Site, SiteKind};
use crate::parameter::Slot;

/// See the module.
pub struct BearingCompliance;

impl Effect for BearingCompliance {
    fn name(&self) -> &'static str {
        "bearing-compliance"
    }

    fn family(&self, _nonlinear: &Nonlinear) -> Family {
        Family::Elastic
    }

    fn sits_at(&self) -> SiteKind {
        SiteKind::Joint
    }

    /// Bearings sit in all joints, those that follow others or that a loop moves included.
    fn sites(&self, model: &Model) -> Vec<Site> {
        model.joints_moved_by(|_| true)
    }

    fn signature(&self) -> &'static str {
        "under load the parts after one joint tilt across its axis"
    }

    fn remedy(&self) -> &'static str {
        "inspect and preload the bearing; identify kr and krr"
    }

    fn constants(&self, model: &Model, site: &Site, _nonlinear: &Nonlinear) -> Vec<Slot> {
        let joint = &model.frames[site.frame].name;
        model.slots_named(["krr", "krrx", "krry", "kr", "krx", "kry"].map(|symbol| format!("joint{joint}.{symbol}")))
    }
}
