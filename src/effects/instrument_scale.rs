//! `instrument-scale`: the instrument's length scale is off.

use std::sync::Arc;

use nalgebra::Vector3;

use crate::model::{Change, Changes, Effect, EffectParameter, Model, Nonlinear, Site, SiteKind};

/// See the module.
pub struct InstrumentScale;

impl Effect for InstrumentScale {
    fn name(&self) -> &'static str {
        "instrument-scale"
    }

    fn sits_at(&self) -> SiteKind {
        SiteKind::Instrument
    }

    fn signature(&self) -> &'static str {
        "all distances are in proportion too long or too short"
    }

    fn remedy(&self) -> &'static str {
        "check the instrument on a scale bar; enter temperature and pressure"
    }

    fn parameters(&self, _model: &Model, _site: &Site, _nonlinear: &Nonlinear) -> Vec<EffectParameter> {
        vec![EffectParameter::new("scale", "1", 5e-3)]
    }

    fn changes(&self, _model: &Model, _site: &Site, _nonlinear: &Nonlinear) -> Changes {
        Arc::new(|context, out| {
            let length = if context.is_difference { context.deflection } else { context.position };
            out.push((0, Change::Point(length, Vector3::zeros())));
        })
    }
}
