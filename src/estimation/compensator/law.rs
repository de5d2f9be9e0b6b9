//! The law of the spring and the fit of its stiffness to compliances of the joint: KR-270 paper, eq. (10) to (14). SI, angles
//! in rad.

use nalgebra::{DMatrix, DVector};

use super::value::{CompensatorError, DEGENERATE, Value, refuse};
use crate::math::linear::{Svd, cofactor};
use crate::math::quantiles::{f_tail, normal95, t95};

/// L, ax and ay, m: the mounting as the law of the spring takes it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Triangle {
    /// L
    pub lever: f64,
    /// ax
    pub ax: f64,
    /// ay
    pub ay: f64,
}

impl Triangle {
    /// a, m.
    pub fn base(&self) -> f64 {
        self.ax.hypot(self.ay)
    }

    /// phi, rad.
    pub fn phase(&self) -> f64 {
        -self.ax.atan2(self.ay)
    }

    /// Length of the spring at joint angle `q`, m.
    ///
    /// ```
    /// use elastogeo::estimation::compensator::Triangle;
    ///
    /// // Mounting of the KR-270's compensator (Table V of its paper).
    /// let triangle = Triangle { lever: 0.18472, ax: 0.68593, ay: 0.1233 };
    /// assert!((triangle.length(0.0) - 0.7522).abs() < 1e-3); // m
    /// ```
    pub fn length(&self, q: f64) -> f64 {
        let (a, l) = (self.base(), self.lever);
        (a * a + l * l + 2.0 * a * l * (self.phase() + q).cos()).max(0.0).sqrt()
    }

    /// Row of eq. (14): K2 = row . (K0, Kc, s0 Kc).
    pub fn row(&self, q: f64) -> [f64; 3] {
        let (al, s, alpha) = (self.base() * self.lever, self.length(q), self.phase() + q);
        [1.0, -al * alpha.cos(), al / s * (al / (s * s) * alpha.sin().powi(2) + alpha.cos())]
    }
}

/// Compliance of the joint found at one of its angles.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointCompliance {
    /// rad
    pub angle: f64,
    /// rad/(N.m)
    pub compliance: f64,
    /// Half width of its 95 % interval, if known.
    pub ci95: Option<f64>,
}

/// What the spring is.
#[derive(Debug, Clone, PartialEq)]
pub struct Elasticity {
    /// Compliance of the joint without the spring, rad/(N.m).
    pub joint: Value,
    /// Compliance of the spring, m/N.
    pub spring: Value,
    /// Its free length, m.
    pub free_length: Value,
    /// Root mean square of the compliances less the fitted ones, rad/(N.m).
    pub rms: f64,
}

impl Elasticity {
    /// Compliance of the joint at an angle, rad/(N.m).
    pub fn compliance(&self, at: &Triangle, q: f64) -> f64 {
        let row = at.row(q);
        let rate = 1.0 / self.spring.value;
        1.0 / (row[0] / self.joint.value + rate * (row[1] + row[2] * self.free_length.value))
    }
}

/// How far compliances are from the law through them, beyond what their own uncertainty lets expect.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Misfit {
    /// Mean square over that of the readings.
    pub ratio: f64,
    /// Degrees of freedom of both.
    pub degrees: [f64; 2],
    /// Probability of such a ratio where the law holds.
    pub p: f64,
}

/// k2_0, kc and s0 from compliances of the joint at several of its angles: eq. (13), (14), linear in the stiffnesses.
/// Where all compliances have intervals, they are weighted by them.
///
/// # Errors
/// Fewer than three compliances, or some that no spring explains.
pub fn elasticity(at: &Triangle, found: &[JointCompliance]) -> Result<Elasticity, CompensatorError> {
    usable(at, found)?;
    let stated = found.iter().all(|k| k.ci95.is_some());
    // Of a stiffness 1/k.
    let sigma = |k: &JointCompliance| match k.ci95 {
        Some(ci) if stated => ci / normal95() / (k.compliance * k.compliance),
        _ => 1.0,
    };
    let weights = DMatrix::from_diagonal(&DVector::from_iterator(found.len(), found.iter().map(|k| 1.0 / sigma(k))));
    let degrees = found.len() as f64 - 3.0;
    // Half width over the root of the cofactor: by the residuals, else by the stated intervals.
    let (elasticity, _) = weighted(at, found, &weights, |residual| match (degrees > 0.0, stated) {
        (true, _) => Some(residual / degrees.sqrt() * t95(degrees)),
        (false, true) => Some(normal95()),
        (false, false) => None,
    })?;
    Ok(elasticity)
}

/// The same from compliances with their covariance (rad/(N.m))^2 and the degrees of freedom with which it was estimated: intervals
/// are by it. The misfit is none of three compliances, through which every law goes.
///
/// # Errors
/// As [`elasticity`].
pub fn elasticity_within(
    at: &Triangle,
    found: &[JointCompliance],
    covariance: &DMatrix<f64>,
    freedom: f64,
) -> Result<(Elasticity, Option<Misfit>), CompensatorError> {
    usable(at, found)?;
    let squares: Vec<f64> = found.iter().map(|k| k.compliance * k.compliance).collect();
    let of_stiffness = covariance.map_with_location(|i, j, c| c / (squares[i] * squares[j]));
    let size = of_stiffness.diagonal().max();
    let Some(weights) = (of_stiffness / size).cholesky().and_then(|factor| factor.l().try_inverse()) else {
        return refuse("the readings do not separate the compliances at the angles");
    };
    let (elasticity, residual) = weighted(at, found, &(weights / size.sqrt()), |_| Some(t95(freedom)))?;
    let degrees = found.len() as f64 - 3.0;
    let ratio = residual * residual / degrees;
    let misfit = Misfit { ratio, degrees: [degrees, freedom], p: f_tail(ratio, degrees, freedom) };
    Ok((elasticity, (degrees > 0.0).then_some(misfit)))
}

fn usable(at: &Triangle, found: &[JointCompliance]) -> Result<(), CompensatorError> {
    if found.len() < 3 {
        return refuse(format!(
            "{} compliances do not determine three numbers: three angles or more are needed",
            found.len()
        ));
    }
    if found.iter().any(|k| k.compliance.is_nan() || k.compliance <= 0.0 || k.ci95.is_some_and(|ci| ci <= 0.0)) {
        return refuse("compliances and their intervals must be above 0");
    }
    if found.iter().any(|k| at.length(k.angle).is_nan() || at.length(k.angle) < 1e-6) {
        return refuse("the spring has no length at one of the angles: check L, ax and ay");
    }
    Ok(())
}

/// The fit of eq. (13), rows multiplied by `weights`, and the length of its weighted residual; `size` is the half width over the root
/// of the cofactor.
fn weighted(
    at: &Triangle,
    found: &[JointCompliance],
    weights: &DMatrix<f64>,
    size: impl Fn(f64) -> Option<f64>,
) -> Result<(Elasticity, f64), CompensatorError> {
    let matrix = weights * DMatrix::from_fn(found.len(), 3, |i, j| at.row(found[i].angle)[j]);
    let right = weights * DVector::from_iterator(found.len(), found.iter().map(|k| 1.0 / k.compliance));
    let norms: Vec<f64> = matrix.column_iter().map(|c| c.norm().max(f64::MIN_POSITIVE)).collect();
    let Some(svd) = Svd::new(&DMatrix::from_fn(found.len(), 3, |i, j| matrix[(i, j)] / norms[j])) else {
        return refuse("the stiffnesses cannot be separated");
    };
    if svd.values[2] < DEGENERATE * svd.values[0] {
        return refuse(
            "the angles do not separate the joint from the spring: three different angles or more are needed",
        );
    }
    let along = svd.left.tr_mul(&right).component_div(&DVector::from_column_slice(&svd.values));
    let scaled = &svd.right * along;
    let [joint, rate, preload] = [0, 1, 2].map(|k| scaled[k] / norms[k]);
    if joint <= 0.0 || rate <= 0.0 {
        return refuse(format!(
            "no spring explains these compliances: the joint alone would have {joint:.3e} N.m/rad and the spring {rate:.3e} N/m"
        ));
    }
    let residual = &right - &matrix * DVector::from_column_slice(&[joint, rate, preload]);
    let size = size(residual.norm());
    let cofactor = cofactor(&matrix);
    // Widths of 1/K0, 1/Kc and (s0 Kc)/Kc to first order.
    let width = |gradient: [f64; 3]| {
        let g = DVector::from_column_slice(&gradient);
        size.map(|size| size * (&cofactor * &g).dot(&g).max(0.0).sqrt())
    };
    let mut result = Elasticity {
        joint: Value { value: 1.0 / joint, ci95: width([1.0 / (joint * joint), 0.0, 0.0]) },
        spring: Value { value: 1.0 / rate, ci95: width([0.0, 1.0 / (rate * rate), 0.0]) },
        free_length: Value { value: preload / rate, ci95: width([0.0, -preload / (rate * rate), 1.0 / rate]) },
        rms: 0.0,
    };
    let squares = found.iter().map(|k| (k.compliance - result.compliance(at, k.angle)).powi(2)).sum::<f64>();
    result.rms = (squares / found.len() as f64).sqrt();
    Ok((result, residual.norm()))
}
