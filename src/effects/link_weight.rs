//! `link-weight`: mass or centre of mass of a link off nominal.

use super::{Effect, Form, Site, SiteKind, named, sites_with_constants};
use crate::model::Model;
use crate::parameter::Slot;

/// See the module.
pub struct LinkWeight;

impl Effect for LinkWeight {
    fn name(&self) -> &'static str {
        "link-weight"
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
        sites_with_constants(self, model)
    }

    fn constants(&self, model: &Model, site: &Site, _form: &Form) -> Vec<Slot> {
        let link = &model.frames[site.frame].name;
        named(model, ["mass", "x", "y", "z"].map(|symbol| format!("body{link}.{symbol}")))
    }
}
