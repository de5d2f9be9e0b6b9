//! `link-compliance`: a link bends or twists as a beam.

use crate::model::{Effect, Family, Model, Nonlinear, Site, SiteKind};
use crate::parameter::Slot;

/// See the module.
pub struct LinkCompliance;

impl Effect for LinkCompliance {
    fn name(&self) -> &'static str {
        "link-compliance"
    }

    fn family(&self, _nonlinear: &Nonlinear) -> Family {
        Family::Elastic
    }

    fn sits_at(&self) -> SiteKind {
        SiteKind::Link
    }

    fn signature(&self) -> &'static str {
        "under load the parts after a link turn and drop, more for forces across it, whatever its joints do"
    }

    fn remedy(&self) -> &'static str {
        "identify the link as a beam (sections in the description); stiffen it"
    }

    fn sites(&self, model: &Model) -> Vec<Site> {
        model.sites_with_constants(self)
    }

    fn constants(&self, model: &Model, site: &Site, _nonlinear: &Nonlinear) -> Vec<Slot> {
        let link = &model.frames[site.frame].name;
        model.slots_named(["bending_y", "bending_z", "torsion"].map(|symbol| format!("link{link}.{symbol}")))
    }
}
