//! `inclination`: direction of gravity in a body, as an inclinometer or an accelerometer fixed to it shows it. Values of its
//! target: the rotation vector (rad) of the sensor's axes in those of the body.
//!
//! The two residuals (rad) are the components of the predicted direction across the measured one. Gravity is that of the
//! description, in base axes: where the base stands does not matter.

use nalgebra::{Rotation3, Vector3};

use super::direction::{LEAST, across, disturbed, read, two};
use super::kind::{MeasuredPoint, Noise, Observation, PointDerivative, Rows, ValueColumn, rows_of};
use crate::math::left_jacobian;

pub(super) struct Inclination;

const COLUMNS: [ValueColumn; 3] = [ValueColumn::number("gx"), ValueColumn::number("gy"), ValueColumn::number("gz")];
const ANGLES: [ValueColumn; 2] = [ValueColumn::angle("pitch"), ValueColumn::angle("roll")];

/// The sensor's axes in those of the body.
fn mount(point: &MeasuredPoint) -> Vector3<f64> {
    point.anchor()
}

/// Direction of gravity in the axes of the body.
fn in_body(point: &MeasuredPoint) -> Vector3<f64> {
    point.body.inverse() * point.gravity
}

/// The same in those of the sensor.
fn in_sensor(point: &MeasuredPoint) -> Vector3<f64> {
    Rotation3::new(mount(point)).inverse() * in_body(point)
}

impl Observation for Inclination {
    fn name(&self) -> &'static str {
        "inclination"
    }

    fn about(&self) -> &'static str {
        "Direction of gravity in a body."
    }

    fn columns(&self) -> &'static [ValueColumn] {
        &COLUMNS
    }

    fn other_columns(&self) -> &'static [ValueColumn] {
        &ANGLES
    }

    /// The body's rotation from level is Rz(any) Ry(pitch) Rx(roll), z upwards; gravity points down.
    fn of_other_columns(&self, read: &[f64]) -> Rows {
        let [pitch, roll] = [0, 1].map(|k| read.get(k).copied().unwrap_or(0.0));
        rows_of(&Vector3::new(pitch.sin(), -pitch.cos() * roll.sin(), -pitch.cos() * roll.cos()))
    }

    fn rows(&self) -> usize {
        2
    }

    fn ignores_arrangement(&self) -> bool {
        true
    }

    fn residuals_named(&self) -> &'static str {
        "inclinations"
    }

    fn fault(&self, measured: &Rows) -> Option<(&'static str, &'static str)> {
        (read(measured).norm() < LEAST).then_some(("gx", "gx, gy, gz are all zero, and give no direction"))
    }

    fn value(&self, point: &MeasuredPoint) -> Rows {
        rows_of(&in_sensor(point))
    }

    fn residual(&self, measured: &Rows, point: &MeasuredPoint) -> Rows {
        let predicted = in_sensor(point);
        two(across(measured, &predicted).map(|axis| -axis.dot(&predicted)))
    }

    fn derivative(&self, point: &MeasuredPoint, by: &PointDerivative) -> Rows {
        let turned = point.body.inverse() * point.gravity.cross(&by.total().rotation);
        let change = Rotation3::new(mount(point)).inverse() * turned;
        two(across(&point.measured, &in_sensor(point)).map(|axis| axis.dot(&change)))
    }

    /// The inverse of a rotation by the vector v turns with the left Jacobian of -v.
    fn by_target(&self, point: &MeasuredPoint, k: usize) -> Rows {
        let turn: Vector3<f64> = left_jacobian(&-mount(point)).column(k.min(2)).into();
        let change = -turn.cross(&in_sensor(point));
        two(across(&point.measured, &in_sensor(point)).map(|axis| axis.dot(&change)))
    }

    fn sigmas(&self, noise: &Noise) -> Rows {
        two([noise.orientation; 2])
    }

    fn disturb(&self, measured: &mut Rows, noise: &Noise, normal: &mut dyn FnMut() -> f64) {
        *measured = rows_of(&disturbed(measured, noise.orientation, normal));
    }
}
