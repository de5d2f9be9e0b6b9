//! Small dense solves for loop closure.

use nalgebra::{DMatrix, DVector, Dyn, LU, SMatrix, SVector};

use crate::math::linear::Svd;

/// Singular values below this share of the greatest are taken for zero: loops with self-motions have such.
const SINGULAR: f64 = 1e-11;
/// Pivots above this share of the greatest show that a square matrix is regular.
const REGULAR: f64 = 1e-9;

/// Least-squares solution x of `a x = b` (row-major, `rows` x `columns`), and det a where a is square (else 0).
/// Fixed sizes, which most loops have, allocate nothing.
pub fn solve(a: &[f64], b: &[f64], rows: usize, columns: usize, x: &mut [f64]) -> Option<f64> {
    match (rows, columns) {
        (2, 2) => square2(a, b, x),
        (3, 3) => square3(a, b, x),
        (6, 6) => square6(a, b, x),
        _ => {
            let matrix = finite(a, rows, columns).filter(|_| b.iter().all(|v| v.is_finite()))?;
            let right = DVector::from_column_slice(b);
            let lu = (rows == columns).then(|| matrix.clone().lu());
            let determinant = lu.as_ref().map_or(0.0, |lu| lu.determinant());
            let regular = lu.filter(is_regular).and_then(|lu| lu.solve(&right));
            let solution = match regular {
                Some(solution) => solution,
                None => pseudo_inverse(&matrix)? * right,
            };
            x.copy_from_slice(solution.as_slice());
            Some(determinant)
        }
    }
}

/// Pseudo-inverse of a matrix (row-major, `rows` x `columns`) into `inverse` (row-major, `columns` x `rows`); `None` where
/// an entry is not finite.
pub fn invert(a: &[f64], rows: usize, columns: usize, inverse: &mut [f64]) -> Option<()> {
    let matrix = finite(a, rows, columns)?;
    let regular = (rows == columns).then(|| matrix.clone().lu()).filter(is_regular).and_then(|lu| lu.try_inverse());
    let found = match regular {
        Some(found) => found,
        None => pseudo_inverse(&matrix)?,
    };
    // Its transpose by columns is itself by rows.
    inverse.copy_from_slice(found.transpose().as_slice());
    Some(())
}

fn finite(a: &[f64], rows: usize, columns: usize) -> Option<DMatrix<f64>> {
    a.iter().all(|v| v.is_finite()).then(|| DMatrix::from_row_slice(rows, columns, a))
}

fn is_regular(lu: &LU<f64, Dyn, Dyn>) -> bool {
    let pivots = lu.u().diagonal().abs();
    pivots.min() > REGULAR * pivots.max()
}

fn pseudo_inverse(matrix: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let Svd { left, values, right } = Svd::new(matrix)?;
    let least = SINGULAR * values.first().copied().unwrap_or(0.0);
    let rank = values.iter().take_while(|value| **value > least).count();
    let scaled = DMatrix::from_fn(right.nrows(), rank, |i, k| right[(i, k)] / values[k]);
    Some(scaled * left.columns(0, rank).transpose())
}

/// Square systems of a fixed size; a macro because nalgebra's LU is not generic over a size parameter.
macro_rules! square {
    ($name:ident, $n:literal) => {
        fn $name(a: &[f64], b: &[f64], x: &mut [f64]) -> Option<f64> {
            let lu = SMatrix::<f64, $n, $n>::from_row_slice(a).lu();
            let determinant = lu.determinant();
            let solution = lu.solve(&SVector::<f64, $n>::from_column_slice(b))?;
            if determinant == 0.0 || solution.iter().any(|v| !v.is_finite()) {
                return None;
            }
            x.copy_from_slice(solution.as_slice());
            Some(determinant)
        }
    };
}
square!(square2, 2);
square!(square3, 3);
square!(square6, 6);
