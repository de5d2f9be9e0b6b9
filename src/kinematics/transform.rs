//! Rigid transforms and rotation vectors (rad).

/// A rigid transform: rotation matrix and translation (m).
pub type Transform = nalgebra::IsometryMatrix3<f64>;

/// Rotation vector of a rotation (rad), accurate for small angles and near half a turn.
pub fn rotation_vector(rotation: &nalgebra::Rotation3<f64>) -> nalgebra::Vector3<f64> {
    nalgebra::UnitQuaternion::from_rotation_matrix(rotation).scaled_axis()
}
