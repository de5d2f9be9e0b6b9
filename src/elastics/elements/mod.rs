//! What gives: one file for each kind of element. A new kind needs its file, a variant of
//! [`crate::model::Element`], and a line where [`super::Elastics`] asks for its flexibility.

pub mod beam;
pub mod lumped;
pub mod screw;
pub mod spring;

use nalgebra::{Matrix6, Vector6};

/// Flexibility of an element in its local axes at its far end: deformations (displacement, rotation) by internal forces
/// (force, moment).
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Flexibility {
    /// Nothing gives.
    Rigid,
    /// Each direction by its own force.
    Diagonal([f64; 6]),
    /// A beam along x: x by Fx; y by Fy, y by Mz, phi_z by Mz; z by Fz, z by My, phi_y by My; phi_x by Mx.
    Beam([f64; 8]),
}

impl Flexibility {
    /// Deformation under internal forces.
    pub fn apply(&self, f: &Vector6<f64>) -> Vector6<f64> {
        match self {
            Self::Rigid => Vector6::zeros(),
            Self::Diagonal(c) => {
                Vector6::new(c[0] * f[0], c[1] * f[1], c[2] * f[2], c[3] * f[3], c[4] * f[4], c[5] * f[5])
            }
            Self::Beam([ax, yy, ym, mz, zz, zm, my, tx]) => Vector6::new(
                ax * f[0],
                yy * f[1] + ym * f[5],
                zz * f[2] + zm * f[4],
                tx * f[3],
                zm * f[2] + my * f[4],
                ym * f[1] + mz * f[5],
            ),
        }
    }

    /// Deformations under six sets of internal forces, one a column.
    pub fn apply_all(&self, f: &Matrix6<f64>) -> Matrix6<f64> {
        let mut out = Matrix6::zeros();
        match self {
            Self::Rigid => {}
            Self::Diagonal(c) => {
                for (k, c) in c.iter().enumerate().filter(|(_, c)| **c != 0.0) {
                    out.set_row(k, &(f.row(k) * *c));
                }
            }
            Self::Beam(_) => {
                for (mut to, from) in out.column_iter_mut().zip(f.column_iter()) {
                    to.copy_from(&self.apply(&from.into_owned()));
                }
            }
        }
        out
    }

    /// Whether nothing gives.
    pub fn is_rigid(&self) -> bool {
        match self {
            Self::Rigid => true,
            Self::Diagonal(c) => c.iter().all(|c| *c == 0.0),
            Self::Beam(c) => c.iter().all(|c| *c == 0.0),
        }
    }
}
