//! `incidence`: a reflector that is seen from the side reads too long or too short.
//!
//! Where the optical centre of a reflector is not its mechanical one, the error along the beam grows with the angle between
//! beam and the reflector's axis, `amount (1 - cos angle)` (ASME B89.4.19, annex on retroreflectors).

use std::sync::Arc;

use nalgebra::Vector3;

use crate::model::{
    Change, Changes, Effect, EffectParameter, Model, Nonlinear, NonlinearKind, NonlinearParameter, NonlinearValue,
    Site, SiteKind, Survey,
};

const AXES: [&str; 6] = ["x", "y", "z", "-x", "-y", "-z"];
static AXIS: NonlinearParameter = NonlinearParameter {
    name: "axis",
    kind: NonlinearKind::Choice(&AXES),
    default: Some(NonlinearValue::Choice("z")),
    only_with: None,
    meaning: "`axis`: the axis of the body along which the reflector looks",
};

/// See the module.
pub struct Incidence;

impl Effect for Incidence {
    fn name(&self) -> &'static str {
        "incidence"
    }

    fn sits_at(&self) -> SiteKind {
        SiteKind::Instrument
    }

    fn signature(&self) -> &'static str {
        "distances from the instrument are off with the angle under which the reflector is seen"
    }

    fn remedy(&self) -> &'static str {
        "turn the reflector towards the instrument at each pose; use one with a larger acceptance angle"
    }

    fn nonlinear_parameters(&self) -> Vec<&'static NonlinearParameter> {
        vec![&AXIS]
    }

    /// Opposite axes differ by a part that goes with the cosine alone, which a point of the tool's takes up: three are tried.
    fn candidates(&self, _model: &Model, _site: &Site, survey: &Survey) -> Vec<Nonlinear> {
        let of = |axis: &&'static str| Nonlinear::new([(&AXIS, NonlinearValue::Choice(axis))]);
        if survey.is_difference { Vec::new() } else { AXES.iter().map(of).collect() }
    }

    fn parameters(&self, _model: &Model, _site: &Site, _nonlinear: &Nonlinear) -> Vec<EffectParameter> {
        vec![EffectParameter::new("amount", "m", 1e-4)]
    }

    fn changes(&self, _model: &Model, _site: &Site, nonlinear: &Nonlinear) -> Changes {
        let [NonlinearValue::Choice(axis)] = nonlinear.values()[..] else { return Arc::new(|_, _| {}) };
        let index = AXES.iter().position(|known| *known == axis).unwrap_or(2);
        let looks = Vector3::ith(index % 3, if index < 3 { 1.0 } else { -1.0 });
        Arc::new(move |context, out| {
            // From the reflector to the instrument; none at the instrument itself.
            let Some(beam) = (-context.position).try_normalize(1e-9) else { return };
            let cosine = beam.dot(&(context.body * looks));
            out.push((0, Change::Point(-beam * (1.0 - cosine), Vector3::zeros())));
        })
    }
}
