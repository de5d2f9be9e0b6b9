//! Small dense solves for loop closure.

use nalgebra::{DMatrix, DVector, SMatrix, SVector};

/// Least-squares solution x of `a x = b` (row-major, `rows` x `columns`), and det a where a is square (else 0).
/// Fixed sizes, which most loops have, allocate nothing.
pub fn solve(a: &[f64], b: &[f64], rows: usize, columns: usize, x: &mut [f64]) -> Option<f64> {
    match (rows, columns) {
        (2, 2) => square2(a, b, x),
        (3, 3) => square3(a, b, x),
        (6, 6) => square6(a, b, x),
        _ => {
            let matrix = DMatrix::from_row_slice(rows, columns, a);
            if matrix.iter().chain(b).any(|v| !v.is_finite()) {
                return None; // the decomposition would not end
            }
            let determinant = if rows == columns { matrix.determinant() } else { 0.0 };
            let svd = matrix.try_svd(true, true, f64::EPSILON, 200)?;
            let tolerance = 1e-11 * svd.singular_values.max();
            let solution = svd.solve(&DVector::from_column_slice(b), tolerance).ok()?;
            x.copy_from_slice(solution.as_slice());
            Some(determinant)
        }
    }
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
