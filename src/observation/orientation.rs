//! `orientation`: orientation of the tool alone (rotation vector, rad), as a camera or a 6-D target without position gives it.
//!
//! The residual is the rotation vector of measured times inverse predicted rotation, in measurement axes.

use nalgebra::{Rotation3, Vector3};

use super::kind::{MeasuredPoint, Noise, Observation, PointDerivative, Rows, ValueColumn, rows_of};
use crate::math::rotation_vector;

pub(super) struct Orientation;

const COLUMNS: [ValueColumn; 3] = [ValueColumn::angle("rx"), ValueColumn::angle("ry"), ValueColumn::angle("rz")];

fn rotation(measured: &Rows) -> Rotation3<f64> {
    Rotation3::new(Vector3::from_column_slice(&measured[..3]))
}

impl Observation for Orientation {
    fn name(&self) -> &'static str {
        "orientation"
    }

    fn about(&self) -> &'static str {
        "Orientation of the tool alone."
    }

    fn columns(&self) -> &'static [ValueColumn] {
        &COLUMNS
    }

    fn sees_orientation(&self) -> bool {
        true
    }

    fn residuals_named(&self) -> &'static str {
        "rotations"
    }

    fn measured_orientation(&self, measured: &Rows) -> Option<Rotation3<f64>> {
        Some(rotation(measured))
    }

    fn value(&self, point: &MeasuredPoint) -> Rows {
        rows_of(&rotation_vector(&point.orientation))
    }

    fn residual(&self, measured: &Rows, point: &MeasuredPoint) -> Rows {
        rows_of(&rotation_vector(&(rotation(measured) * point.orientation.inverse())))
    }

    fn derivative(&self, _point: &MeasuredPoint, by: &PointDerivative) -> Rows {
        rows_of(&by.total().rotation)
    }

    fn disturb(&self, measured: &mut Rows, noise: &Noise, normal: &mut dyn FnMut() -> f64) {
        let turn = Rotation3::new(Vector3::from_fn(|_, _| noise.orientation * normal())) * rotation(measured);
        *measured = rows_of(&rotation_vector(&turn));
    }
}
