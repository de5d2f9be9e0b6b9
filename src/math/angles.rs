//! Angles.

/// An angle within half a turn, rad.
///
/// ```
/// use std::f64::consts::PI;
///
/// assert!((elastogeo::math::wrapped(1.5 * PI) + 0.5 * PI).abs() < 1e-12);
/// ```
pub fn wrapped(angle: f64) -> f64 {
    let turn = std::f64::consts::TAU;
    angle - turn * (angle / turn).round()
}
