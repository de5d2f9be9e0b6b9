//! `instrument-scale`: the instrument's length scale is off.

use nalgebra::Vector3;

use super::{Change, Effect, EffectParameter, Form, Moment, Site, SiteKind};
use crate::model::Model;

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

    fn parameters(&self, _model: &Model, _site: &Site, _form: &Form) -> Vec<EffectParameter> {
        vec![EffectParameter { symbol: "scale".into(), unit: "1", scale: 5e-3, is_positive: false }]
    }

    fn changes(&self, _site: &Site, _form: &Form, moment: &Moment, out: &mut Vec<(usize, Change)>) {
        let length = if moment.is_difference { moment.deflection } else { moment.position };
        out.push((0, Change::Point(length, Vector3::zeros())));
    }
}
