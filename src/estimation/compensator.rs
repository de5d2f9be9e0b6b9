//! Gravity compensator of a heavy robot: where its spring is hung, and what it adds to the joint it unloads (joint 2 of the paper).
//!
//! Source: KR-270 paper (Wu, Klimchik and co-authors), sec. III.C-E. The spring acts between P0 on link 1 and P1 on
//! link 2, which turns about P2, the axis of joint 2. With L = |P1 P2|, a = |P0 P2| its length obeys
//! s^2 = a^2 + L^2 + 2 a L cos(alpha), alpha = phi + q, and it adds (eq. (10), (11))
//!
//! ```text
//! K2 = K0 + Kc a L eta,  eta = (s0 / s) (a L / s^2 sin(alpha)^2 + cos(alpha)) - cos(alpha)
//! ```
//!
//! to the stiffness of the joint. Angles are counted as the joint's own; the plane of motion is read from the measured
//! circle: `along` is the direction from P2 to P1 at q = 0, `across` that at q = 90 deg. The paper's ax is counted
//! against `across`, its ay against `along`, so that phi = -atan2(ax, ay): its -79.81 deg, and no other reading of its
//! drawing, returns its Table IX.

use nalgebra::{DMatrix, DVector, Matrix3, Rotation3, Vector3};

use super::covariance::Covariance;
use crate::least_squares::{self, Bounds, EvaluationError, Problem, UsageError};
use crate::math::left_jacobian;
use crate::math::linear::{Svd, cofactor};
use crate::math::quantiles::{normal95, t95};

/// Ratio of the least to the greatest singular value (or of their squares) below which points or angles leave a direction
/// open: rounding of measured coordinates is far above it.
const DEGENERATE: f64 = 1e-9;

/// A value with the half width of its 95 % interval, if the data leave anything to judge it by.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Value {
    /// SI.
    pub value: f64,
    /// SI.
    pub ci95: Option<f64>,
}

/// Why a compensator cannot be found.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{0}")]
pub struct CompensatorError(pub String);

impl From<UsageError> for CompensatorError {
    fn from(error: UsageError) -> Self {
        Self(error.to_string())
    }
}

fn refuse<T>(message: impl Into<String>) -> Result<T, CompensatorError> {
    Err(CompensatorError(message.into()))
}

/// The circle of P1 about P2.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Circle {
    /// P2, m.
    pub centre: Vector3<f64>,
    /// Columns: `along`, `across`, and the joint's axis.
    pub axes: Matrix3<f64>,
    /// L, m.
    pub radius: f64,
}

/// Where the spring is hung.
#[derive(Debug, Clone, PartialEq)]
pub struct Mounting {
    /// Circle of P1.
    pub circle: Circle,
    /// L, m.
    pub lever: Value,
    /// ax and ay, m; `None` where no anchor was measured.
    pub anchor: Option<[Value; 2]>,
    /// Standard deviation of a coordinate about the fitted circles, m; `None` where there are no more coordinates than
    /// unknowns.
    pub sigma: Option<f64>,
}

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

/// L, P2 and the axis from positions of P1 (m, any axes) at joint angles (rad): eq. (6), the rotation by Procrustes'
/// problem of the positions against u = (cos q, sin q, 0). These are the least squares of the circle.
///
/// # Errors
/// Fewer than three angles, or points that do not turn.
pub fn circle(points: &[(f64, Vector3<f64>)]) -> Result<Circle, CompensatorError> {
    if points.len() < 3 {
        return refuse(format!("{} points do not make a circle: measure P1 at three angles or more", points.len()));
    }
    let n = points.len() as f64;
    let unit = |q: f64| Vector3::new(q.cos(), q.sin(), 0.0);
    let mean = points.iter().map(|(_, p)| p).sum::<Vector3<f64>>() / n;
    let mean_unit = points.iter().map(|(q, _)| unit(*q)).sum::<Vector3<f64>>() / n;
    let (mut cross, mut spread) = (Matrix3::zeros(), Matrix3::zeros());
    for (q, p) in points {
        let u = unit(*q) - mean_unit;
        cross += u * (p - mean).transpose();
        spread += u * u.transpose();
    }
    let turned = spread.symmetric_eigenvalues();
    let mut turned = [turned[0], turned[1], turned[2]];
    turned.sort_by(f64::total_cmp);
    if turned[1] < DEGENERATE * turned[2].max(f64::MIN_POSITIVE) || turned[2] < DEGENERATE {
        return refuse("the angles of P1 are all the same, or only two: turn the joint further");
    }
    let svd = cross.svd(true, true);
    let (Some(u), Some(v)) = (svd.u, svd.v_t) else { return refuse("the circle's directions cannot be separated") };
    if svd.singular_values[1] < DEGENERATE * svd.singular_values[0].max(f64::MIN_POSITIVE) {
        return refuse("the points of P1 lie on a line or in one place: they do not turn with the angles given");
    }
    let (u, v) = (u, v.transpose());
    let sign = (v * u.transpose()).determinant().signum();
    let axes = v * Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, sign)) * u.transpose();
    let (mut along, mut size) = (0.0, 0.0);
    for (q, p) in points {
        let u = unit(*q) - mean_unit;
        along += p.dot(&(axes * u));
        size += u.dot(&u);
    }
    let radius = along / size;
    Ok(Circle { centre: mean - axes * mean_unit * radius, axes, radius })
}

/// P0 from reference points of the body that turns about it, each measured at several angles (m): eq. (7), the axis
/// being the smallest singular direction of all points about their means, and the centre the least squares of
/// p . c = (|p|^2 - R^2) / 2 in the plane across it.
///
/// # Errors
/// Points that do not move, or only along a line.
pub fn anchor(arcs: &[Vec<Vector3<f64>>]) -> Result<Vector3<f64>, CompensatorError> {
    let count = arcs.iter().map(Vec::len).sum::<usize>();
    if arcs.iter().any(|arc| arc.len() < 2) || count < arcs.len() + 2 {
        return refuse(
            "the anchor needs each reference point at two angles or more, and three positions of one of them at least",
        );
    }
    let middle = arcs.iter().flatten().sum::<Vector3<f64>>() / count as f64;
    let (mut scatter, mut right) = (Matrix3::zeros(), Vector3::zeros());
    for arc in arcs {
        let mean = arc.iter().sum::<Vector3<f64>>() / arc.len() as f64 - middle;
        let mean_square = arc.iter().map(|p| (p - middle).norm_squared()).sum::<f64>() / arc.len() as f64;
        for p in arc {
            let (p, square) = (p - middle - mean, (p - middle).norm_squared() - mean_square);
            scatter += p * p.transpose();
            right += p * (0.5 * square);
        }
    }
    // Singular values of the stacked points are the roots of these, their directions the same.
    let mut directions: Vec<(f64, Vector3<f64>)> = {
        let found = scatter.symmetric_eigen();
        (0..3).map(|k| (found.eigenvalues[k], found.eigenvectors.column(k).into_owned())).collect()
    };
    directions.sort_by(|a, b| b.0.total_cmp(&a.0));
    if directions[1].0 < DEGENERATE * directions[0].0.max(f64::MIN_POSITIVE) || directions[0].0 <= 0.0 {
        return refuse("the reference points move along a line or not at all: no centre is seen from them");
    }
    let in_plane = directions[..2].iter().map(|(size, d)| d * (d.dot(&right) / size)).sum::<Vector3<f64>>();
    Ok(middle + in_plane)
}

/// Where the spring is hung: [`circle`] and [`anchor`] with 95 % intervals, by the least squares of all distances from
/// the circles, which have the joint's axis in common.
///
/// # Errors
/// As [`circle`] and [`anchor`].
pub fn mounting(points: &[(f64, Vector3<f64>)], arcs: &[Vec<Vector3<f64>>]) -> Result<Mounting, CompensatorError> {
    let circle = circle(points)?;
    let mut start = Circles { circle, anchor: [0.0; 2], rings: Vec::new() };
    if !arcs.is_empty() {
        let local = circle.axes.transpose() * (anchor(arcs)? - circle.centre);
        start.anchor = [local.x, local.y];
        start.rings = arcs.iter().map(|arc| ring(&circle, start.anchor, arc)).collect();
    }
    let problem = Distances { start, points, arcs };
    let n = problem.parameters();
    let limits = least_squares::Settings::default();
    let found = least_squares::minimize(&problem, &vec![0.0; n], &Bounds::none(n), &limits)?;
    let determined = found.residual.len() > n;
    let covariance = determined.then(|| Covariance::new(&found.residual, &found.jacobian, &found.weights, 0));
    let half_widths = covariance.as_ref().map(Covariance::ci95);
    let value = |value: f64, k: usize| Value { value, ci95: half_widths.as_ref().map(|all| all[k]) };
    let Circles { circle, anchor, .. } = problem.at(&found.x);
    Ok(Mounting {
        circle,
        lever: value(circle.radius, 6),
        anchor: (!arcs.is_empty()).then(|| [value(-anchor[1], 8), value(-anchor[0], 7)]),
        sigma: covariance.map(|covariance| covariance.noise_ratio),
    })
}

/// Radius about the anchor and height along the axis of a reference point's arc, m.
fn ring(circle: &Circle, anchor: [f64; 2], arc: &[Vector3<f64>]) -> [f64; 2] {
    let mut mean = [0.0; 2];
    for p in arc {
        let d = circle.axes.transpose() * (p - circle.centre);
        mean[0] += (d.x - anchor[0]).hypot(d.y - anchor[1]) / arc.len() as f64;
        mean[1] += d.z / arc.len() as f64;
    }
    mean
}

/// All circles about the joint's axis and about the anchor, m.
#[derive(Debug, Clone)]
struct Circles {
    circle: Circle,
    /// P0 in the circle's plane: along, across.
    anchor: [f64; 2],
    /// Radius and height of each reference point's arc.
    rings: Vec<[f64; 2]>,
}

/// Distances of measured points from the circles, m, as a function of changes from a start: a rotation vector of the axes
/// (0 to 2), P2 (3 to 5), L (6), P0 in the plane (7, 8), then radius and height of each arc.
struct Distances<'a> {
    start: Circles,
    points: &'a [(f64, Vector3<f64>)],
    arcs: &'a [Vec<Vector3<f64>>],
}

impl Distances<'_> {
    fn at(&self, x: &[f64]) -> Circles {
        let mut moved = self.start.clone();
        let circle = &mut moved.circle;
        circle.axes = Rotation3::new(Vector3::new(x[0], x[1], x[2])).matrix() * circle.axes;
        circle.centre += Vector3::new(x[3], x[4], x[5]);
        circle.radius += x[6];
        if !self.arcs.is_empty() {
            moved.anchor = [moved.anchor[0] + x[7], moved.anchor[1] + x[8]];
            for (ring, change) in moved.rings.iter_mut().zip(x[9..].chunks_exact(2)) {
                *ring = [ring[0] + change[0], ring[1] + change[1]];
            }
        }
        moved
    }

    /// Derivatives of the residuals at circles that are turned by the rotation vector `turn` from the start.
    fn derivatives(&self, at: &Circles, turn: &Vector3<f64>, jacobian: &mut DMatrix<f64>) {
        jacobian.fill(0.0);
        let (circle, rotation) = (&at.circle, left_jacobian(turn));
        let mut row = 0;
        for (q, _) in self.points {
            let direction = circle.axes * Vector3::new(q.cos(), q.sin(), 0.0);
            let by_rotation = (direction * circle.radius).cross_matrix() * rotation;
            jacobian.fixed_view_mut::<3, 3>(row, 0).copy_from(&by_rotation);
            jacobian.fixed_view_mut::<3, 3>(row, 3).copy_from(&-Matrix3::identity());
            jacobian.fixed_view_mut::<3, 1>(row, 6).copy_from(&-direction);
            row += 3;
        }
        let back = circle.axes.transpose();
        for (k, arc) in self.arcs.iter().enumerate() {
            for p in arc {
                let from_centre = p - circle.centre;
                let d = back * from_centre - Vector3::new(at.anchor[0], at.anchor[1], 0.0);
                let radius = d.x.hypot(d.y).max(f64::MIN_POSITIVE);
                let outwards = Vector3::new(d.x / radius, d.y / radius, 0.0);
                // The turned axes see the point turned back.
                let by_rotation = -(back * from_centre.cross_matrix() * rotation);
                for (at, direction) in [(row, outwards), (row + 1, Vector3::z())] {
                    jacobian.fixed_view_mut::<1, 3>(at, 0).copy_from(&(direction.transpose() * by_rotation));
                    jacobian.fixed_view_mut::<1, 3>(at, 3).copy_from(&(direction.transpose() * back));
                }
                jacobian[(row, 7)] = outwards.x;
                jacobian[(row, 8)] = outwards.y;
                jacobian[(row, 9 + 2 * k)] = 1.0;
                jacobian[(row + 1, 10 + 2 * k)] = 1.0;
                row += 2;
            }
        }
    }
}

impl Problem for Distances<'_> {
    fn parameters(&self) -> usize {
        7 + if self.arcs.is_empty() { 0 } else { 2 + 2 * self.arcs.len() }
    }

    fn residuals(&self) -> usize {
        3 * self.points.len() + 2 * self.arcs.iter().map(Vec::len).sum::<usize>()
    }

    fn evaluate(
        &self,
        x: &[f64],
        residual: &mut DVector<f64>,
        jacobian: Option<&mut DMatrix<f64>>,
    ) -> Result<(), EvaluationError> {
        let at = self.at(x);
        let circle = &at.circle;
        let mut row = 0;
        for (q, p) in self.points {
            let arm = circle.axes * Vector3::new(q.cos(), q.sin(), 0.0) * circle.radius;
            residual.fixed_rows_mut::<3>(row).copy_from(&(p - circle.centre - arm));
            row += 3;
        }
        for (arc, ring) in self.arcs.iter().zip(&at.rings) {
            for p in arc {
                let d = circle.axes.transpose() * (p - circle.centre);
                residual[row] = ring[0] - (d.x - at.anchor[0]).hypot(d.y - at.anchor[1]);
                residual[row + 1] = ring[1] - d.z;
                row += 2;
            }
        }
        if let Some(jacobian) = jacobian {
            self.derivatives(&at, &Vector3::new(x[0], x[1], x[2]), jacobian);
        }
        Ok(())
    }
}

/// k2_0, kc and s0 from compliances of the joint at several of its angles: eq. (13), (14), linear in the stiffnesses.
/// Where all compliances have intervals, they are weighted by them.
///
/// # Errors
/// Fewer than three compliances, or some that no spring explains.
pub fn elasticity(at: &Triangle, found: &[JointCompliance]) -> Result<Elasticity, CompensatorError> {
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
    let stated = found.iter().all(|k| k.ci95.is_some());
    // Of a stiffness 1/k.
    let sigma = |k: &JointCompliance| match k.ci95 {
        Some(ci) if stated => ci / normal95() / (k.compliance * k.compliance),
        _ => 1.0,
    };
    let matrix = DMatrix::from_fn(found.len(), 3, |i, j| at.row(found[i].angle)[j] / sigma(&found[i]));
    let right = DVector::from_iterator(found.len(), found.iter().map(|k| 1.0 / k.compliance / sigma(k)));
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
    let degrees = found.len() as f64 - 3.0;
    // Half width over the root of the cofactor: by the residuals, else by the stated intervals.
    let size = match (degrees > 0.0, stated) {
        (true, _) => Some(residual.norm() / degrees.sqrt() * t95(degrees)),
        (false, true) => Some(normal95()),
        (false, false) => None,
    };
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
    Ok(result)
}
