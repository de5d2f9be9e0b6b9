//! `position`: coordinates of a marker or of the tool centre point in the measurement frame, m, as a laser tracker or a
//! camera gives them.

use nalgebra::Vector3;

use super::kind::{MeasuredPoint, Observation, PointDerivative, Rows, ValueColumn, XYZ, rows_of};

pub(super) struct Position;

impl Observation for Position {
    fn name(&self) -> &'static str {
        "position"
    }

    fn about(&self) -> &'static str {
        "Position of a marker or the tool centre point."
    }

    fn columns(&self) -> &'static [ValueColumn] {
        &XYZ
    }

    fn measured_position(&self, measured: &Rows) -> Option<Vector3<f64>> {
        Some(Vector3::from_column_slice(&measured[..3]))
    }

    fn value(&self, point: &MeasuredPoint) -> Rows {
        rows_of(&point.position())
    }

    fn derivative(&self, _point: &MeasuredPoint, by: &PointDerivative) -> Rows {
        rows_of(&by.total().displacement)
    }
}
