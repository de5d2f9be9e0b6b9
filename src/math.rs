//! Small mathematics that knows no robot.

mod orthonormal;

pub use orthonormal::{independent, joined, least_squares, orthonormal, project_off};

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

/// Two-sided 95 % quantile of the normal distribution.
pub const NORMAL95: f64 = 1.959_963_984_540_054;

/// Mean, root mean square and greatest of a set of magnitudes; zeros for none.
pub fn mean_rms_max(values: impl Iterator<Item = f64>) -> [f64; 3] {
    let (mut n, mut sum, mut squares, mut max) = (0.0, 0.0, 0.0, 0.0_f64);
    for value in values {
        n += 1.0;
        sum += value;
        squares += value * value;
        max = max.max(value.abs());
    }
    if n == 0.0 { [0.0; 3] } else { [sum / n, f64::sqrt(squares / n), max] }
}

/// Median; NaN for none.
pub fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    match values.len() {
        0 => f64::NAN,
        n if n % 2 == 1 => values[n / 2],
        n => 0.5 * (values[n / 2 - 1] + values[n / 2]),
    }
}
