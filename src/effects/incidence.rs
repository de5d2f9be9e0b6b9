//! `incidence`: a reflector that is seen from the side reads too long or too short.
//!
//! Where the optical centre of a reflector is not its mechanical one, the error along the beam grows with the angle between
//! beam and the reflector's axis, `amount (1 - cos angle)` (ASME B89.4.19, annex on retroreflectors).

use std::sync::Arc;

use nalgebra::Vector3;

use super::law::{Law, nothing};
use crate::model::{Change, EffectParameter, Nonlinear, NonlinearKind, NonlinearValue, SiteKind};

const AXES: [&str; 6] = ["x", "y", "z", "-x", "-y", "-z"];
nonlinear! {
    AXIS "axis", NonlinearKind::Choice(&AXES), or NonlinearValue::Choice("z") =>
        "the axis of the body along which the reflector looks";
}

pub(super) static LAW: Law = Law {
    name: "incidence",
    sits_at: SiteKind::Instrument,
    signature: "distances from the instrument are off with the angle under which the reflector is seen",
    remedy: "turn the reflector towards the instrument at each pose; use one with a larger acceptance angle",
    nonlinear: &[&AXIS],
    cancels_in_differences: true,
    // Opposite axes differ by a part that goes with the cosine alone, which a point of the tool's takes up: three are tried.
    candidates: |_, _, _| {
        let of = |axis: &&'static str| Nonlinear::new([(&AXIS, NonlinearValue::Choice(axis))]);
        AXES.iter().map(of).collect()
    },
    parameters: Some(|_, _, _| vec![EffectParameter::new("amount", "m", 1e-4)]),
    changes: |_, _, nonlinear| {
        let [NonlinearValue::Choice(axis)] = nonlinear.values()[..] else { return nothing() };
        let index = AXES.iter().position(|known| *known == axis).unwrap_or(2);
        let looks = Vector3::ith(index % 3, if index < 3 { 1.0 } else { -1.0 });
        Arc::new(move |context, out| {
            // From the reflector to the instrument; none at the instrument itself.
            let Some(beam) = (-context.position).try_normalize(1e-9) else { return };
            let cosine = beam.dot(&(context.body * looks));
            out.push((0, Change::Point(-beam * (1.0 - cosine), Vector3::zeros())));
        })
    },
    ..Law::NOTHING
};
