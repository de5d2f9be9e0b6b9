//! QR factorisations and the least-norm solution of a least-squares problem.
//!
//! Sequential on purpose (`Par::Seq`): the same question gives the same bits, whatever runs beside it.

use faer::diag::Diag;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::householder::{
    apply_block_householder_sequence_on_the_left_in_place_scratch,
    apply_block_householder_sequence_on_the_left_in_place_with_conj,
    apply_block_householder_sequence_transpose_on_the_left_in_place_scratch,
    apply_block_householder_sequence_transpose_on_the_left_in_place_with_conj,
};
use faer::linalg::qr::{col_pivoting, no_pivoting};
use faer::linalg::svd::{ComputeSvdVectors, svd, svd_scratch};
use faer::linalg::triangular_solve::{solve_lower_triangular_in_place, solve_upper_triangular_in_place};
use faer::{Conj, Mat, MatMut, MatRef, Par};
use nalgebra::{DMatrix, DVector};

/// Overwrites `matrix` (column by column, `rows` long) by its QR factors; the upper triangle is R.
///
/// Returns the Householder coefficients.
pub(super) fn factor_in_place(mut matrix: MatMut<'_, f64>) -> Mat<f64> {
    let (rows, columns) = matrix.shape();
    let block = no_pivoting::factor::recommended_block_size::<f64>(rows, columns);
    let mut coefficients = Mat::zeros(block, rows.min(columns));
    let scratch = no_pivoting::factor::qr_in_place_scratch::<f64>(rows, columns, block, Par::Seq, Default::default());
    no_pivoting::factor::qr_in_place(
        matrix.as_mut(),
        coefficients.as_mut(),
        Par::Seq,
        MemStack::new(&mut MemBuffer::new(scratch)),
        Default::default(),
    );
    coefficients
}

/// The `z` of least norm among those that minimise `|a z + b|`.
///
/// `a` (k x n) may have any shape and rank. Its rank is read off a column-pivoted QR (a diagonal entry below
/// `max(k, n)` units of rounding of the first counts as zero), and a deficient triangle is folded by a second QR from the
/// right, which is the complete orthogonal decomposition (Golub and Van Loan, *Matrix Computations*, 5.5). All entries
/// must be finite.
pub(super) fn least_norm(a: &DMatrix<f64>, b: &DVector<f64>) -> DVector<f64> {
    let (rows, columns) = a.shape();
    let size = rows.min(columns);
    let mut z = DVector::zeros(columns);
    if size == 0 {
        return z;
    }
    let mut factors = MatRef::from_column_major_slice(a.as_slice(), rows, columns).to_owned();
    let block = no_pivoting::factor::recommended_block_size::<f64>(rows, columns);
    let mut coefficients = Mat::zeros(block, size);
    let mut order = vec![0_usize; columns];
    let mut inverse = vec![0_usize; columns];
    let scratch =
        col_pivoting::factor::qr_in_place_scratch::<usize, f64>(rows, columns, block, Par::Seq, Default::default());
    col_pivoting::factor::qr_in_place(
        factors.as_mut(),
        coefficients.as_mut(),
        &mut order,
        &mut inverse,
        Par::Seq,
        MemStack::new(&mut MemBuffer::new(scratch)),
        Default::default(),
    );

    let threshold = rows.max(columns) as f64 * f64::EPSILON * factors[(0, 0)].abs();
    let rank = (0..size).take_while(|&i| factors[(i, i)].abs() > threshold).count();
    if rank == 0 {
        return z;
    }

    // R y = -(Q' b), y = P' z
    let mut right = Mat::from_fn(rows, 1, |i, _| -b[i]);
    apply_transpose(factors.as_ref(), coefficients.as_ref(), right.as_mut());
    let mut y = Mat::zeros(columns, 1);
    y.get_mut(..rank, ..).copy_from(right.get(..rank, ..));
    if rank == columns {
        solve_upper_triangular_in_place(factors.get(..rank, ..rank), y.as_mut(), Par::Seq);
    } else {
        // [R11 R12]' = Z T, so that R y = T' (Z' y): solve for Z' y and leave the rest of it zero.
        let mut folded = Mat::from_fn(columns, rank, |i, j| if i >= j { factors[(j, i)] } else { 0.0 });
        let folds = factor_in_place(folded.as_mut());
        let triangle = folded.get(..rank, ..rank).transpose();
        solve_lower_triangular_in_place(triangle, y.get_mut(..rank, ..), Par::Seq);
        let scratch = apply_block_householder_sequence_on_the_left_in_place_scratch::<f64>(columns, folds.nrows(), 1);
        apply_block_householder_sequence_on_the_left_in_place_with_conj(
            folded.as_ref(),
            folds.as_ref(),
            Conj::No,
            y.as_mut(),
            Par::Seq,
            MemStack::new(&mut MemBuffer::new(scratch)),
        );
    }
    for (position, &column) in order.iter().enumerate() {
        z[column] = y[(position, 0)];
    }
    z
}

/// Overwrites `right` by `Q' right`, for the Q of QR factors and their coefficients.
pub(super) fn apply_transpose(factors: MatRef<'_, f64>, coefficients: MatRef<'_, f64>, right: MatMut<'_, f64>) {
    let (rows, columns) = factors.shape();
    // The Householder vectors are the columns below the diagonal; a wide matrix has only `rows` of them.
    let basis = factors.get(.., ..rows.min(columns));
    let scratch = apply_block_householder_sequence_transpose_on_the_left_in_place_scratch::<f64>(
        rows,
        coefficients.nrows(),
        right.ncols(),
    );
    apply_block_householder_sequence_transpose_on_the_left_in_place_with_conj(
        basis,
        coefficients,
        Conj::Yes,
        right,
        Par::Seq,
        MemStack::new(&mut MemBuffer::new(scratch)),
    );
}

/// Singular values and vectors of a matrix, to solve damped problems with it.
pub(super) struct Spectrum {
    left: Mat<f64>,
    values: Vec<f64>,
    right: Mat<f64>,
}

impl Spectrum {
    /// `None` when the iteration for the singular values fails; all entries must be finite.
    pub fn new(a: &DMatrix<f64>) -> Option<Self> {
        let (rows, columns) = a.shape();
        let size = rows.min(columns);
        let (mut left, mut right) = (Mat::zeros(rows, size), Mat::zeros(columns, size));
        let mut values = Diag::zeros(size);
        let thin = ComputeSvdVectors::Thin;
        let scratch = svd_scratch::<f64>(rows, columns, thin, thin, Par::Seq, Default::default());
        svd(
            MatRef::from_column_major_slice(a.as_slice(), rows, columns),
            values.as_mut(),
            Some(left.as_mut()),
            Some(right.as_mut()),
            Par::Seq,
            MemStack::new(&mut MemBuffer::new(scratch)),
            Default::default(),
        )
        .ok()?;
        let values = values.column_vector().iter().copied().collect();
        Some(Self { left, values, right })
    }

    /// The damping `mu` and the `z` minimising `|a z + b|^2 + mu |z|^2` whose norm is just within `radius`; the
    /// undamped minimiser must be longer than that.
    ///
    /// With the spectrum at hand `|z(mu)|` costs n operations; Newton's method on `1 / |z(mu)|`, which is nearly straight
    /// (Hebden 1973; Moré 1978, section 5), is kept inside a bracket.
    pub fn damped(&self, b: &DVector<f64>, radius: f64) -> (f64, DVector<f64>) {
        let n = self.right.nrows();
        let along: Vec<f64> = (0..self.values.len())
            .map(|i| self.values[i] * self.left.col(i).iter().zip(b).map(|(u, b)| u * b).sum::<f64>())
            .collect();
        let norm = |mu: f64| -> (f64, f64) {
            let terms = along.iter().zip(&self.values).map(|(c, s)| {
                let stiffness = s * s + mu;
                let z = c / stiffness;
                (z * z, z * z / stiffness)
            });
            let (square, slope) = terms.fold((0.0, 0.0), |sum, term| (sum.0 + term.0, sum.1 + term.1));
            (square.sqrt(), slope / square.sqrt())
        };
        let target = 0.95 * radius;
        // z(mu) is never longer than |a' b| / mu.
        let mut bracket = (0.0, along.iter().map(|c| c * c).sum::<f64>().sqrt() / target);
        let mut mu = 1e-3 * bracket.1;
        for _ in 0..100 {
            let (length, slope) = norm(mu);
            if (length - target).abs() <= 0.05 * radius {
                break;
            }
            if length > target {
                bracket.0 = mu;
            } else {
                bracket.1 = mu;
            }
            let next = mu + (length - target) / target * length / slope;
            let inside = bracket.0 < next && next < bracket.1;
            mu = if inside { next } else { (bracket.0.max(1e-6 * bracket.1) * bracket.1).sqrt() };
        }
        let mut z = DVector::zeros(n);
        for (i, (c, s)) in along.iter().zip(&self.values).enumerate() {
            let factor = -c / (s * s + mu);
            for (z, v) in z.iter_mut().zip(self.right.col(i).iter()) {
                *z += factor * v;
            }
        }
        (mu, z)
    }
}
