//! Factorisations of dense matrices, and the linear least squares and covariances made of them.
//!
//! [`faer`] factors, [`nalgebra`] holds the matrices. Every call passes `Par::Seq`: the same question gives the same bits
//! whatever else runs, and no setting of the host program is read or changed.
//!
//! Source: Golub and Van Loan, *Matrix Computations*, chapter 5 (QR, column pivoting, complete orthogonal decomposition,
//! least squares).

use faer::diag::Diag;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::householder::{
    apply_block_householder_sequence_on_the_left_in_place_scratch,
    apply_block_householder_sequence_on_the_left_in_place_with_conj,
    apply_block_householder_sequence_transpose_on_the_left_in_place_scratch,
    apply_block_householder_sequence_transpose_on_the_left_in_place_with_conj,
};
use faer::linalg::matmul::matmul;
use faer::linalg::qr::{col_pivoting, no_pivoting};
use faer::linalg::svd::{ComputeSvdVectors, svd, svd_scratch};
use faer::linalg::triangular_solve::{solve_lower_triangular_in_place, solve_upper_triangular_in_place};
use faer::{Accum, Conj, Mat, MatMut, MatRef, Par};
use nalgebra::{DMatrix, DVector};

/// Singular values below this part of the greatest count as zero in [`cofactor`].
const SINGULAR: f64 = 1e-12;

fn view(matrix: &DMatrix<f64>) -> MatRef<'_, f64> {
    MatRef::from_column_major_slice(matrix.as_slice(), matrix.nrows(), matrix.ncols())
}

fn view_mut(matrix: &mut DMatrix<f64>) -> MatMut<'_, f64> {
    let (rows, columns) = matrix.shape();
    MatMut::from_column_major_slice_mut(matrix.as_mut_slice(), rows, columns)
}

/// `a' b` (n x k) of columns as long (m x n, m x k): tall and narrow ones several times faster than by dot products.
pub fn tr_mul(a: &DMatrix<f64>, b: &DMatrix<f64>) -> DMatrix<f64> {
    let mut product = DMatrix::zeros(a.ncols(), b.ncols());
    matmul(view_mut(&mut product), Accum::Replace, view(a).transpose(), view(b), 1.0, Par::Seq);
    product
}

/// `c - a b` (m x k).
pub fn less_product(mut c: DMatrix<f64>, a: &DMatrix<f64>, b: &DMatrix<f64>) -> DMatrix<f64> {
    matmul(view_mut(&mut c), Accum::Add, view(a), view(b), -1.0, Par::Seq);
    c
}

/// Overwrites `matrix` (m x n) by its QR factors: R above the diagonal and on it, Householder vectors below. Returns the
/// coefficients of the reflections.
pub fn factor_in_place(mut matrix: MatMut<'_, f64>) -> Mat<f64> {
    let (rows, columns) = matrix.shape();
    if rows.min(columns) == 0 {
        return Mat::new();
    }
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

/// Overwrites `right` (m x any) by `Q' right`, from factors (m x n) and coefficients of [`factor_in_place`].
pub fn apply_transpose(factors: MatRef<'_, f64>, coefficients: MatRef<'_, f64>, right: MatMut<'_, f64>) {
    let (rows, columns) = factors.shape();
    if rows.min(columns) == 0 {
        return;
    }
    let scratch = apply_block_householder_sequence_transpose_on_the_left_in_place_scratch::<f64>(
        rows,
        coefficients.nrows(),
        right.ncols(),
    );
    apply_block_householder_sequence_transpose_on_the_left_in_place_with_conj(
        // A wide matrix has only as many Householder vectors as rows.
        factors.get(.., ..rows.min(columns)),
        coefficients,
        Conj::Yes,
        right,
        Par::Seq,
        MemStack::new(&mut MemBuffer::new(scratch)),
    );
}

/// Overwrites `right` (m x any) by `Q right`.
fn apply(factors: MatRef<'_, f64>, coefficients: MatRef<'_, f64>, right: MatMut<'_, f64>) {
    let (rows, columns) = factors.shape();
    if rows.min(columns) == 0 {
        return;
    }
    let scratch =
        apply_block_householder_sequence_on_the_left_in_place_scratch::<f64>(rows, coefficients.nrows(), right.ncols());
    apply_block_householder_sequence_on_the_left_in_place_with_conj(
        factors.get(.., ..rows.min(columns)),
        coefficients,
        Conj::No,
        right,
        Par::Seq,
        MemStack::new(&mut MemBuffer::new(scratch)),
    );
}

/// R (min(m, n) x n) of `matrix` = Q R: same column norms, singular values and least squares as the matrix itself.
pub fn triangle(mut matrix: DMatrix<f64>) -> DMatrix<f64> {
    factor_in_place(view_mut(&mut matrix));
    let size = matrix.nrows().min(matrix.ncols());
    DMatrix::from_fn(size, matrix.ncols(), |i, j| if i <= j { matrix[(i, j)] } else { 0.0 })
}

/// QR factors of a matrix (m x n) with its columns in an order of decreasing independence: `A P = Q R`.
pub struct PivotedQr {
    factors: DMatrix<f64>,
    coefficients: Mat<f64>,
    order: Vec<usize>,
}

impl PivotedQr {
    /// Factors a matrix of any shape and rank; all entries must be finite.
    pub fn new(mut matrix: DMatrix<f64>) -> Self {
        let (rows, columns) = matrix.shape();
        if rows.min(columns) == 0 {
            return Self { factors: matrix, coefficients: Mat::new(), order: (0..columns).collect() };
        }
        let block = no_pivoting::factor::recommended_block_size::<f64>(rows, columns);
        let mut coefficients = Mat::zeros(block, rows.min(columns));
        let (mut order, mut inverse) = (vec![0_usize; columns], vec![0_usize; columns]);
        let scratch =
            col_pivoting::factor::qr_in_place_scratch::<usize, f64>(rows, columns, block, Par::Seq, Default::default());
        col_pivoting::factor::qr_in_place(
            view_mut(&mut matrix),
            coefficients.as_mut(),
            &mut order,
            &mut inverse,
            Par::Seq,
            MemStack::new(&mut MemBuffer::new(scratch)),
            Default::default(),
        );
        Self { factors: matrix, coefficients, order }
    }

    /// Columns of the matrix in the order of the factors (n).
    pub fn order(&self) -> &[usize] {
        &self.order
    }

    /// What each column in the order adds to those before it: `|r_kk|` (min(m, n)), not ascending.
    pub fn added(&self) -> impl Iterator<Item = f64> {
        // `max`: of a matrix of zeros the pivoting leaves NaN, which adds nothing either.
        (0..self.factors.nrows().min(self.factors.ncols())).map(|k| self.factors[(k, k)].abs().max(0.0))
    }

    /// Number of columns that add more than `threshold`.
    pub fn rank(&self, threshold: f64) -> usize {
        self.added().take_while(|added| *added > threshold).count()
    }

    /// Orthonormal columns (m x `rank`) that span the first `rank` columns of the order.
    pub fn basis(&self, rank: usize) -> DMatrix<f64> {
        let mut basis = DMatrix::identity(self.factors.nrows(), rank);
        apply(view(&self.factors), self.coefficients.as_ref(), view_mut(&mut basis));
        basis
    }

    /// The `x` (n x any) that minimises `|A x - right|` with only the first `rank` columns of the order; others get zero.
    pub fn solve(&self, rank: usize, mut right: DMatrix<f64>) -> DMatrix<f64> {
        apply_transpose(view(&self.factors), self.coefficients.as_ref(), view_mut(&mut right));
        let mut x = right.rows(0, rank).into_owned();
        solve_upper_triangular_in_place(view(&self.factors).get(..rank, ..rank), view_mut(&mut x), Par::Seq);
        let mut solution = DMatrix::zeros(self.order.len(), right.ncols());
        for (row, &column) in x.row_iter().zip(&self.order) {
            solution.set_row(column, &row);
        }
        solution
    }
}

/// The `z` (n) of least norm among those that minimise `|a z + b|`.
///
/// `a` (k x n) may have any shape and rank. Its rank is read off a column-pivoted QR (a diagonal entry below
/// `max(k, n)` units of rounding of the first counts as zero), and a deficient triangle is folded by a second QR from the
/// right, which is the complete orthogonal decomposition (Golub and Van Loan, 5.5). All entries must be finite.
pub fn least_norm(a: DMatrix<f64>, b: &DVector<f64>) -> DVector<f64> {
    let (rows, columns) = a.shape();
    let mut z = DVector::zeros(columns);
    if rows.min(columns) == 0 {
        return z;
    }
    let qr = PivotedQr::new(a);
    let threshold = rows.max(columns) as f64 * f64::EPSILON * qr.factors[(0, 0)].abs();
    let rank = qr.rank(threshold);
    if rank == 0 {
        return z;
    }
    // R y = -(Q' b), y = P' z
    let mut right = Mat::from_fn(rows, 1, |i, _| -b[i]);
    let factors = view(&qr.factors);
    apply_transpose(factors, qr.coefficients.as_ref(), right.as_mut());
    let mut y = Mat::zeros(columns, 1);
    y.get_mut(..rank, ..).copy_from(right.get(..rank, ..));
    if rank == columns {
        solve_upper_triangular_in_place(factors.get(..rank, ..rank), y.as_mut(), Par::Seq);
    } else {
        // [R11 R12]' = Z T, so that R y = T' (Z' y): solve for Z' y and leave its other entries zero.
        let mut folded = Mat::from_fn(columns, rank, |i, j| if i >= j { factors[(j, i)] } else { 0.0 });
        let folds = factor_in_place(folded.as_mut());
        let transposed = folded.get(..rank, ..rank).transpose();
        solve_lower_triangular_in_place(transposed, y.get_mut(..rank, ..), Par::Seq);
        apply(folded.as_ref(), folds.as_ref(), y.as_mut());
    }
    for (position, &column) in qr.order.iter().enumerate() {
        z[column] = y[(position, 0)];
    }
    z
}

/// Thin singular value decomposition of a matrix (m x n), `U diag(s) V'`.
pub struct Svd {
    /// U (m x min(m, n)).
    pub left: DMatrix<f64>,
    /// s, descending.
    pub values: Vec<f64>,
    /// V (n x min(m, n)).
    pub right: DMatrix<f64>,
}

impl Svd {
    /// `None` when the iteration for the singular values fails; all entries must be finite.
    pub fn new(matrix: &DMatrix<f64>) -> Option<Self> {
        let (rows, columns) = matrix.shape();
        let size = rows.min(columns);
        let (mut left, mut right) = (DMatrix::zeros(rows, size), DMatrix::zeros(columns, size));
        let mut values = Diag::zeros(size);
        let thin = ComputeSvdVectors::Thin;
        let scratch = svd_scratch::<f64>(rows, columns, thin, thin, Par::Seq, Default::default());
        svd(
            view(matrix),
            values.as_mut(),
            Some(view_mut(&mut left)),
            Some(view_mut(&mut right)),
            Par::Seq,
            MemStack::new(&mut MemBuffer::new(scratch)),
            Default::default(),
        )
        .ok()?;
        let values = values.column_vector().iter().copied().collect();
        Some(Self { left, values, right })
    }
}

/// Singular values, descending; `None` when the iteration fails. All entries must be finite.
pub fn singular_values(matrix: &DMatrix<f64>) -> Option<Vec<f64>> {
    let (rows, columns) = matrix.shape();
    let mut values = Diag::zeros(rows.min(columns));
    let none = ComputeSvdVectors::No;
    let scratch = svd_scratch::<f64>(rows, columns, none, none, Par::Seq, Default::default());
    let memory = &mut MemBuffer::new(scratch);
    svd(view(matrix), values.as_mut(), None, None, Par::Seq, MemStack::new(memory), Default::default()).ok()?;
    Some(values.column_vector().iter().copied().collect())
}

/// `(J' J)^-1` (n x n) of a weighted Jacobian (m x n): covariances in units of the variance of a residual. Directions that
/// no residual depends on get zero (pseudo-inverse).
///
/// From the singular values of J with its columns scaled to length one, since lengths and angles differ by orders of
/// magnitude; J' J, which would square the condition number, is never formed.
pub fn cofactor(jacobian: &DMatrix<f64>) -> DMatrix<f64> {
    match rooted(jacobian, triangle) {
        Some((_, root)) => &root * root.transpose(),
        None => DMatrix::zeros(jacobian.ncols(), jacobian.ncols()),
    }
}

/// Orthonormal columns U (m x r) that span those of a matrix A (m x n) of rank r, and a root B (n x r) with `A' = B^+ U'`:
/// `(A' A)^-1 = B B'`, and the least-squares solution of `A x = b` is `B U' b`. `None` where the iteration for singular
/// values fails or an entry is not finite. Scaled as [`cofactor`].
pub fn factored(jacobian: &DMatrix<f64>) -> Option<(DMatrix<f64>, DMatrix<f64>)> {
    rooted(jacobian, |scaled| scaled)
}

/// U and B of [`factored`], U being of what is made of the matrix with its columns scaled to length one.
fn rooted(
    jacobian: &DMatrix<f64>,
    of_scaled: impl Fn(DMatrix<f64>) -> DMatrix<f64>,
) -> Option<(DMatrix<f64>, DMatrix<f64>)> {
    let n = jacobian.ncols();
    let lengths: Vec<f64> = jacobian.column_iter().map(|c| c.norm().max(f64::MIN_POSITIVE)).collect();
    let scaled = DMatrix::from_fn(jacobian.nrows(), n, |i, j| jacobian[(i, j)] / lengths[j]);
    if n == 0 || scaled.iter().any(|v| !v.is_finite()) {
        return None;
    }
    let Svd { left, values, right } = Svd::new(&of_scaled(scaled))?;
    let least = SINGULAR * values.first().copied().unwrap_or(0.0);
    let rank = values.iter().take_while(|value| **value > least).count();
    let root = DMatrix::from_fn(n, rank, |i, k| right[(i, k)] / values[k] / lengths[i]);
    Some((left.columns(0, rank).into_owned(), root))
}
