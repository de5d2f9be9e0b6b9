//! The displacements of a URDF: where a joint places its link, and how far it has moved.

use std::f64::consts::{FRAC_PI_2, PI};

use nalgebra::{Matrix3, Rotation3, Translation3, UnitQuaternion, Vector3};

use super::elements::{Joint, Kind};
pub(super) use crate::description::khalil_kleinfinger::Isometry;
use crate::description::khalil_kleinfinger::{about_x, about_y, about_z};

/// An angle of roll, pitch or yaw of at most twelve decimals that is this near to a multiple of 90 degrees is taken to be
/// that: pi/2 is often written with eleven decimals (5e-12).
const QUARTER: f64 = 6e-12;

/// The child link's pose in the parent link at joint value zero; angles to the last digit where the frames are `kept`.
pub(super) fn placed(joint: &Joint, kept: bool) -> Isometry {
    let [roll, pitch, yaw] = if kept { joint.rpy } else { joint.rpy.map(quarter) };
    Isometry::from_parts(Translation3::from(joint.xyz), about_z(yaw) * about_y(pitch) * about_x(roll))
}

/// How the child link has moved in its own frame at a value of the joint, SI.
pub(super) fn moved(joint: &Joint, value: f64) -> Isometry {
    let along = Vector3::from(joint.axis).normalize() * value;
    match joint.kind {
        Kind::Fixed => Isometry::identity(),
        Kind::Prismatic => Isometry::from_parts(along.into(), Rotation3::identity()),
        _ => {
            Isometry::from_parts(Translation3::identity(), UnitQuaternion::from_scaled_axis(along).to_rotation_matrix())
        }
    }
}

/// The multiple of 90 degrees that was meant.
fn quarter(angle: f64) -> f64 {
    let exact = (angle / FRAC_PI_2).round() * FRAC_PI_2;
    let short = (angle * 1e12).round() / 1e12 == angle;
    if short && exact != 0.0 && (angle - exact).abs() <= QUARTER { exact } else { angle }
}

/// The shortest rotation of z to this direction, which is not zero.
pub(super) fn towards(direction: [f64; 3]) -> Rotation3<f64> {
    let axis = Vector3::from(direction).normalize();
    if axis.z < -0.5 {
        // By half a turn about x first: the shortest rotation is ill-defined near -z.
        return about_x(PI) * towards([axis.x, -axis.y, -axis.z]);
    }
    // Rodrigues' formula about z x axis.
    let (x, y, z) = (axis.x, axis.y, axis.z);
    let share = 1.0 / (1.0 + z);
    let matrix =
        Matrix3::new(1.0 - x * x * share, -x * y * share, x, -x * y * share, 1.0 - y * y * share, y, -x, -y, z);
    Rotation3::from_matrix_unchecked(matrix)
}
