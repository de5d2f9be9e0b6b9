//! The damped step of Levenberg and Marquardt, as long as the trust region is wide.
//!
//! Source: Moré 1978, section 5; Hebden 1973.

use nalgebra::DVector;

use crate::math::linear::Svd;

/// The damping `mu` and the `z` minimising `|a z + b|^2 + mu |z|^2` whose norm is just within `radius`; the undamped
/// minimiser must be longer than that.
///
/// With the decomposition of `a` at hand `|z(mu)|` costs n operations; Newton's method on `1 / |z(mu)|`, which is nearly
/// straight, is kept inside a bracket.
pub(super) fn damped(a: &Svd, b: &DVector<f64>, radius: f64) -> (f64, DVector<f64>) {
    let sum = |i: usize| a.left.column(i).iter().zip(b).map(|(u, b)| u * b).sum::<f64>();
    let along: Vec<f64> = (0..a.values.len()).map(|i| a.values[i] * sum(i)).collect();
    let norm = |mu: f64| -> (f64, f64) {
        let terms = along.iter().zip(&a.values).map(|(c, s)| {
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
    let mut z = DVector::zeros(a.right.nrows());
    for (i, (c, s)) in along.iter().zip(&a.values).enumerate() {
        let factor = -c / (s * s + mu);
        z.axpy(factor, &a.right.column(i), 1.0);
    }
    (mu, z)
}
