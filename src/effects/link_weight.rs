//! `link-weight`: mass or centre of mass of a link off nominal.

use crate::model::{Effect, Family, Model, Nonlinear, Site, SiteKind};
use crate::parameter::Slot;

/// See the module.
pub struct LinkWeight;

impl Effect for LinkWeight {
    fn name(&self) -> &'static str {
        "link-weight"
    }

    fn family(&self, _nonlinear: &Nonlinear) -> Family {
        Family::Elastic
    }

    fn sits_at(&self) -> SiteKind {
        SiteKind::Link
    }

    fn signature(&self) -> &'static str {
        "unloaded, the arm sags more or less than its masses say, as the posture of the link changes"
    }

    fn remedy(&self) -> &'static str {
        "weigh, or identify the masses; note cables and added equipment"
    }

    fn sites(&self, model: &Model) -> Vec<Site> {
        model.sites_with_constants(self)
    }

    fn constants(&self, model: &Model, site: &Site, _nonlinear: &Nonlinear) -> Vec<Slot> {
        let link = &model.frames[site.frame].name;
        model.slots_named(["mass", "x", "y", "z"].map(|symbol| format!("body{link}.{symbol}")))
    }
}
