//! Rigid transforms and rotation vectors (rad).

pub use crate::math::rotation_vector;

/// A rigid transform: rotation matrix and translation (m).
pub type Transform = nalgebra::IsometryMatrix3<f64>;
