//! `link-compliance`: a link bends or twists as a beam.

use super::{Effect, Form, Site, SiteKind, named, sites_with_constants};
use crate::model::Model;
use crate::parameter::Slot;

/// See the module.
pub struct LinkCompliance;

impl Effect for LinkCompliance {
    fn name(&self) -> &'static str {
        "link-compliance"
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
        sites_with_constants(self, model)
    }

    fn constants(&self, model: &Model, site: &Site, _form: &Form) -> Vec<Slot> {
        let link = &model.frames[site.frame].name;
        named(model, ["bending_y", "bending_z", "torsion"].map(|symbol| format!("link{link}.{symbol}")))
    }
}
