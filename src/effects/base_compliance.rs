//! `base-compliance`: the pedestal tilts and sinks under load.

use crate::model::{Effect, Family, Model, Nonlinear, Site, SiteKind};
use crate::parameter::Slot;

/// See the module.
pub struct BaseCompliance;

impl Effect for BaseCompliance {
    fn name(&self) -> &'static str {
        "base-compliance"
    }

    fn family(&self, _nonlinear: &Nonlinear) -> Family {
        Family::Elastic
    }

    fn sits_at(&self) -> SiteKind {
        SiteKind::Base
    }

    fn signature(&self) -> &'static str {
        "under load the whole robot tilts about its foot, most at long reach, whatever the posture of the arm"
    }

    fn remedy(&self) -> &'static str {
        "tighten or stiffen the pedestal; measure it with an indicator under load"
    }

    fn constants(&self, model: &Model, _site: &Site, _nonlinear: &Nonlinear) -> Vec<Slot> {
        model.slots_named(["krx", "kry", "krz", "kz"].map(|symbol| format!("base.{symbol}")))
    }
}
