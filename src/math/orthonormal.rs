//! Orthonormal bases and least squares for columns that may be dependent, by QR with column pivoting (faer).
//!
//! Source: Golub and Van Loan, *Matrix Computations*, sec. 5.4 and 5.5.

use faer::linalg::solvers::ColPivQr;
use faer::linalg::triangular_solve::solve_upper_triangular_in_place;
use faer::{Mat, MatRef, Par};
use nalgebra::{DMatrix, DVector};

/// A column is dependent if the columns before it leave less than this share of its length. Rounding leaves about 1e-16
/// times the condition of those columns, and amounts of a column that is new by less than 1e-6 cannot be estimated.
const DEPENDENT: f64 = 1e-6;

/// Orthonormal columns that span what `columns` adds to the orthonormal `basis`.
pub fn orthonormal(columns: &DMatrix<f64>, basis: Option<&DMatrix<f64>>) -> DMatrix<f64> {
    let Some((factors, rank)) = factorised(columns, basis) else { return DMatrix::zeros(columns.nrows(), 0) };
    let q = factors.compute_thin_Q();
    let mut added = DMatrix::from_fn(columns.nrows(), rank, |i, k| q[(i, k)]);
    if let Some(basis) = basis {
        // Once more: subtraction leaves rounding in short remainders.
        added -= basis * basis.tr_mul(&added);
        added.column_iter_mut().for_each(|mut column| column /= column.norm());
    }
    added
}

/// Which of `columns` are independent of the orthonormal `basis` and of one another, ascending.
pub fn independent(columns: &DMatrix<f64>, basis: &DMatrix<f64>) -> Vec<usize> {
    let Some((factors, rank)) = factorised(columns, Some(basis)) else { return Vec::new() };
    let mut chosen = factors.P().arrays().0[..rank].to_vec();
    chosen.sort_unstable();
    chosen
}

/// Columns of two orthonormal bases in one matrix.
pub fn joined(a: &DMatrix<f64>, b: &DMatrix<f64>) -> DMatrix<f64> {
    let mut joined = DMatrix::zeros(a.nrows(), a.ncols() + b.ncols());
    joined.columns_mut(0, a.ncols()).copy_from(a);
    joined.columns_mut(a.ncols(), b.ncols()).copy_from(b);
    joined
}

/// The part of a vector that is orthogonal to an orthonormal basis.
pub fn project_off(vector: &DVector<f64>, basis: &DMatrix<f64>) -> DVector<f64> {
    let once = vector - basis * basis.tr_mul(vector);
    &once - basis * basis.tr_mul(&once)
}

/// Least-squares solution; dependent columns get zero.
pub fn least_squares(columns: &DMatrix<f64>, right: &DVector<f64>) -> DVector<f64> {
    let mut solution = DVector::zeros(columns.ncols());
    let Some((factors, rank)) = factorised(columns, None) else { return solution };
    let q = factors.compute_thin_Q();
    let right = MatRef::from_column_major_slice(right.as_slice(), right.len(), 1);
    let mut x: Mat<f64> = q.get(.., ..rank).transpose() * right;
    solve_upper_triangular_in_place(factors.thin_R().get(..rank, ..rank), x.as_mut(), Par::Seq);
    for (k, &column) in factors.P().arrays().0[..rank].iter().enumerate() {
        solution[column] = x[(k, 0)] / columns.column(column).norm();
    }
    solution
}

/// QR of the columns, of length one, less their part in `basis`, and its rank; `None` where it is zero.
fn factorised(columns: &DMatrix<f64>, basis: Option<&DMatrix<f64>>) -> Option<(ColPivQr<f64>, usize)> {
    let mut scaled = columns.clone();
    for mut column in scaled.column_iter_mut() {
        let length = column.norm();
        if length > 0.0 {
            column /= length;
        }
    }
    if let Some(basis) = basis {
        for _ in 0..2 {
            let along = basis.tr_mul(&scaled);
            scaled -= basis * along;
        }
    }
    if scaled.is_empty() {
        return None;
    }
    let factors = MatRef::from_column_major_slice(scaled.as_slice(), scaled.nrows(), scaled.ncols()).col_piv_qr();
    let r = factors.thin_R();
    let rank = (0..r.nrows().min(r.ncols())).take_while(|&k| r[(k, k)].abs() >= DEPENDENT).count();
    (rank > 0).then_some((factors, rank))
}
