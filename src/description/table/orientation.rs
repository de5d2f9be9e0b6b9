//! Orientations as files write them: the columns of each way, and the rotation of a row.
//!
//! Rotations turn the axes of the measurement frame into those of the tool, so that the columns of the matrix are the axes of
//! the tool.

use nalgebra::{Matrix3, Quaternion, Rotation3, UnitQuaternion, Vector3};
#[cfg(feature = "cli")]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::math::nearest_rotation;

/// Greatest deviation of a quaternion's length from 1, and of the products of a matrix' rows from 0 and 1: files round to
/// three digits or more, and what is farther off is another quantity.
const OFF_UNIT: f64 = 1e-3;

/// How files write orientations.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize, Serialize)]
#[cfg_attr(feature = "cli", derive(JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Orientation {
    /// Axis times angle: columns rx, ry, rz, in the unit of angles.
    #[default]
    RotationVector,
    /// Unit quaternion: columns qx, qy, qz, qw; or q0 to q3 in the order given, unless joints are called so.
    Quaternion(QuaternionOrder),
    /// Angles about z, then the new y, then the new x, as KUKA controllers show them: columns A, B, C.
    KukaAbc,
    /// Angles about the fixed axes x, then y, then z: columns roll, pitch, yaw.
    RollPitchYaw,
    /// Rotation matrix, its columns the axes of the tool: columns r11, r12, r13, r21, .., r33.
    Matrix,
}

/// Order of the components of a quaternion.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize)]
#[cfg_attr(feature = "cli", derive(JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum QuaternionOrder {
    /// The scalar last: ROS, scipy, most trackers.
    Xyzw,
    /// The scalar first: ABB, Eigen's constructor, textbooks.
    Wxyz,
}

pub(super) const VECTOR: [&str; 3] = ["rx", "ry", "rz"];
const QUATERNION: [&str; 4] = ["qx", "qy", "qz", "qw"];
pub(super) const NUMBERED: [&str; 4] = ["q0", "q1", "q2", "q3"];
const KUKA: [&str; 3] = ["A", "B", "C"];
const ROLL_PITCH_YAW: [&str; 3] = ["roll", "pitch", "yaw"];
const MATRIX: [&str; 9] = ["r11", "r12", "r13", "r21", "r22", "r23", "r31", "r32", "r33"];

/// What the titles of a file look like, where an orientation is needed and none is declared: the titles, and what to declare.
pub(super) fn undeclared(titles: &[String]) -> Option<(&'static [&'static str], &'static str)> {
    let either = "`orientation: {quaternion: xyzw}` or `orientation: {quaternion: wxyz}`, whichever the program that wrote it uses";
    let all: [(&[&str], &str); 5] = [
        (&QUATERNION, either),
        (&NUMBERED, either),
        (&KUKA, "`orientation: kuka-abc`, if these are the angles of a KUKA controller"),
        (&ROLL_PITCH_YAW, "`orientation: roll-pitch-yaw`, if these turn about the fixed axes x, y, z in this order"),
        (&MATRIX, "`orientation: matrix`"),
    ];
    all.into_iter().find(|(names, _)| names.iter().all(|name| titles.iter().any(|title| title == name)))
}

/// The ways to write an orientation in which all columns are there and of which `title` is one, and what declares it.
pub(super) fn also_written(titles: &[String], title: &str) -> Option<(&'static [&'static str], &'static str)> {
    let all: [(&[&str], &str); 5] = [
        (&VECTOR, "declare `orientation: rotation-vector`"),
        (&QUATERNION, "declare `orientation: {quaternion: ..}`"),
        (&KUKA, "declare `orientation: kuka-abc`"),
        (&ROLL_PITCH_YAW, "declare `orientation: roll-pitch-yaw`"),
        (&MATRIX, "declare `orientation: matrix`"),
    ];
    let is_there = |names: &[&str]| names.iter().all(|name| titles.iter().any(|title| title == name));
    all.into_iter().find(|(names, _)| names.contains(&title) && is_there(names))
}

impl Orientation {
    /// Its columns under our names.
    pub fn columns(self) -> &'static [&'static str] {
        match self {
            Self::RotationVector => &VECTOR,
            Self::Quaternion(_) => &QUATERNION,
            Self::KukaAbc => &KUKA,
            Self::RollPitchYaw => &ROLL_PITCH_YAW,
            Self::Matrix => &MATRIX,
        }
    }

    /// The title under which a file may have a column instead of our name: of a quaternion q0 to q3.
    pub(super) fn other_title(self, name: &str) -> Option<&'static str> {
        let Self::Quaternion(order) = self else { return None };
        let names = match order {
            QuaternionOrder::Xyzw => QUATERNION,
            QuaternionOrder::Wxyz => ["qw", "qx", "qy", "qz"],
        };
        names.iter().position(|known| *known == name).map(|at| NUMBERED[at])
    }

    /// The rotation of one row; angles in rad.
    pub(super) fn rotation(self, row: &[f64]) -> Result<Rotation3<f64>, String> {
        match (self, row) {
            (Self::RotationVector, &[x, y, z]) => Ok(Rotation3::new(Vector3::new(x, y, z))),
            (Self::Quaternion(_), &[x, y, z, w]) => {
                let quaternion = Quaternion::new(w, x, y, z);
                let length = quaternion.norm();
                if (length - 1.0).abs() > OFF_UNIT {
                    return Err(format!("the quaternion has the length {length:.6}, and must have 1"));
                }
                Ok(UnitQuaternion::from_quaternion(quaternion).to_rotation_matrix())
            }
            (Self::KukaAbc, &[a, b, c]) => Ok(Rotation3::from_euler_angles(c, b, a)),
            (Self::RollPitchYaw, &[roll, pitch, yaw]) => Ok(Rotation3::from_euler_angles(roll, pitch, yaw)),
            (Self::Matrix, row) if row.len() == 9 => of_matrix(&Matrix3::from_row_slice(row)),
            _ => Err("the row holds no orientation".into()),
        }
    }
}

/// The rotation nearest to a matrix that is one but for rounding.
fn of_matrix(matrix: &Matrix3<f64>) -> Result<Rotation3<f64>, String> {
    let off = (matrix * matrix.transpose() - Matrix3::identity()).amax();
    if off > OFF_UNIT {
        return Err(format!("the rows of the matrix are not of length 1 and at right angles (off by {off:.4})"));
    }
    if matrix.determinant() < 0.0 {
        return Err("the matrix mirrors: its determinant is -1".into());
    }
    Ok(nearest_rotation(matrix))
}
