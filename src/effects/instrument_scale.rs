//! `instrument-scale`: the instrument's length scale is off.

use std::sync::Arc;

use nalgebra::Vector3;

use super::law::Law;
use crate::model::{Change, EffectParameter, SiteKind};

pub(super) static LAW: Law = Law {
    name: "instrument-scale",
    sits_at: SiteKind::Instrument,
    signature: "all distances are in proportion too long or too short",
    remedy: "check the instrument on a scale bar; enter temperature and pressure",
    parameters: Some(|_, _, _| vec![EffectParameter::new("scale", "1", 5e-3)]),
    changes: |_, _, _| {
        Arc::new(|context, out| {
            let length = if context.is_difference { context.deflection } else { context.position };
            out.push((0, Change::Point(length, Vector3::zeros())));
        })
    },
    ..Law::NOTHING
};
