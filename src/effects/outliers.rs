//! `outliers`: single readings that are wrong.

use crate::model::{Effect, Family, Model, Nonlinear, Site, SiteKind, Survey};

/// See the module.
pub struct Outliers;

impl Effect for Outliers {
    fn name(&self) -> &'static str {
        "outliers"
    }

    fn family(&self, _nonlinear: &Nonlinear) -> Family {
        Family::Gross
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

    /// Outliers are found after the other effects, from the residuals: they are not among the hypotheses.
    fn candidates(&self, _model: &Model, _site: &Site, _survey: &Survey) -> Vec<Nonlinear> {
        Vec::new()
    }
}
