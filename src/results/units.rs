//! Units of results: mm for lengths, deg for angles, SI for everything else. Converted once, here.

use crate::parameter::Kind;

/// Unit in which results give a kind, and its size in SI.
pub fn unit(kind: Kind) -> (&'static str, f64) {
    match kind {
        Kind::Length => ("mm", 1e-3),
        Kind::Angle => ("deg", std::f64::consts::PI / 180.0),
        other => (other.unit(), 1.0),
    }
}

/// A length in mm.
pub fn mm(metres: f64) -> f64 {
    metres * 1e3
}

/// An angle in deg.
pub fn deg(radians: f64) -> f64 {
    radians.to_degrees()
}

/// A value of a variable or joint in deg or mm.
pub fn shown(value: f64, is_angle: bool) -> f64 {
    if is_angle { deg(value) } else { mm(value) }
}

/// The unit of [`shown`].
pub fn shown_unit(is_angle: bool) -> &'static str {
    if is_angle { "deg" } else { "mm" }
}

/// Half width of the 95 % interval of a normal distribution.
pub fn half_width_95(sigma: f64) -> f64 {
    crate::math::quantiles::normal95() * sigma
}
