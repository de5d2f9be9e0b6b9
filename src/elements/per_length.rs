//! What one metre of a straight uniform element gives and weighs, and what that makes of an element of a length.
//!
//! Local x runs along the element. Deformations are those of its second end with the first held: the inverse of the free
//! block of the 12x12 stiffness matrix (Przemieniecki 1968, ch. 5).

use nalgebra::{Vector3, Vector6};

use super::flexibility::Flexibility;

/// A straight uniform element per metre.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PerLength {
    /// 1/(E A), 1/(G Asy), 1/(G Asz), 1/(E Iy), 1/(E Iz), 1/(G J); zero where it is rigid.
    pub compliance: [f64; 6],
    /// kg/m.
    pub mass: f64,
}

impl PerLength {
    /// Flexibility at a length (m).
    pub fn flexibility(&self, l: f64) -> Flexibility {
        let [a, sy, sz, y, z, j] = self.compliance;
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

    /// Derivative of [`PerLength::flexibility`] by the length.
    pub fn flexibility_by_length(&self, l: f64) -> Flexibility {
        let [a, sy, sz, y, z, j] = self.compliance;
        Flexibility::Beam([a, l * l * z + sy, l * z, z, l * l * y + sz, -l * y, y, j])
    }

    /// Deformation under a uniform load `q` (N/m, local axes).
    pub fn under_load(&self, l: f64, q: &Vector3<f64>) -> Vector6<f64> {
        let [a, sy, sz, y, z, _] = self.compliance;
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

    /// Strain energy under a uniform load `q` alone (N/m, local axes), held at the first end, J.
    pub fn energy_under_load(&self, l: f64, q: &Vector3<f64>) -> f64 {
        let [a, sy, sz, y, z, _] = self.compliance;
        let (l3, l5) = (l.powi(3) / 6.0, l.powi(5) / 40.0);
        q.x * q.x * l3 * a + q.y * q.y * (l5 * z + l3 * sy) + q.z * q.z * (l5 * y + l3 * sz)
    }

    /// Derivative of [`PerLength::under_load`] by the length.
    pub fn under_load_by_length(&self, l: f64, q: &Vector3<f64>) -> Vector6<f64> {
        let [a, sy, sz, y, z, _] = self.compliance;
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
}
