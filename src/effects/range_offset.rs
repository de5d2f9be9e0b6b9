//! `range-offset`: the zero of the instrument's distances is off, as by the radius of another reflector.

use std::sync::Arc;

use nalgebra::Vector3;

use super::law::Law;
use crate::model::{Change, EffectParameter, SiteKind};

pub(super) static LAW: Law = Law {
    name: "range-offset",
    sits_at: SiteKind::Instrument,
    signature: "all distances from the instrument are too long or too short by one length",
    remedy: "check the reflector that is set in the instrument, and the instrument's distance at its home position",
    cancels_in_differences: true,
    parameters: Some(|_, _, _| vec![EffectParameter::new("offset", "m", 1e-3)]),
    changes: |_, _, _| {
        Arc::new(|context, out| {
            // None at the instrument itself.
            let Some(beam) = context.position.try_normalize(1e-9) else { return };
            out.push((0, Change::Point(beam, Vector3::zeros())));
        })
    },
    ..Law::NOTHING
};
