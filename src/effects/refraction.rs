//! `refraction`: beams bend in air that is warmer below than above, or the reverse.
//!
//! With a gradient of the refractive index along the vertical a beam is an arc: a point at the horizontal distance `d` of the
//! instrument appears displaced along the vertical by `curvature d^2 / 2` (Torge and Mueller, *Geodesy*, 2012, ch. 5). The
//! instrument is at the origin of the measurement frame, or where its station is.

use std::sync::Arc;

use nalgebra::Vector3;

use super::law::Law;
use crate::model::{Change, EffectParameter, SiteKind};

pub(super) static LAW: Law = Law {
    name: "refraction",
    sits_at: SiteKind::Instrument,
    signature: "heights are off with the square of the distance from the instrument",
    remedy: "stir the air, keep beams away from warm floors and machines; stand nearer",
    cancels_in_differences: true,
    parameters: Some(|_, _, _| {
        // A gradient of 1 K/m is a curvature of 1e-6 1/m. A diagnosis accepts up to sixty times that: more is no air.
        vec![EffectParameter::new("curvature", "1/m", 1e-6)]
    }),
    changes: |_, _, _| {
        Arc::new(|context, out| {
            let seen = context.position;
            let amount = 0.5 * (seen.norm_squared() - seen.dot(&context.up).powi(2));
            out.push((0, Change::Point(context.up * amount, Vector3::zeros())));
        })
    },
    ..Law::NOTHING
};
