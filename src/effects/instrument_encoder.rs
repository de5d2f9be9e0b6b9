//! `instrument-encoder`: an angle encoder of a laser tracker or total station that sits off its axis or is not round.
//!
//! Its angle swings once a turn where the circle is off the axis, twice where it or its axis is out of round (ASME B89.4.19;
//! Muralikrishnan et al., J. Res. NIST 114 (2009) 21: encoder eccentricity and second-order scale error); several times
//! by the long waves of its graduation. The instrument is at the origin of the measurement frame, or where its station is,
//! and stands upright; without gravity along z.

use std::sync::Arc;

use nalgebra::Vector3;

use super::law::{Law, nothing};
use crate::model::{Change, EffectParameter, Nonlinear, NonlinearKind, NonlinearValue, ReadingContext, SiteKind};

const ANGLES: [&str; 2] = ["azimuth", "elevation"];
nonlinear! {
    ANGLE "angle", NonlinearKind::Choice(&ANGLES), or NonlinearValue::Choice("azimuth") =>
        "which angle swings, that about the vertical (azimuth) or that above the horizon (elevation)";
}

/// Periods in a turn that are tried: off its axis, out of round, and long waves of the graduation.
const TRIED: [usize; 6] = [1, 2, 3, 4, 6, 8];
const MOST_PERIODS: usize = 12;
nonlinear! {
    PERIODS "periods", NonlinearKind::Count(MOST_PERIODS), or NonlinearValue::Count(1) =>
        "periods in a turn of the instrument, 1 to 12";
}

pub(super) static LAW: Law = Law {
    name: "instrument-encoder",
    sits_at: SiteKind::Instrument,
    signature: "errors across the line of sight that swing with the direction in which the instrument looks",
    remedy: "measure the points in both faces of the instrument; run its interim tests and have its angles compensated",
    nonlinear: &[&ANGLE, &PERIODS],
    cancels_in_differences: true,
    candidates: |_, _, _| {
        let of = |angle: &'static str, periods| {
            Nonlinear::new([(&ANGLE, NonlinearValue::Choice(angle)), (&PERIODS, NonlinearValue::Count(periods))])
        };
        ANGLES.iter().flat_map(|angle| TRIED.map(|periods| of(angle, periods))).collect()
    },
    // A diagnosis accepts up to sixty times this, 12 arc seconds; makers state 0.5 to 10 for trackers and total stations.
    parameters: Some(|_, _, _| ["cos", "sin"].map(|symbol| EffectParameter::new(symbol, "rad", 1e-6)).to_vec()),
    changes: |_, _, nonlinear| {
        let [NonlinearValue::Choice(angle), NonlinearValue::Count(periods)] = nonlinear.values()[..] else {
            return nothing();
        };
        let is_azimuth = angle == ANGLES[0];
        Arc::new(move |context, out| {
            let Some((direction, by)) = seen(context, is_azimuth) else { return };
            let (sine, cosine) = (periods as f64 * direction).sin_cos();
            out.push((0, Change::Point(by * cosine, Vector3::zeros())));
            out.push((1, Change::Point(by * sine, Vector3::zeros())));
        })
    },
    ..Law::NOTHING
};

/// Azimuth or elevation of the measured point (rad), and what it moves by as that angle grows by one (m). None where the
/// point is above or below the instrument.
fn seen(context: &ReadingContext, is_azimuth: bool) -> Option<(f64, Vector3<f64>)> {
    let axis = context.up.try_normalize(0.0).unwrap_or_else(Vector3::z);
    // Zero of the azimuth: towards x of the measurement frame; towards y where x is more upright than level.
    let zero = Vector3::ith(usize::from(axis.x.abs() > std::f64::consts::FRAC_1_SQRT_2), 1.0);
    let zero = (zero - axis * axis.dot(&zero)).try_normalize(0.0)?;
    let height = axis.dot(&context.position);
    let level = context.position - axis * height;
    let distance = level.norm();
    let ahead = level.try_normalize(1e-9)?;
    let across = axis.cross(&level);
    Some(if is_azimuth {
        (axis.cross(&zero).dot(&level).atan2(zero.dot(&level)), across)
    } else {
        (height.atan2(distance), axis * distance - ahead * height)
    })
}
