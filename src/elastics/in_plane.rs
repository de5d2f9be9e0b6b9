//! Which forces out of the plane of planar loops take part.
//!
//! The joints of a planar loop turn about parallel axes: forces along the axes and moments across them do no work on what moves
//! or deforms in the plane, and what the loop lets neither move nor deform out of it leaves them undetermined. Kinematics closes
//! such a loop in the plane whatever small misalignments its axes have; here too an axis that is slightly off must not make a
//! constraint of what constrains nothing. What is undetermined is hence judged with each member's own axis taken as the normal of
//! the plane, and is released; what is left is solved as it is, misalignments included.

use nalgebra::{Matrix3, Matrix6, Matrix6x3, Vector3, Vector6};

use super::compiled::Elastics;
use super::statics::{ClosingStatics, OutOfPlane, Statics};

/// Directions of a closure out of its plane: along z, about x and y.
const OUT_OF_PLANE: [usize; 3] = [2, 3, 4];
/// A compliance out of the plane below this fraction of the greatest in it counts as none: the square of a misalignment of 1 mrad,
/// by which what deforms in the plane is seen out of it.
const LEAST: f64 = 1e-6;
/// Cosine from which an axis of a member is taken as the normal of the plane: no misalignment is a tenth of a right angle.
const ALIGNED: f64 = 0.987;

impl Elastics<'_> {
    /// Releases the forces of planar closings that nothing out of their planes determines, in the equations of the unknowns.
    pub(super) fn release_undetermined(&self, out: &mut Statics) {
        if self.planar.is_empty() {
            return;
        }
        let mut found = std::mem::take(&mut out.out_of_plane);
        let reference = self.compliance_out_of_plane(out, &mut found);
        factor(&mut found.compliance, &mut found.unknowns, LEAST * reference);
        for &unknown in &found.unknowns {
            for k in 0..self.unknowns {
                out.matrix[unknown * self.unknowns + k] = 0.0;
                out.matrix[k * self.unknowns + unknown] = 0.0;
            }
        }
        out.out_of_plane = found;
    }

    /// Fills in the compliance of the planar closings out of their planes; the greatest in their planes or out of them, m/N.
    fn compliance_out_of_plane(&self, out: &Statics, found: &mut OutOfPlane) -> f64 {
        let OutOfPlane { forces, compliance, unknowns } = found;
        forces.resize_with(self.planar.len(), Vec::new);
        unknowns.clear();
        let mut greatest = 0.0_f64;
        for (forces, &closing) in forces.iter_mut().zip(&self.planar) {
            let (of, state) = (&self.closings[closing], &out.closings[closing]);
            unknowns.extend(OUT_OF_PLANE.iter().filter_map(|&direction| of.unknown[direction]));
            greatest = greatest.max(in_plane(state));
            self.flattened(out, closing, forces);
        }
        let size = 3 * self.planar.len();
        compliance.clear();
        compliance.resize(size * size, 0.0);
        for (i, &closing) in self.planar.iter().enumerate() {
            for (j, &other) in self.planar.iter().enumerate() {
                let mut block = Matrix3::zeros();
                for &(at, there) in &self.closings[closing].shared[other] {
                    let flexibility = &out.placed[self.closings[closing].cycle[at].0].flexibility;
                    let strains = Matrix6x3::from_columns(
                        &[0, 1, 2].map(|k| flexibility.apply(&forces[j][there].column(k).into_owned())),
                    );
                    block += forces[i][at].tr_mul(&strains);
                }
                for (row, column) in (0..3).flat_map(|row| (0..3).map(move |column| (row, column))) {
                    compliance[(3 * i + row) * size + 3 * j + column] = block[(row, column)];
                }
            }
        }
        let greatest = (0..size).fold(greatest, |most, k| most.max(compliance[k * size + k]));
        let reference = if greatest > 0.0 { greatest } else { 1.0 };
        self.add_releases(forces, reference, compliance);
        reference
    }

    /// Internal forces of a cycle by the closing's forces out of the plane, each member's own axis taken as the normal. Moments are
    /// those of a unit force at the length of the loop.
    fn flattened(&self, out: &Statics, closing: usize, forces: &mut Vec<Matrix6x3<f64>>) {
        let state = &out.closings[closing];
        let axes = |member: usize| -> Matrix3<f64> { out.placed[member].local.fixed_view::<3, 3>(0, 0).into_owned() };
        let normal = axes(self.in_tree + closing).row(2).transpose();
        let length = arm(state);
        forces.clear();
        for (own, &(member, _)) in state.forces.iter().zip(&self.closings[closing].cycle) {
            let normal = own_axis(&(axes(member) * normal));
            let column = |direction: usize| {
                let of = own.column(direction) * if direction < 3 { 1.0 } else { length };
                let (force, moment) = (of.fixed_rows::<3>(0).into_owned(), of.fixed_rows::<3>(3).into_owned());
                let (force, moment) = (normal * normal.dot(&force), moment - normal * normal.dot(&moment));
                Vector6::new(force.x, force.y, force.z, moment.x, moment.y, moment.z)
            };
            forces.push(Matrix6x3::from_columns(&OUT_OF_PLANE.map(column)));
        }
    }

    /// What is released out of the plane moves as far as anything.
    fn add_releases(&self, forces: &[Vec<Matrix6x3<f64>>], reference: f64, compliance: &mut [f64]) {
        let size = 3 * self.planar.len();
        for (index, release) in self.releases.iter().enumerate() {
            let mut row = vec![0.0; size];
            let mut greatest = 0.0_f64;
            for (i, &closing) in self.planar.iter().enumerate() {
                let own = self.closings[closing].releases.iter().find(|(_, own)| *own == index);
                let Some(&(at, _)) = own else { continue };
                let by = forces[i][at].row(release.direction).into_owned();
                by.iter().enumerate().for_each(|(k, by)| row[3 * i + k] = *by);
                greatest = greatest.max(by.amax());
            }
            if greatest > f64::EPSILON {
                for (k, by) in row.iter().enumerate() {
                    for (l, other) in row.iter().enumerate() {
                        compliance[k * size + l] += reference * (by / greatest) * (other / greatest);
                    }
                }
            }
        }
    }
}

/// Greatest compliance of a closing in its plane, m/N.
fn in_plane(state: &ClosingStatics) -> f64 {
    let along = |k: usize| -> f64 {
        state.forces.iter().zip(&state.strains).map(|(force, strain)| force.column(k).dot(&strain.column(k))).sum()
    };
    along(0).max(along(1))
}

/// Greatest arm of a closing's forces about the members of its cycle, m.
fn arm(state: &ClosingStatics) -> f64 {
    let arms = state.forces.iter().map(|forces: &Matrix6<f64>| forces.fixed_view::<3, 3>(3, 0).amax());
    let greatest = arms.fold(0.0_f64, f64::max);
    if greatest > 0.0 { greatest } else { 1.0 }
}

/// The axis of a member that is the normal of the plane but for a misalignment, else the normal itself.
fn own_axis(normal: &Vector3<f64>) -> Vector3<f64> {
    let axis = normal.iamax();
    if normal[axis].abs() > ALIGNED { Vector3::ith(axis, 1.0) } else { *normal }
}

/// Takes from `unknowns` those that a symmetric, positive semidefinite matrix determines: Cholesky's factorisation with the greatest
/// pivots first, down to `least` (Higham 2002, section 10.3).
fn factor(matrix: &mut [f64], unknowns: &mut Vec<usize>, least: f64) {
    let size = unknowns.len();
    let mut left: Vec<usize> = (0..size).collect();
    while let Some((position, &pivot)) =
        left.iter().enumerate().max_by(|(_, a), (_, b)| matrix[*a * size + *a].total_cmp(&matrix[*b * size + *b]))
    {
        let value = matrix[pivot * size + pivot];
        if value <= least || value.is_nan() {
            break;
        }
        left.swap_remove(position);
        for &row in &left {
            let share = matrix[row * size + pivot] / value;
            for &column in &left {
                matrix[row * size + column] -= share * matrix[pivot * size + column];
            }
        }
    }
    let undetermined = left.iter().map(|&at| unknowns[at]).collect();
    *unknowns = undetermined;
}
