//! Linear least squares over a box.
//!
//! An interior-point method (clarabel) finds which limits are active in a number of iterations that hardly depends on how
//! many there are; an active-set method started there makes the answer exact. The first alone stops at a relative
//! accuracy of about 1e-6 in the variables and works on `a' a`; the second alone may visit very many active sets.

use clarabel::algebra::CscMatrix;
use clarabel::solver::{
    DefaultSettingsBuilder, DefaultSolver, IPSolver, SolverStatus,
    SupportedConeT::{self, NonnegativeConeT},
};
use nalgebra::{DMatrix, DVector};

use super::bounds::{Bounds, Side};
use super::solution::UsageError;
use crate::math::linear::least_norm;

/// Curvature added to the programme, whose coefficients are of size 1. Among equally good points an interior-point method
/// goes to the middle of the box, far from where we are; with this it stays near 0. The active-set method works without.
const RIDGE: f64 = 1e-9;

/// Width of an interval relative to the box below which it has no interior: the solver's own accuracy.
const NARROW: f64 = 1e-9;

/// A box; limits may be infinite.
pub(super) struct Region {
    pub lower: DVector<f64>,
    pub upper: DVector<f64>,
}

impl Region {
    pub fn contains(&self, z: &DVector<f64>) -> bool {
        z.iter().zip(&self.lower).zip(&self.upper).all(|((z, lower), upper)| lower <= z && z <= upper)
    }

    /// Whether the limits of a variable leave one value.
    pub fn is_fixed(&self, j: usize) -> bool {
        self.lower[j] >= self.upper[j]
    }

    fn clamp(&self, z: &mut DVector<f64>) {
        for ((z, lower), upper) in z.iter_mut().zip(&self.lower).zip(&self.upper) {
            *z = z.max(*lower).min(*upper);
        }
    }

    fn limit(&self, j: usize, side: Side) -> f64 {
        match side {
            Side::Lower => self.lower[j],
            Side::Upper => self.upper[j],
        }
    }
}

/// The `z` (n) within `bounds` that minimises `|a z + b|`, for `a` (k x n) of any shape and rank and `b` (k).
///
/// Where several `z` are equally good, one of them.
///
/// # Errors
/// [`UsageError`] when lengths disagree, the bounds leave no value, or an entry of `a` or `b` is not finite.
pub fn minimize_in_box(a: &DMatrix<f64>, b: &DVector<f64>, bounds: &Bounds) -> Result<DVector<f64>, UsageError> {
    let (k, n) = a.shape();
    bounds.check()?;
    if bounds.lower.len() != n {
        return Err(UsageError::Length { what: "bounds", expected: n, found: bounds.lower.len() });
    }
    if b.len() != k {
        return Err(UsageError::Shape { what: "right-hand side", expected: (k, 1), found: (b.len(), 1) });
    }
    if let Some(&value) = a.iter().chain(b.iter()).find(|v| !v.is_finite()) {
        return Err(UsageError::Setting { name: "an entry of the matrix or right-hand side", value, rule: "finite" });
    }
    // Unit columns and an origin inside the box, as the trust region provides.
    let mut origin = vec![0.0; n];
    bounds.clamp(&mut origin);
    let origin = DVector::from_vec(origin);
    let scale = DVector::from_iterator(n, a.column_iter().map(|c| if c.norm() > 0.0 { c.norm() } else { 1.0 }));
    let scaled = DMatrix::from_fn(k, n, |i, j| a[(i, j)] / scale[j]);
    let shifted = b + a * &origin;
    let region = Region {
        lower: DVector::from_fn(n, |j, _| (bounds.lower[j] - origin[j]) * scale[j]),
        upper: DVector::from_fn(n, |j, _| (bounds.upper[j] - origin[j]) * scale[j]),
    };
    let free = least_norm(scaled.clone(), &shifted);
    let z = if region.contains(&free) { free } else { minimize_from_zero(&scaled, &shifted, &region) };
    let mut z: Vec<f64> = z.component_div(&scale).iter().zip(&origin).map(|(z, origin)| origin + z).collect();
    bounds.clamp(&mut z);
    Ok(DVector::from_vec(z))
}

/// The minimiser of `|a z + b|` over a region that holds 0; never worse than 0.
pub(super) fn minimize_from_zero(a: &DMatrix<f64>, b: &DVector<f64>, region: &Region) -> DVector<f64> {
    let n = a.ncols();
    let (mut z, mut active) = interior_point(a, b, region).unwrap_or_else(|| (DVector::zeros(n), vec![None; n]));
    // The interior-point answer carries an error; 0 is known to be feasible. Begin where the cost is lower.
    if (a * &z + b).norm_squared() > b.norm_squared() {
        z.fill(0.0);
        active.fill(None);
    }
    active_set(a, b, region, z, active)
}

/// A bounded quadratic programme as clarabel takes it: the box has size 1 and coefficients are of size 1, because the
/// solver's tolerances are absolute as much as relative.
struct Programme {
    /// Greatest limit of the box.
    size: f64,
    /// Variables that may move; others stay at 0.
    movable: Vec<usize>,
    quadratic: CscMatrix<f64>,
    linear: Vec<f64>,
    constraint: CscMatrix<f64>,
    right: Vec<f64>,
    /// Variable and side of each row of the constraint.
    limits: Vec<(usize, Side)>,
}

impl Programme {
    /// `None` where there is no variable to move or no limit to meet.
    fn new(a: &DMatrix<f64>, b: &DVector<f64>, region: &Region) -> Option<Self> {
        let n = a.ncols();
        let finite = region.lower.iter().chain(region.upper.iter()).filter(|limit| limit.is_finite());
        let size = finite.fold(0.0_f64, |size, limit| size.max(limit.abs()));
        if !(size > 0.0 && size.is_finite()) {
            return None;
        }
        let hessian = a.tr_mul(a) * size;
        let gradient = a.tr_mul(b);
        let unit = hessian.amax().max(gradient.amax());
        if !(unit > 0.0 && unit.is_finite()) {
            return None;
        }
        // An interval without interior has no inside for an interior-point method, and a variable without influence no
        // reason to move.
        let may_move = |j: usize| region.upper[j] - region.lower[j] > NARROW * size && hessian[(j, j)] > 0.0;
        let movable: Vec<usize> = (0..n).filter(|&j| may_move(j)).collect();
        let mut quadratic = (vec![0], Vec::new(), Vec::new());
        let mut limits: Vec<(usize, Side)> = Vec::new();
        let mut constraint = (vec![0], Vec::new(), Vec::new());
        let mut right = Vec::new();
        for (column, &j) in movable.iter().enumerate() {
            for (row, &i) in movable[..=column].iter().enumerate() {
                quadratic.1.push(row);
                let ridge = if i == j { RIDGE } else { 0.0 };
                quadratic.2.push(hessian[(i, j)] / unit + ridge);
            }
            quadratic.0.push(quadratic.1.len());
            for (side, sign) in [(Side::Lower, -1.0), (Side::Upper, 1.0)] {
                let limit = region.limit(j, side);
                if limit.is_finite() {
                    constraint.1.push(limits.len());
                    constraint.2.push(sign);
                    right.push(sign * limit / size);
                    limits.push((j, side));
                }
            }
            constraint.0.push(constraint.1.len());
        }
        let columns = movable.len();
        (columns > 0 && !right.is_empty()).then(|| Self {
            size,
            linear: movable.iter().map(|&j| gradient[j] / unit).collect(),
            movable,
            quadratic: CscMatrix::new(columns, columns, quadratic.0, quadratic.1, quadratic.2),
            constraint: CscMatrix::new(right.len(), columns, constraint.0, constraint.1, constraint.2),
            right,
            limits,
        })
    }
}

/// The active set clarabel finds, and the point with the active variables put on their limits.
fn interior_point(a: &DMatrix<f64>, b: &DVector<f64>, region: &Region) -> Option<(DVector<f64>, Vec<Option<Side>>)> {
    let programme = Programme::new(a, b, region)?;
    let Programme { quadratic, linear, constraint, right, .. } = &programme;
    let cones: [SupportedConeT<f64>; 1] = [NonnegativeConeT(right.len())];
    let settings = DefaultSettingsBuilder::default().verbose(false).max_threads(1).max_iter(50).build().ok()?;
    let mut solver = DefaultSolver::new(quadratic, linear, constraint, right, &cones, settings).ok()?;
    solver.solve();
    let answer = &solver.solution;
    let usable = matches!(answer.status, SolverStatus::Solved | SolverStatus::AlmostSolved);
    if !usable || answer.x.iter().any(|v| !v.is_finite()) {
        return None;
    }
    let n = a.ncols();
    let mut z = DVector::zeros(n);
    for (&j, v) in programme.movable.iter().zip(&answer.x) {
        z[j] = v * programme.size;
    }
    region.clamp(&mut z);
    let mut active = vec![None; n];
    for (&(j, side), (multiplier, slack)) in programme.limits.iter().zip(answer.z.iter().zip(&answer.s)) {
        // Strict complementarity: on an active limit the multiplier is the larger of the two.
        if multiplier > slack {
            z[j] = region.limit(j, side);
            active[j] = Some(side);
        }
    }
    Some((z, active))
}

/// Minimises `|a z + b|` over the region from the feasible `z` with the variables of `active` on their limits.
///
/// Every move lowers the cost, so no active set comes twice but for rounding; the number of moves is capped all the same,
/// and the point reached is feasible at any time.
fn active_set(
    a: &DMatrix<f64>,
    b: &DVector<f64>,
    region: &Region,
    mut z: DVector<f64>,
    mut active: Vec<Option<Side>>,
) -> DVector<f64> {
    let n = a.ncols();
    // Variables that were released and pushed straight back; tried again once something has moved.
    let mut barred = vec![false; n];
    for _ in 0..10 * n + 50 {
        let residual = a * &z + b;
        let free: Vec<usize> = (0..n).filter(|&j| active[j].is_none()).collect();
        // The move, not the point, is solved for: it is small near the end and so are its rounding errors.
        let shift = least_norm(a.select_columns(&free), &residual);
        let reach = |(&j, d): (&usize, &f64)| {
            let limit = if *d < 0.0 { region.lower[j] } else { region.upper[j] };
            if *d == 0.0 { f64::INFINITY } else { ((limit - z[j]) / d).max(0.0) }
        };
        let reaches: Vec<f64> = free.iter().zip(&shift).map(reach).collect();
        let fraction = reaches.iter().fold(1.0_f64, |least, &t| least.min(t));
        for ((&j, d), &t) in free.iter().zip(&shift).zip(&reaches) {
            if fraction < 1.0 && t <= fraction {
                let side = if *d < 0.0 { Side::Lower } else { Side::Upper };
                active[j] = Some(side);
                z[j] = region.limit(j, side);
                barred[j] = fraction == 0.0;
            } else {
                z[j] += fraction * d;
            }
        }
        if fraction > 0.0 {
            barred.fill(false);
        }
        region.clamp(&mut z);
        if fraction < 1.0 {
            continue;
        }
        // Least on its face. Release the limit that holds back the steepest descent, if any does.
        let residual = a * &z + b;
        let size = residual.norm();
        let pull = |j: usize| {
            let column = a.column(j);
            let gradient = column.dot(&residual) / (column.norm() * size);
            match active[j] {
                Some(Side::Lower) => -gradient,
                Some(Side::Upper) => gradient,
                None => 0.0,
            }
        };
        let candidates = (0..n).filter(|&j| !barred[j] && !region.is_fixed(j));
        let steepest = candidates.map(|j| (j, pull(j))).filter(|&(_, pull)| pull > 1e-13);
        match steepest.max_by(|(_, p), (_, q)| p.total_cmp(q)) {
            Some((j, _)) => active[j] = None,
            None => break,
        }
    }
    z
}
