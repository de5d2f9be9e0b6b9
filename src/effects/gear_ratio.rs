//! `gear-ratio`: the joint moves in proportion more or less than commanded.

use std::sync::Arc;

use crate::model::{Change, Changes, Effect, EffectParameter, Model, Nonlinear, Site, SiteKind};

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

    fn parameters(&self, _model: &Model, _site: &Site, _nonlinear: &Nonlinear) -> Vec<EffectParameter> {
        vec![EffectParameter::new("ratio", "1", 1e-3)]
    }

    fn changes(&self, _model: &Model, site: &Site, _nonlinear: &Nonlinear) -> Changes {
        let (variable, joint) = (site.variable, site.frame);
        Arc::new(move |context, out| out.push((0, Change::Joint(variable, context.joints[joint]))))
    }
}
