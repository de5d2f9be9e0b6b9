//! The standard catalogue of effects that a description leaves out, one file each: words, and functions of model and site
//! (`law`).
//!
//! An effect ([`Effect`]) says where it can sit, which parameters it has, and what one unit of each changes in a reading.
//! To add one: its file, its line in [`Catalogue::standard`], its section in `docs/effects.md`. A program that has an effect
//! of its own adds it with [`Catalogue::with`]; see `examples/own_effect.rs`.

/// Nonlinear parameters of a law as statics, a row each: the key, what its value is, its default (`or`), the choice that another one must
/// have for it to exist (`with`), and what it means.
macro_rules! nonlinear {
    ($(
        $(#[$about:meta])* $vis:vis $own:ident $name:literal, $kind:expr
            $(, or $default:expr)? $(, with $other:literal $word:expr)? => $meaning:literal;
    )*) => {$(
        $(#[$about])*
        $vis static $own: crate::model::NonlinearParameter = crate::model::NonlinearParameter {
            name: $name,
            kind: $kind,
            default: nonlinear!(@optional $($default)?),
            only_with: nonlinear!(@optional $(($other, $word))?),
            meaning: concat!("`", $name, "`: ", $meaning),
        };
    )*};
    (@optional) => { None };
    (@optional $value:expr) => { Some($value) };
}

mod actuator_compliance;
mod backlash;
mod base_compliance;
mod bearing_compliance;
mod cable_torque;
mod encoder_quantisation;
mod frame_drift;
mod free_compliance;
mod free_form;
mod gear_ratio;
mod geometry;
mod gravity_compensator;
mod hysteresis;
mod incidence;
mod instrument_encoder;
mod instrument_scale;
mod joint_compliance;
mod joint_coupling;
mod joint_offset;
mod joint_stiffening;
mod law;
mod link_compliance;
mod link_weight;
mod motor_eccentricity;
mod outliers;
mod payload;
mod range_offset;
mod refraction;
mod settling;
mod slip;
mod thermal_expansion;
mod transmission_error;
mod warm_up;

use std::sync::Arc;

pub use crate::model::{
    CarriedLoad, Catalogue, Change, Changes, Condition, Driver, Effect, EffectEntry, EffectParameter, Family,
    Nonlinear, NonlinearKind, NonlinearParameter, NonlinearValue, ReadingContext, Site, SiteKind, Survey,
};
use law::Law;

impl Catalogue {
    /// The effects of `docs/effects.md`, in its order.
    pub fn standard() -> Self {
        let laws: [&'static Law; 36] = [
            &geometry::LAW,
            &joint_offset::LAW,
            &gear_ratio::LAW,
            &transmission_error::LAW,
            &motor_eccentricity::LAW,
            &encoder_quantisation::LAW,
            &cable_torque::LAW,
            &joint_coupling::LAW,
            &backlash::LAW,
            &settling::LAW,
            &hysteresis::LAW,
            &slip::JOINT,
            &slip::TOOL,
            &slip::MARKER,
            &joint_compliance::LAW,
            &joint_stiffening::LAW,
            &bearing_compliance::LAW,
            &link_compliance::LAW,
            &actuator_compliance::LAW,
            &gravity_compensator::LAW,
            &link_weight::LAW,
            &payload::LAW,
            &base_compliance::LAW,
            &thermal_expansion::LAW,
            &warm_up::LINK,
            &warm_up::BASE,
            &warm_up::TOOL,
            &frame_drift::LAW,
            &instrument_scale::LAW,
            &range_offset::LAW,
            &instrument_encoder::LAW,
            &refraction::LAW,
            &incidence::LAW,
            &free_form::LAW,
            &free_compliance::LAW,
            &outliers::LAW,
        ];
        Self::new(laws.map(|law| Arc::new(law) as Arc<dyn Effect>).to_vec())
    }
}
