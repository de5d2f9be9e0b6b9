//! Projections: one orthonormal basis, to which directions are added.

use nalgebra::{DMatrix, DVector};

/// Columns that are left with less than this of their length are dependent.
const DEPENDENT: f64 = 1e-6;

/// Orthonormal columns spanning those of `matrix` (pivoted Gram-Schmidt, twice), beside an orthonormal `basis` to which
/// they are made orthogonal first.
pub fn orthonormal(matrix: &DMatrix<f64>, basis: Option<&DMatrix<f64>>) -> DMatrix<f64> {
    independent(matrix, basis).1
}

/// As [`orthonormal`], with the columns that were found independent, ascending.
pub fn independent(matrix: &DMatrix<f64>, basis: Option<&DMatrix<f64>>) -> (Vec<usize>, DMatrix<f64>) {
    let rows = matrix.nrows();
    let mut left = matrix.clone();
    let lengths: Vec<f64> = matrix.column_iter().map(|c| c.norm()).collect();
    for (mut column, length) in left.column_iter_mut().zip(&lengths) {
        if *length > 0.0 {
            column /= *length;
        }
    }
    if let Some(basis) = basis {
        for _ in 0..2 {
            let shadow = basis.tr_mul(&left);
            left -= basis * shadow;
        }
    }
    let mut found: Vec<DVector<f64>> = Vec::new();
    let mut chosen = Vec::new();
    let mut open: Vec<usize> = (0..left.ncols()).filter(|&j| lengths[j] > 0.0).collect();
    while let Some(at) =
        (0..open.len()).max_by(|&a, &b| left.column(open[a]).norm().total_cmp(&left.column(open[b]).norm()))
    {
        let j = open.swap_remove(at);
        let norm = left.column(j).norm();
        if norm < DEPENDENT {
            break;
        }
        let mut q: DVector<f64> = left.column(j) / norm;
        // Once more against all: what was subtracted leaves rounding.
        if let Some(basis) = basis {
            q -= basis * basis.tr_mul(&q);
        }
        for known in &found {
            q -= known * known.dot(&q);
        }
        q /= q.norm();
        for &k in &open {
            let shadow = q.dot(&left.column(k));
            left.column_mut(k).axpy(-shadow, &q, 1.0);
        }
        found.push(q);
        chosen.push(j);
    }
    chosen.sort_unstable();
    (chosen, if found.is_empty() { DMatrix::zeros(rows, 0) } else { DMatrix::from_columns(&found) })
}

/// What is left of a vector beside an orthonormal basis.
pub fn rest(vector: &DVector<f64>, basis: &DMatrix<f64>) -> DVector<f64> {
    let once = vector - basis * basis.tr_mul(vector);
    &once - basis * basis.tr_mul(&once)
}

/// Least-squares solution by QR with column scaling; columns that are dependent get zero.
pub fn solve(matrix: &DMatrix<f64>, right: &DVector<f64>) -> DVector<f64> {
    let lengths: Vec<f64> = matrix.column_iter().map(|c| c.norm().max(f64::MIN_POSITIVE)).collect();
    let scaled = DMatrix::from_fn(matrix.nrows(), matrix.ncols(), |i, j| matrix[(i, j)] / lengths[j]);
    let normal = scaled.tr_mul(&scaled) + DMatrix::identity(matrix.ncols(), matrix.ncols()) * 1e-11;
    let right = scaled.tr_mul(right);
    let mut x = match normal.clone().cholesky() {
        Some(factor) => factor.solve(&right),
        None => DVector::zeros(matrix.ncols()),
    };
    x.iter_mut().zip(&lengths).for_each(|(x, length)| *x /= *length);
    x
}
