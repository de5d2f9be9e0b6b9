//! `outliers`: some readings are simply wrong.

use super::{Effect, Form, Site, SiteKind, Survey};
use crate::model::Model;

/// See the module.
pub struct Outliers;

impl Effect for Outliers {
    fn name(&self) -> &'static str {
        "outliers"
    }

    fn sits_at(&self) -> SiteKind {
        SiteKind::Instrument
    }

    fn signature(&self) -> &'static str {
        "single readings far from all others, without pattern"
    }

    fn remedy(&self) -> &'static str {
        "look at the readings named; repeat them"
    }

    /// Which readings are wrong is found apart, so that it has no form among the others.
    fn forms(&self, _model: &Model, _site: &Site, _survey: &Survey) -> Vec<Form> {
        Vec::new()
    }
}
