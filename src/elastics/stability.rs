//! Greatest real part among the eigenvalues of a linear map that is only known by its products, by Arnoldi's method.
//!
//! At an equilibrium a small strain s of the elements moves the loads, which answer by a strain A s = C Kg s, with C the
//! compliance of the structure and -Kg the stiffness that the loads take away. The tangent stiffness C^-1 - Kg is
//! positive definite while all eigenvalues of A are below 1, and the inverse of the greatest is the load factor at which
//! it ceases to be (Bathe 1996, sec. 6.8.2). The extreme ones stand apart and are found in few products.
//!
//! Arnoldi's method is written out, and only the small Hessenberg matrix goes to a library: the matrix-free solver of faer
//! orders eigenvalues by magnitude, where the greatest real part is sought (a negative one of any size is no danger), and
//! takes products that cannot fail, where a load here may be past the end of what can be placed.

use nalgebra::{DMatrix, DVector};

/// Products at most.
const MOST: usize = 30;
/// What is left of a product, relative to its size, below which it adds no direction.
const NONE: f64 = 1e-9;

/// Greatest real part of the eigenvalues of `product`, a map of vectors of `size` entries; 0 of none.
///
/// # Errors
/// Those of `product`.
pub(super) fn greatest<E>(size: usize, mut product: impl FnMut(&[f64], &mut [f64]) -> Result<(), E>) -> Result<f64, E> {
    if size == 0 {
        return Ok(0.0);
    }
    let steps = size.min(MOST);
    // Some of every direction, the same at each run.
    let start = DVector::from_fn(size, |i, _| (1.0 + i as f64 * 0.754_877_666).fract() - 0.5 + 1e-3);
    let mut basis = vec![start.normalize()];
    let mut small = DMatrix::<f64>::zeros(steps, steps);
    let mut image = DVector::zeros(size);
    let mut found = 0;
    for k in 0..steps {
        product(basis[k].as_slice(), image.as_mut_slice())?;
        let before = image.norm();
        for _ in 0..2 {
            for (i, known) in basis.iter().enumerate() {
                let part = known.dot(&image);
                small[(i, k)] += part;
                image.axpy(-part, known, 1.0);
            }
        }
        found = k + 1;
        let left = image.norm();
        if k + 1 == steps || left <= NONE * before.max(NONE) {
            break;
        }
        small[(k + 1, k)] = left;
        basis.push(&image / left);
    }
    let small = small.view((0, 0), (found, found)).into_owned();
    if small.iter().any(|v| !v.is_finite()) {
        return Ok(f64::INFINITY);
    }
    Ok(small.complex_eigenvalues().iter().map(|value| value.re).fold(0.0, f64::max))
}
