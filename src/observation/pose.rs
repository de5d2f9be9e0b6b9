//! `pose`: position (m) and orientation (rotation vector, rad) of the tool in the measurement frame.
//!
//! The residual of an orientation is the rotation vector of measured times inverse predicted rotation, in measurement axes.

use nalgebra::{Rotation3, Vector3};

use super::kind::{MeasuredPoint, Noise, Observation, PointDerivative, Rows, ValueColumn};
use crate::math::rotation_vector;

pub(super) struct Pose;

/// Position, or displacement, and rotation vector.
pub(super) const COLUMNS: [ValueColumn; 6] = [
    ValueColumn::length("x"),
    ValueColumn::length("y"),
    ValueColumn::length("z"),
    ValueColumn::angle("rx"),
    ValueColumn::angle("ry"),
    ValueColumn::angle("rz"),
];

/// Position or displacement, and rotation vector, one after the other.
pub(super) fn rows(position: &Vector3<f64>, rotation: &Vector3<f64>) -> Rows {
    [position.x, position.y, position.z, rotation.x, rotation.y, rotation.z]
}

/// The rotation of such rows.
pub(super) fn rotation(measured: &Rows) -> Rotation3<f64> {
    Rotation3::new(Vector3::from_column_slice(&measured[3..]))
}

impl Observation for Pose {
    fn name(&self) -> &'static str {
        "pose"
    }

    fn about(&self) -> &'static str {
        "Position and orientation of the tool."
    }

    fn columns(&self) -> &'static [ValueColumn] {
        &COLUMNS
    }

    fn sees_orientation(&self) -> bool {
        true
    }

    fn measured_position(&self, measured: &Rows) -> Option<Vector3<f64>> {
        Some(Vector3::from_column_slice(&measured[..3]))
    }

    fn measured_orientation(&self, measured: &Rows) -> Option<Rotation3<f64>> {
        Some(rotation(measured))
    }

    fn value(&self, point: &MeasuredPoint) -> Rows {
        rows(&point.position(), &rotation_vector(&point.orientation))
    }

    fn residual(&self, measured: &Rows, point: &MeasuredPoint) -> Rows {
        let position = Vector3::from_column_slice(&measured[..3]) - point.position();
        rows(&position, &rotation_vector(&(rotation(measured) * point.orientation.inverse())))
    }

    fn derivative(&self, _point: &MeasuredPoint, by: &PointDerivative) -> Rows {
        let total = by.total();
        rows(&total.displacement, &total.rotation)
    }

    fn disturb(&self, measured: &mut Rows, noise: &Noise, normal: &mut dyn FnMut() -> f64) {
        for (value, sigma) in measured.iter_mut().zip(noise.position) {
            *value += sigma * normal();
        }
        let turn = Rotation3::new(Vector3::from_fn(|_, _| noise.orientation * normal())) * rotation(measured);
        measured[3..].copy_from_slice(rotation_vector(&turn).as_slice());
    }
}
