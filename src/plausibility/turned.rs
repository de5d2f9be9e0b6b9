//! Other ways to read a measured orientation: the same numbers by another convention.

use std::f64::consts::PI;

use nalgebra::{Quaternion, Rotation3, UnitQuaternion, Vector3};

use crate::math::rotation_vector;
use crate::settings::named;

/// How an orientation may be meant instead.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Turned {
    /// The rotation back: conjugate quaternion, transposed matrix, angles of the base in the body.
    Inverse,
    /// A rotation vector in the unit before, declared in the one after.
    Unit(Angles, Angles),
    /// Three angles about z, y', x'' in the unit before, declared in the one after.
    AnglesUnit(Angles, Angles),
    /// They are in the order x, y, z.
    Reversed,
    /// They turn about x, y', z''.
    Xyz,
    /// They turn about z, y', z''.
    Zyz,
    /// The same, the second of them beyond a quarter turn, as where a tool points down.
    ZyzDown,
    /// They are the components of a rotation vector.
    Vector,
    /// The components of a rotation vector are angles about z, y', x''.
    Zyx,
    /// They are angles about the fixed x, y, z.
    RollPitchYaw,
    /// A quaternion in the order x, y, z, w is in the order w, x, y, z.
    ScalarFirst,
    /// The reverse.
    ScalarLast,
}

named! {
    /// Units of angles.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum Angles {
        Degrees "deg",
        Radians "rad",
        Milliradians "mrad",
        Gon "gon",
        Turns "turns",
    }
}

impl Angles {
    /// In which angles of joints are recorded, and declared.
    pub const MISTAKEN: [(Self, Self); 8] = [
        (Self::Radians, Self::Degrees),
        (Self::Degrees, Self::Radians),
        (Self::Milliradians, Self::Degrees),
        (Self::Milliradians, Self::Radians),
        (Self::Gon, Self::Degrees),
        (Self::Gon, Self::Radians),
        (Self::Turns, Self::Degrees),
        (Self::Turns, Self::Radians),
    ];

    /// Of one column among right ones.
    pub const EXCHANGED: [(Self, Self); 4] = [
        (Self::Radians, Self::Degrees),
        (Self::Degrees, Self::Radians),
        (Self::Gon, Self::Degrees),
        (Self::Gon, Self::Radians),
    ];

    /// One, rad.
    pub const fn size(self) -> f64 {
        match self {
            Self::Degrees => PI / 180.0,
            Self::Radians => 1.0,
            Self::Milliradians => 1e-3,
            Self::Gon => PI / 200.0,
            Self::Turns => 2.0 * PI,
        }
    }
}

impl Turned {
    /// All of them.
    pub const ALL: [Self; 15] = [
        Self::Inverse,
        Self::Unit(Angles::Radians, Angles::Degrees),
        Self::Unit(Angles::Degrees, Angles::Radians),
        Self::Unit(Angles::Gon, Angles::Degrees),
        Self::Unit(Angles::Gon, Angles::Radians),
        Self::AnglesUnit(Angles::Radians, Angles::Degrees),
        Self::Reversed,
        Self::Xyz,
        Self::Zyz,
        Self::ZyzDown,
        Self::Vector,
        Self::Zyx,
        Self::RollPitchYaw,
        Self::ScalarFirst,
        Self::ScalarLast,
    ];

    /// The rotation vector (rad) that the same numbers mean when they are read so, of what they mean as declared.
    pub fn read(self, declared: &Vector3<f64>) -> Vector3<f64> {
        let rotation = Rotation3::new(*declared);
        let (x, y, z) = rotation.euler_angles();
        let about = |axis, angle| Rotation3::from_axis_angle(&axis, angle);
        let (x_axis, y_axis, z_axis) = (Vector3::x_axis(), Vector3::y_axis(), Vector3::z_axis());
        let meant = match self {
            Self::Inverse => rotation.inverse(),
            Self::Unit(meant, read) => Rotation3::new(declared * (meant.size() / read.size())),
            Self::AnglesUnit(meant, read) => {
                let factor = meant.size() / read.size();
                about(z_axis, factor * z) * about(y_axis, factor * y) * about(x_axis, factor * x)
            }
            Self::Reversed => about(z_axis, x) * about(y_axis, y) * about(x_axis, z),
            Self::Xyz => about(x_axis, x) * about(y_axis, y) * about(z_axis, z),
            Self::Zyz => about(z_axis, z) * about(y_axis, y) * about(z_axis, x),
            // The same rotation as three angles of which the second is beyond a quarter turn.
            Self::ZyzDown => about(z_axis, z + PI) * about(y_axis, PI - y) * about(z_axis, x + PI),
            Self::Vector => Rotation3::new(Vector3::new(z, y, x)),
            Self::Zyx => about(z_axis, declared.x) * about(y_axis, declared.y) * about(x_axis, declared.z),
            Self::RollPitchYaw => about(z_axis, declared.z) * about(y_axis, declared.y) * about(x_axis, declared.x),
            Self::ScalarFirst => permuted(&rotation, |[x, y, z, w]| [y, z, w, x]),
            Self::ScalarLast => permuted(&rotation, |[x, y, z, w]| [w, x, y, z]),
        };
        rotation_vector(&meant)
    }
}

/// The rotation of a quaternion's components (x, y, z, w) in another order.
fn permuted(rotation: &Rotation3<f64>, order: impl Fn([f64; 4]) -> [f64; 4]) -> Rotation3<f64> {
    let own = UnitQuaternion::from_rotation_matrix(rotation);
    let [x, y, z, w] = order([own.i, own.j, own.k, own.w]);
    UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z)).to_rotation_matrix()
}
