//! `gear-ratio`: the joint moves in proportion more or less than commanded.

use super::{Change, Effect, EffectParameter, Form, Moment, Site, SiteKind};
use crate::model::Model;

/// See the module.
pub struct GearRatio;

impl Effect for GearRatio {
    fn name(&self) -> &'static str {
        "gear-ratio"
    }

    fn sits_at(&self) -> SiteKind {
        SiteKind::Joint
    }

    fn signature(&self) -> &'static str {
        "an angle of one joint that grows in proportion to the joint itself"
    }

    fn remedy(&self) -> &'static str {
        "check the gear ratio in the controller; scale the joint"
    }

    fn parameters(&self, _model: &Model, _site: &Site, _form: &Form) -> Vec<EffectParameter> {
        vec![EffectParameter { symbol: "ratio".into(), unit: "1", scale: 1e-3, is_positive: false }]
    }

    fn changes(&self, site: &Site, _form: &Form, moment: &Moment, out: &mut Vec<(usize, Change)>) {
        out.push((0, Change::Joint(site.variable, moment.joints[site.frame])));
    }
}
