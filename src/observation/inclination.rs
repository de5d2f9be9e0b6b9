//! `inclination`: direction of gravity in a body, as an inclinometer or an accelerometer fixed to it shows it. Values of its
//! target: the rotation vector (rad) of the sensor's axes in those of the body.
//!
//! Gravity is that of the description, in base axes: where the base stands does not matter.

use nalgebra::{Matrix3, Rotation3, Vector3};

use super::direction::{Direction, LEAST, read};
use super::kind::{MOST_TARGET_VALUES, MeasuredPoint, TargetValues, ValueColumn};
use crate::math::{left_jacobian, nearest_rotation, rotation_vector};

/// A vector along the axes of the body in those of the sensor.
fn in_sensor(point: &MeasuredPoint, in_body: Vector3<f64>) -> Vector3<f64> {
    Rotation3::new(point.anchor()).inverse() * in_body
}

fn predicted(point: &MeasuredPoint) -> Vector3<f64> {
    in_sensor(point, point.body.inverse() * point.gravity)
}

/// How the sensor is mounted, by the rotation that turns measured onto predicted directions (Wahba's problem). A small multiple
/// of the identity is added: it decides the turn about gravity where all readings have one direction.
fn target_start(points: &[MeasuredPoint]) -> Option<TargetValues> {
    let of = |point: &MeasuredPoint| {
        let in_body = point.body.inverse() * point.gravity;
        read(&point.measured).try_normalize(LEAST).map(|measured| in_body * measured.transpose())
    };
    let sum: Matrix3<f64> = points.iter().filter_map(of).sum();
    let little = 1e-4 * points.len() as f64;
    let mount = rotation_vector(&nearest_rotation(&(sum + Matrix3::identity() * little)));
    let mut start = [0.0; MOST_TARGET_VALUES];
    start[..3].copy_from_slice(mount.as_slice());
    Some(start)
}

pub(super) const INCLINATION: Direction = Direction {
    name: "inclination",
    about: "Direction of gravity in a body.",
    columns: &[ValueColumn::number("gx"), ValueColumn::number("gy"), ValueColumn::number("gz")],
    angles: &[ValueColumn::angle("pitch"), ValueColumn::angle("roll")],
    // The body's rotation from level is Rz(any) Ry(pitch) Rx(roll), z upwards; gravity points down.
    of_angles: |[pitch, roll]| Vector3::new(pitch.sin(), -pitch.cos() * roll.sin(), -pitch.cos() * roll.cos()),
    in_angles: |down| [down.x.clamp(-1.0, 1.0).asin(), (-down.y).atan2(-down.z)],
    residuals: "inclinations",
    depends_on: "the body that carries the inclinometer (`body`), how it is mounted there (`mount`), gravity",
    fault: "gx, gy, gz are all zero, and give no direction",
    of_tool: None,
    target_start,
    predicted,
    change: |point, by| in_sensor(point, point.body.inverse() * point.gravity.cross(&by.total().rotation)),
    // The inverse of a rotation by the vector v turns with the left Jacobian of -v.
    by_target: |point, k| {
        let turn: Vector3<f64> = left_jacobian(&-point.anchor()).column(k.min(2)).into();
        -turn.cross(&predicted(point))
    },
};
