//! Directions as readings: two residuals (rad) across what was measured.

use nalgebra::Vector3;

use super::kind::Rows;

/// Below this length a direction is none.
pub(super) const LEAST: f64 = 1e-9;

/// Two unit vectors across the measured direction; across the predicted one where nothing is measured yet.
pub(super) fn across(measured: &Rows, predicted: &Vector3<f64>) -> [Vector3<f64>; 2] {
    let along = read(measured).try_normalize(LEAST).unwrap_or(*predicted);
    let first = along.cross(&Vector3::ith(along.iamin(), 1.0)).normalize();
    [first, along.cross(&first)]
}

/// The measured vector, of any length.
pub(super) fn read(measured: &Rows) -> Vector3<f64> {
    Vector3::from_column_slice(&measured[..3])
}

/// Two residuals.
pub(super) fn two(of: [f64; 2]) -> Rows {
    [of[0], of[1], 0.0, 0.0, 0.0, 0.0]
}

/// An ideal direction with noise (rad) across it.
pub(super) fn disturbed(measured: &Rows, sigma: f64, normal: &mut dyn FnMut() -> f64) -> Vector3<f64> {
    let along = read(measured);
    let noisy = along + Vector3::from_fn(|_, _| sigma * normal());
    noisy.try_normalize(LEAST).unwrap_or(along)
}
