//! Flexibility of an element: deformations (displacement m, rotation rad) by internal forces (N, N.m), in its local axes
//! at its far end.

use nalgebra::{Matrix6, Vector6};

/// Flexibility of an element, or its derivative.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Flexibility {
    /// Does not deform.
    #[default]
    Rigid,
    /// One direction by its own force: direction (0 to 5) and compliance.
    Single(usize, f64),
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
            Self::Single(k, c) => {
                let mut out = Vector6::zeros();
                out[*k] = c * f[*k];
                out
            }
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
            Self::Single(k, c) => out.set_row(*k, &(f.row(*k) * *c)),
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

    /// Work of virtual forces (one set a column) on the deformation under internal forces: `virtual' F forces`.
    pub fn work(&self, virtual_forces: &Matrix6<f64>, forces: &Vector6<f64>) -> Vector6<f64> {
        match self {
            Self::Rigid => Vector6::zeros(),
            Self::Single(k, c) => virtual_forces.row(*k).transpose() * (c * forces[*k]),
            _ => virtual_forces.tr_mul(&self.apply(forces)),
        }
    }
}
