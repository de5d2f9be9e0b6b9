//! `refraction`: beams bend in air that is warmer below than above, or the reverse.
//!
//! With a gradient of the refractive index along the vertical a beam is an arc: a point at the horizontal distance `d` of the
//! instrument appears displaced along the vertical by `curvature d^2 / 2` (Torge and Mueller, *Geodesy*, 2012, ch. 5). The
//! instrument is at the origin of the measurement frame, or where its station is.

use std::sync::Arc;

use nalgebra::Vector3;

use crate::model::{Change, Changes, Effect, EffectParameter, Model, Nonlinear, Site, SiteKind, Survey};

/// See the module.
pub struct Refraction;

impl Effect for Refraction {
    fn name(&self) -> &'static str {
        "refraction"
    }

    fn sits_at(&self) -> SiteKind {
        SiteKind::Instrument
    }

    fn signature(&self) -> &'static str {
        "heights are off with the square of the distance from the instrument"
    }

    fn remedy(&self) -> &'static str {
        "stir the air, keep beams away from warm floors and machines; stand nearer"
    }

    fn candidates(&self, _model: &Model, _site: &Site, survey: &Survey) -> Vec<Nonlinear> {
        if survey.is_difference { Vec::new() } else { vec![Nonlinear::default()] }
    }

    fn parameters(&self, _model: &Model, _site: &Site, _nonlinear: &Nonlinear) -> Vec<EffectParameter> {
        // A gradient of 1 K/m bends by 1e-6 of a metre in a metre.
        vec![EffectParameter::new("curvature", "1/m", 1e-5)]
    }

    fn changes(&self, _model: &Model, _site: &Site, _nonlinear: &Nonlinear) -> Changes {
        Arc::new(|context, out| {
            let seen = context.position;
            let amount = 0.5 * (seen.norm_squared() - seen.dot(&context.up).powi(2));
            out.push((0, Change::Point(context.up * amount, Vector3::zeros())));
        })
    }
}
