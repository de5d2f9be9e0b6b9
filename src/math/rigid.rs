//! Rigid fits of points.

use nalgebra::{DMatrix, Matrix3, Rotation3, UnitQuaternion, Vector3};

use super::linear::Svd;

/// Rotation R and translation t that minimise the sum of |R a + t - b|^2 (Kabsch, *A solution for the best rotation to relate
/// two sets of vectors*, Acta Cryst. A32, 1976).
pub(crate) fn rigid_fit(a: &[Vector3<f64>], b: &[Vector3<f64>]) -> (Rotation3<f64>, Vector3<f64>) {
    let mean = |points: &[Vector3<f64>]| points.iter().sum::<Vector3<f64>>() / points.len().max(1) as f64;
    let (mean_a, mean_b) = (mean(a), mean(b));
    let covariance: Matrix3<f64> = a.iter().zip(b).map(|(a, b)| (b - mean_b) * (a - mean_a).transpose()).sum();
    let rotation = nearest_rotation(&covariance);
    (rotation, mean_b - rotation * mean_a)
}

/// The rotation nearest to a matrix; the identity where it has none.
pub(crate) fn nearest_rotation(matrix: &Matrix3<f64>) -> Rotation3<f64> {
    if matrix.iter().any(|v| !v.is_finite()) {
        return Rotation3::identity();
    }
    let Some(Svd { left, right, .. }) = Svd::new(&DMatrix::from_column_slice(3, 3, matrix.as_slice())) else {
        return Rotation3::identity();
    };
    let (u, v) =
        (Matrix3::from_column_slice(left.as_slice()), Matrix3::from_column_slice(right.as_slice()).transpose());
    let sign = (u * v).determinant().signum();
    // Singular values come in descending order: the last may be mirrored.
    let rotation = u * Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, sign)) * v;
    UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(rotation)).to_rotation_matrix()
}
