//! The linearised problem at one iterate.

use std::cell::OnceCell;

use faer::{Mat, MatMut, MatRef};
use nalgebra::{DMatrix, DVector};

use super::bounds::{Bounds, Side};
use super::box_step::{Region, minimize_from_zero};
use super::damped::damped;
use crate::math::linear::{Svd, apply_transpose, factor_in_place, least_norm};
use crate::math::norm;

/// The map `v -> Q' W v`, cut to the rows that the columns of the Jacobian reach.
struct Reduction {
    /// Square roots of the robust weights (m).
    roots: Option<DVector<f64>>,
    /// QR factors of `[W J, W r]`, column by column, and their coefficients; none when there was nothing to reduce.
    factors: Vec<f64>,
    coefficients: Option<Mat<f64>>,
    /// k, the smaller of m and n.
    rows: usize,
}

impl Reduction {
    fn apply(&self, mut vector: DVector<f64>) -> DVector<f64> {
        if let Some(roots) = &self.roots {
            vector.component_mul_assign(roots);
        }
        if let Some(coefficients) = &self.coefficients {
            let m = vector.len();
            let factors = MatRef::from_column_major_slice(&self.factors, m, self.rows + 1);
            let right = MatMut::from_column_major_slice_mut(vector.as_mut_slice(), m, 1);
            apply_transpose(factors, coefficients.as_ref(), right);
        }
        // The last reflection belongs to the residual and leaves these rows alone.
        vector.rows(0, self.rows).into_owned()
    }
}

/// Weighted Jacobian and residual, reduced to triangular form but not yet scaled.
pub(super) struct Reduced {
    a: DMatrix<f64>,
    b: DVector<f64>,
    /// Norm of the whole weighted residual.
    pub residual_norm: f64,
    reduction: Reduction,
}

impl Reduced {
    /// Reduces `[W J, W r]` from the squared weights `W^2`; `None` if anything overflows. `memory` is used and emptied.
    ///
    /// QR of the Jacobian bordered by the residual leaves `Q' r` in the last column, so Q is never formed. Normal equations
    /// would be several times faster but lose half of the digits, which ill-conditioned problems (and a robot whose
    /// parameters are nearly confounded) do not have to spare.
    pub fn new(
        jacobian: &DMatrix<f64>,
        residual: &DVector<f64>,
        weights: Option<&DVector<f64>>,
        mut memory: Vec<f64>,
    ) -> Option<Self> {
        let (m, n) = jacobian.shape();
        memory.clear();
        memory.extend_from_slice(jacobian.as_slice());
        memory.extend_from_slice(residual.as_slice());
        let roots = weights.map(|weights| weights.map(f64::sqrt));
        if let Some(roots) = &roots {
            for column in memory.chunks_exact_mut(m.max(1)) {
                for (entry, root) in column.iter_mut().zip(roots) {
                    *entry *= root;
                }
            }
        }
        let residual_norm = norm(&memory[m * n..]);
        let tall = m > n;
        let coefficients = tall.then(|| factor_in_place(MatMut::from_column_major_slice_mut(&mut memory, m, n + 1)));
        let rows = m.min(n);
        let entry = |i: usize, j: usize| if tall && i > j { 0.0 } else { memory[j * m + i] };
        let a = DMatrix::from_fn(rows, n, entry);
        let b = DVector::from_fn(rows, |i, _| entry(i, n));
        let finite = a.norm().is_finite() && b.norm().is_finite() && residual_norm.is_finite();
        let reduction = Reduction { roots, factors: memory, coefficients, rows };
        finite.then_some(Self { a, b, residual_norm, reduction })
    }

    /// Norm of each column of the weighted Jacobian (n); QR preserves it.
    pub fn norms(&self) -> DVector<f64> {
        DVector::from_iterator(self.a.ncols(), self.a.column_iter().map(|column| column.norm()))
    }

    /// The model at `x` in the variables `z = D p`, for `D` of diagonal `scale`; `rounding` as [`super::Problem::rounding`].
    pub fn scaled(self, scale: &[f64], x: &[f64], bounds: &Bounds, rounding: f64) -> Linear {
        let Self { mut a, b, residual_norm, reduction } = self;
        for (mut column, d) in a.column_iter_mut().zip(scale) {
            column /= *d;
        }
        let gradient = a.tr_mul(&b);
        let blocked = bounds.blocked(x, &gradient);
        let mut free = a.clone();
        for (j, blocked) in blocked.iter().enumerate() {
            if blocked.is_some() {
                free.column_mut(j).fill(0.0);
            }
        }
        let gauss_newton = least_norm(free.clone(), &b);
        let noise = a.column_iter().zip(scale).zip(x).map(|((column, d), x)| column.norm() * (d * x).abs());
        Linear {
            noise: (f64::EPSILON * noise.fold(0.0, f64::max)).max(rounding),
            best_reduction: 0.5 * (&free * &gauss_newton).norm_squared(),
            spectrum: OnceCell::new(),
            a,
            b,
            free,
            blocked,
            gauss_newton,
            gradient,
            residual_norm,
            reduction,
        }
    }
}

/// `|a z + b|` as a function of the scaled step `z = D p`, reduced to at most n rows.
pub(super) struct Linear {
    /// Reduced, weighted Jacobian in scaled variables (k x n).
    a: DMatrix<f64>,
    /// Reduced, weighted residual (k): the part of it that the columns reach.
    b: DVector<f64>,
    /// `a` with zero columns for the parameters that are held by a bound.
    free: DMatrix<f64>,
    /// The bound each parameter is held by (n).
    blocked: Vec<Option<Side>>,
    /// The step of least norm that minimises `|free z + b|` without limits.
    gauss_newton: DVector<f64>,
    /// Of `free`; made when a step has to be damped.
    spectrum: OnceCell<Option<Svd>>,
    reduction: Reduction,
    /// `a' b` (n): gradient of the cost in scaled variables.
    pub gradient: DVector<f64>,
    /// Norm of the whole weighted residual.
    pub residual_norm: f64,
    /// What the Gauss-Newton step promises: no step that leaves the held parameters alone can promise more.
    pub best_reduction: f64,
    /// Rounding error to be expected in the residual: it is a difference of measurements and a model made of terms as
    /// large as `J_j x_j`, or as the problem says.
    noise: f64,
}

/// A step and what the linear model promises of it.
pub(super) struct Step {
    /// Scaled step (n).
    pub z: DVector<f64>,
    /// Its norm.
    pub length: f64,
    /// Reduction of the cost the model promises.
    pub reduction: f64,
    /// Derivative of the cost along the step, negative.
    pub slope: f64,
    /// Whether the radius cut it short.
    pub limited: bool,
}

impl Linear {
    /// Largest cosine between the residual and a column that may still move: zero where the first-order conditions hold,
    /// whatever the units (Moré 1978, section 8).
    pub fn cosine(&self) -> f64 {
        let columns = self.a.column_iter().zip(self.gradient.iter()).zip(&self.blocked);
        let cosines = columns.map(|((column, gradient), blocked)| {
            let size = column.norm() * self.residual_norm;
            if blocked.is_some() || size == 0.0 { 0.0 } else { gradient.abs() / size }
        });
        cosines.fold(0.0, f64::max)
    }

    /// A change of the cost below this is lost in rounding.
    pub fn visible(&self) -> f64 {
        self.noise * (self.residual_norm + self.noise)
    }

    /// The best step within the region, which holds 0, and the radius.
    pub fn step(&self, region: &Region, radius: f64) -> Step {
        let (z, limited) = self.solve(&self.gauss_newton, &self.b, region, radius);
        let slope = self.gradient.dot(&z);
        let reduction = -slope - 0.5 * (&self.a * &z).norm_squared();
        Step { length: z.norm(), reduction, slope, limited, z }
    }

    /// The step again, now that its end is known to be bent by `curvature = r(x + p) - r(x) - J p` (m).
    ///
    /// Narrow valleys bend, and a straight step in one soon leaves it. The bend just measured is one half of the second
    /// derivative along the step, so this step is right to second order: it plays the part of the "geodesic acceleration"
    /// of Transtrum and Sethna (2012) without a second derivative.
    pub fn bent_step(&self, curvature: DVector<f64>, region: &Region, radius: f64) -> DVector<f64> {
        let b = &self.b + self.reduction.apply(curvature);
        self.solve(&least_norm(self.free.clone(), &b), &b, region, radius).0
    }

    /// Minimises `|a z + b|` over the region, damped if need be; `full` is the minimiser over the free variables.
    fn solve(&self, full: &DVector<f64>, b: &DVector<f64>, region: &Region, radius: f64) -> (DVector<f64>, bool) {
        if full.norm() <= radius {
            // A convex function that is least at a point of the box is least in the box there: no programme to solve.
            if self.is_optimal(full, b, region) {
                return (full.clone(), false);
            }
            let z = minimize_from_zero(&self.a, b, region);
            let limited = z.amax() >= radius;
            return (z, limited);
        }
        // The box alone would let a variable that hardly matters run to its corner for a negligible gain, and once there
        // an exponential never comes back. Levenberg's damping, as strong as the radius asks for, keeps those still.
        let spectrum = self.spectrum.get_or_init(|| Svd::new(&self.free));
        let damping = match spectrum {
            Some(spectrum) => {
                let (damping, z) = damped(spectrum, b, radius);
                if self.is_optimal(&z, b, region) {
                    return (z, true);
                }
                damping
            }
            // Enough for any matrix: |z| <= |a' b| / damping.
            None => self.a.tr_mul(b).norm() / radius,
        };
        let (k, n) = self.a.shape();
        let mut a = self.a.clone().resize(k + n, n, 0.0);
        a.view_mut((k, 0), (n, n)).fill_diagonal(damping.sqrt());
        (minimize_from_zero(&a, &b.clone().resize_vertically(k + n, 0.0), region), true)
    }

    /// Whether `z`, best as long as the held parameters stay, is in the region and those do want to stay.
    fn is_optimal(&self, z: &DVector<f64>, b: &DVector<f64>, region: &Region) -> bool {
        let residual = &self.a * z + b;
        region.contains(z)
            && self.blocked.iter().enumerate().all(|(j, side)| match side {
                Some(_) if region.is_fixed(j) => true,
                Some(Side::Lower) => self.a.column(j).dot(&residual) >= 0.0,
                Some(Side::Upper) => self.a.column(j).dot(&residual) <= 0.0,
                None => true,
            })
    }

    /// The memory, for the next reduction.
    pub fn recycle(self) -> Vec<f64> {
        self.reduction.factors
    }
}
