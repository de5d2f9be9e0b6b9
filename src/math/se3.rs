//! Rigid motions: derivatives of the exponential map.

use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};

/// Rotation vector of a rotation (rad), accurate for small angles and near half a turn.
pub fn rotation_vector(rotation: &Rotation3<f64>) -> Vector3<f64> {
    UnitQuaternion::from_rotation_matrix(rotation).scaled_axis()
}

/// Left Jacobian of the rotation group: d(exp phi) exp(-phi) = J dphi, with phi a rotation vector (rad).
///
/// Source: Barfoot, *State Estimation for Robotics*, sec. 7.1.5; series below 1e-4 rad.
pub fn left_jacobian(phi: &Vector3<f64>) -> Matrix3<f64> {
    let angle = phi.norm();
    let cross = phi.cross_matrix();
    let (first, second) = if angle < 1e-4 {
        (0.5 - angle * angle / 24.0, 1.0 / 6.0 - angle * angle / 120.0)
    } else {
        ((1.0 - angle.cos()) / angle.powi(2), (angle - angle.sin()) / angle.powi(3))
    };
    Matrix3::identity() + cross * first + cross * cross * second
}
