//! Natural cubic splines by their values at the knots.
//!
//! Source: de Boor, *A Practical Guide to Splines*, ch. IV; Press et al., *Numerical Recipes*, sec. 3.3.

use nalgebra::DMatrix;

/// The natural cubic spline through increasing knots; beyond them it keeps the value of the last one.
#[derive(Debug, Clone)]
pub struct NaturalSpline {
    knots: Vec<f64>,
    /// Second derivatives at the knots by the values there, n x n.
    curvatures: DMatrix<f64>,
}

impl NaturalSpline {
    /// Through `knots`, increasing; `None` of fewer than two or of others.
    pub fn new(knots: &[f64]) -> Option<Self> {
        let n = knots.len();
        if n < 2 || !knots.windows(2).all(|pair| pair[1] > pair[0]) {
            return None;
        }
        let (mut left, mut right) = (DMatrix::identity(n, n), DMatrix::zeros(n, n));
        for i in 1..n - 1 {
            let (before, after) = (knots[i] - knots[i - 1], knots[i + 1] - knots[i]);
            left[(i, i - 1)] = before / 6.0;
            left[(i, i)] = (before + after) / 3.0;
            left[(i, i + 1)] = after / 6.0;
            right[(i, i - 1)] = 1.0 / before;
            right[(i, i)] = -1.0 / before - 1.0 / after;
            right[(i, i + 1)] = 1.0 / after;
        }
        // Diagonally dominant.
        Some(Self { knots: knots.to_vec(), curvatures: left.lu().solve(&right)? })
    }

    /// Weight of the value at each knot in the value at `x`, by index of the knot.
    pub fn weights(&self, x: f64, mut put: impl FnMut(usize, f64)) {
        let n = self.knots.len();
        let x = x.clamp(self.knots[0], self.knots[n - 1]);
        let i = self.knots.partition_point(|&knot| knot <= x).clamp(1, n - 1) - 1;
        let width = self.knots[i + 1] - self.knots[i];
        let (a, b) = ((self.knots[i + 1] - x) / width, (x - self.knots[i]) / width);
        let [low, high] = [a, b].map(|share| (share.powi(3) - share) * width * width / 6.0);
        for j in 0..n {
            let own = if j == i {
                a
            } else if j == i + 1 {
                b
            } else {
                0.0
            };
            put(j, own + low * self.curvatures[(i, j)] + high * self.curvatures[(i + 1, j)]);
        }
    }
}
