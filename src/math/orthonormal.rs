//! Orthonormal bases and least squares for columns that may be dependent, by QR with column pivoting.
//!
//! Source: Golub and Van Loan, *Matrix Computations*, sections 5.4 and 5.5.

use nalgebra::allocator::Allocator;
use nalgebra::{DMatrix, DVector, DefaultAllocator, Dim, Dyn, OMatrix};

use super::linear::{PivotedQr, less_product, tr_mul};

/// A column is dependent if the columns before it leave less than this part of its length. Rounding leaves about 1e-16
/// times the condition of those columns, and an amount of a column that is new by less than 1e-6 cannot be estimated.
const DEPENDENT: f64 = 1e-6;

/// Columns are plainly independent where a Cholesky factor of the Gram matrix of those of length one has no diagonal below this:
/// rounding is then below 1e-13 in what they span.
const PLAIN: f64 = 0.03;

/// Orthonormal columns that span what `columns` (m x n) adds to the orthonormal `basis` (m x k).
pub fn orthonormal(columns: &DMatrix<f64>, basis: Option<&DMatrix<f64>>) -> DMatrix<f64> {
    if let Some(added) = plainly_orthonormal(columns, basis) {
        return added;
    }
    let (factors, rank) = factored(columns, basis);
    let mut added = factors.basis(rank);
    if let Some(basis) = basis {
        // Once more: subtraction leaves rounding in short remainders.
        added -= basis * basis.tr_mul(&added);
        added.column_iter_mut().for_each(|mut column| column /= column.norm());
    }
    added
}

/// The same by the Gram matrix, several times faster; `None` where columns are not plainly independent.
///
/// Source: Yamamoto, Nakatsukasa, Yanagisawa and Fukaya, *Roundoff error analysis of the CholeskyQR2 algorithm*, ETNA 44, 2015.
fn plainly_orthonormal(columns: &DMatrix<f64>, basis: Option<&DMatrix<f64>>) -> Option<DMatrix<f64>> {
    if columns.ncols() == 0 || columns.nrows() == 0 {
        return None;
    }
    let lengths: Vec<f64> = columns.column_iter().map(|column| column.norm()).collect();
    let mut own = match basis {
        Some(basis) if basis.ncols() > 0 => off(columns.clone(), basis),
        _ => columns.clone(),
    };
    for (mut column, length) in own.column_iter_mut().zip(&lengths) {
        let left = column.norm();
        if !(left > PLAIN * length && left.is_finite()) {
            return None;
        }
        column /= left;
    }
    // Twice: the first pass leaves rounding along the basis, and between the columns.
    for _ in 0..2 {
        let factor = tr_mul(&own, &own).cholesky().filter(|factor| factor.l_dirty().diagonal().min() > PLAIN)?;
        let mut inverse = DMatrix::identity(own.ncols(), own.ncols());
        factor.l_dirty().tr_solve_lower_triangular_mut(&mut inverse).then_some(())?;
        own = &own * inverse;
        if let Some(basis) = basis.filter(|basis| basis.ncols() > 0) {
            own = off(own, basis);
        }
    }
    Some(own)
}

/// Columns less their part along an orthonormal basis, once.
fn off(columns: DMatrix<f64>, basis: &DMatrix<f64>) -> DMatrix<f64> {
    let along = tr_mul(basis, &columns);
    less_product(columns, basis, &along)
}

/// Which of `columns` (m x n) are independent of the orthonormal `basis` (m x k) and of one another, ascending.
pub fn independent(columns: &DMatrix<f64>, basis: &DMatrix<f64>) -> Vec<usize> {
    let (factors, rank) = factored(columns, Some(basis));
    let mut chosen = factors.order()[..rank].to_vec();
    chosen.sort_unstable();
    chosen
}

/// Columns of two orthonormal bases in one matrix.
pub fn joined(a: &DMatrix<f64>, b: &DMatrix<f64>) -> DMatrix<f64> {
    let mut joined = a.clone().resize_horizontally(a.ncols() + b.ncols(), 0.0);
    joined.columns_mut(a.ncols(), b.ncols()).copy_from(b);
    joined
}

/// The part of a vector or of columns (m x n) that is orthogonal to an orthonormal basis (m x k), projected twice: the
/// first projection leaves rounding along the basis.
pub fn project_off<C: Dim>(columns: &OMatrix<f64, Dyn, C>, basis: &DMatrix<f64>) -> OMatrix<f64, Dyn, C>
where
    DefaultAllocator: Allocator<Dyn, C>,
{
    let once = columns - basis * basis.tr_mul(columns);
    &once - basis * basis.tr_mul(&once)
}

/// The `x` (n) that minimises `|columns x - right|`; dependent columns get zero.
pub fn least_squares(columns: &DMatrix<f64>, right: &DVector<f64>) -> DVector<f64> {
    let (factors, rank) = factored(columns, None);
    let x = factors.solve(rank, DMatrix::from_column_slice(right.len(), 1, right.as_slice()));
    DVector::from_fn(columns.ncols(), |j, _| x[(j, 0)] / columns.column(j).norm().max(f64::MIN_POSITIVE))
}

/// QR of the columns, of length one, less their part in `basis`, and its rank.
fn factored(columns: &DMatrix<f64>, basis: Option<&DMatrix<f64>>) -> (PivotedQr, usize) {
    let mut unit = columns.clone();
    for mut column in unit.column_iter_mut() {
        let length = column.norm();
        if length > 0.0 {
            column /= length;
        }
    }
    let factors = PivotedQr::new(match basis {
        Some(basis) => project_off(&unit, basis),
        None => unit,
    });
    let rank = factors.rank(DEPENDENT);
    (factors, rank)
}
