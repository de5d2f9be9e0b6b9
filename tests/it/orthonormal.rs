//! Bases and least squares of columns that may be dependent.

use elastogeo::math::{independent, least_squares, orthonormal, project_off};
use nalgebra::{DMatrix, DVector};

/// Columns of lengths between 1e-6 and 1e6; the last two depend on the first two.
fn columns() -> DMatrix<f64> {
    let entry = |i: usize, j: usize| ((3 * i * (j + 1) + 7 * j * j) as f64).sin() * 10f64.powi(4 * j as i32 - 6);
    let mut columns = DMatrix::from_fn(12, 6, entry);
    let sum = columns.column(0) * 2e6 + columns.column(1) * 3e2;
    columns.set_column(4, &sum);
    let scaled = columns.column(1) * -4e3;
    columns.set_column(5, &scaled);
    columns
}

#[test]
fn bases_are_orthonormal_and_span_the_columns() {
    let columns = columns();
    let basis = orthonormal(&columns, None);
    assert_eq!(basis.shape(), (12, 4));
    assert!((basis.tr_mul(&basis) - DMatrix::identity(4, 4)).abs().max() < 1e-14);
    for column in columns.column_iter() {
        let column = column.into_owned();
        assert!(project_off(&column, &basis).norm() < 1e-12 * column.norm());
    }
}

#[test]
fn what_is_added_is_orthogonal_to_the_basis() {
    let columns = columns();
    let first = orthonormal(&columns.columns(0, 2).into_owned(), None);
    let added = orthonormal(&columns, Some(&first));
    assert_eq!(added.ncols(), 2);
    assert!(first.tr_mul(&added).abs().max() < 1e-14);
    assert_eq!(independent(&columns, &first), [2, 3]);
    assert_eq!(orthonormal(&columns.columns(4, 2).into_owned(), Some(&first)).ncols(), 0);
}

#[test]
fn least_squares_is_exact_and_leaves_out_dependent_columns() {
    let columns = columns();
    let regular = columns.columns(0, 4).into_owned();
    let x = DVector::from_column_slice(&[3e5, -2.0, 1e-3, 4e-7]);
    let found = least_squares(&regular, &(&regular * &x));
    for (found, x) in found.iter().zip(&x) {
        assert!((found / x - 1.0).abs() < 1e-11, "{found} for {x}");
    }
    let right = DVector::from_fn(12, |i, _| (5 * i) as f64);
    let found = least_squares(&columns, &right);
    assert_eq!(found.iter().filter(|x| **x == 0.0).count(), 2);
    let residual = &right - &columns * &found;
    let best = project_off(&right, &orthonormal(&regular, None));
    assert!((residual - &best).norm() < 1e-11 * right.norm());
}
