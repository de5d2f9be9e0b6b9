//! Straight beam in space, Euler-Bernoulli or Timoshenko.
//!
//! Local x runs from its first node to its second, z is the stated normal made orthogonal to it, y = z x x; Iz resists
//! bending in the x-y plane. The flexibility is that of the second node with the first held, which is the inverse of
//! the free block of the 12x12 stiffness matrix (Przemieniecki 1968, ch. 5).

use nalgebra::{Matrix3, Vector3, Vector6};
use num_dual::DualNum;

use super::Flexibility;
use crate::elastics::section::Properties;

/// What a beam gives per unit of internal force and length: 1/(E A), 1/(G Asy), 1/(G Asz), 1/(E Iy), 1/(E Iz), 1/(G J);
/// zero where it is rigid. Shear is left out of Euler-Bernoulli beams.
pub type Inverse = [f64; 6];

/// Inverse rigidities of a section in a material (moduli in Pa).
pub fn inverse<D: DualNum<Primitive = f64> + Copy>(
    section: &Properties<D>,
    young: D,
    shear: D,
    timoshenko: bool,
) -> [D; 6] {
    let none = D::from(0.0);
    let by_shear = |area: D| if timoshenko { (shear * area).recip() } else { none };
    [
        (young * section.area).recip(),
        by_shear(section.shear_y),
        by_shear(section.shear_z),
        (young * section.iy).recip(),
        (young * section.iz).recip(),
        (shear * section.j).recip(),
    ]
}

/// Flexibility of a beam of a length (m).
pub fn flexibility([a, sy, sz, y, z, j]: Inverse, l: f64) -> Flexibility {
    let (l2, l3) = (l * l, l * l * l);
    Flexibility::Beam([
        l * a,
        l3 / 3.0 * z + l * sy,
        l2 / 2.0 * z,
        l * z,
        l3 / 3.0 * y + l * sz,
        -l2 / 2.0 * y,
        l * y,
        l * j,
    ])
}

/// Derivative of [`flexibility`] by the length.
pub fn by_length([a, sy, sz, y, z, j]: Inverse, l: f64) -> Flexibility {
    Flexibility::Beam([a, l * l * z + sy, l * z, z, l * l * y + sz, -l * y, y, j])
}

/// Derivative of [`under_own_load`] by the length.
pub fn own_load_by_length([a, sy, sz, y, z, _]: Inverse, l: f64, q: &Vector3<f64>) -> Vector6<f64> {
    let (l2, l3) = (l * l, l * l * l);
    Vector6::new(
        q.x * l * a,
        q.y * (l3 / 2.0 * z + l * sy),
        q.z * (l3 / 2.0 * y + l * sz),
        0.0,
        -q.z * l2 / 2.0 * y,
        q.y * l2 / 2.0 * z,
    )
}

/// Deformation of the second node, the first held, under a uniform load (N/m, local axes).
pub fn under_own_load([a, sy, sz, y, z, _]: Inverse, l: f64, q: &Vector3<f64>) -> Vector6<f64> {
    let (l2, l3) = (l * l, l * l * l);
    Vector6::new(
        q.x * l2 / 2.0 * a,
        q.y * (l2 * l2 / 8.0 * z + l2 / 2.0 * sy),
        q.z * (l2 * l2 / 8.0 * y + l2 / 2.0 * sz),
        0.0,
        -q.z * l3 / 6.0 * y,
        q.y * l3 / 6.0 * z,
    )
}

/// Local axes (columns) of a beam from one point to another, and its length. Where the normal is along the beam, as it
/// should not be, any other serves.
pub fn axes(from: &Vector3<f64>, to: &Vector3<f64>, normal: &Vector3<f64>) -> (Matrix3<f64>, f64) {
    let along = to - from;
    let length = along.norm();
    let x = along / length.max(f64::MIN_POSITIVE);
    let mut z = normal - x * x.dot(normal);
    if z.norm() < 1e-6 {
        let other = if x.x.abs() < 0.9 { Vector3::x() } else { Vector3::y() };
        z = other - x * x.dot(&other);
    }
    z /= z.norm().max(f64::MIN_POSITIVE);
    (Matrix3::from_columns(&[x, z.cross(&x), z]), length)
}
