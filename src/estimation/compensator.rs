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

use crate::math::linear::cofactor;
use crate::math::quantiles::{normal95, t95};

/// A value with the half width of its 95 % interval; NaN where the data leave nothing to judge it by.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Value {
    /// SI.
    pub value: f64,
    /// SI.
    pub ci95: f64,
}

/// Why a compensator cannot be found.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{0}")]
pub struct CompensatorError(pub String);

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
    /// ax and ay, m; none where no anchor was measured.
    pub anchor: Option<[Value; 2]>,
    /// Standard deviation of a coordinate about the fitted circles, m; NaN where nothing is left over.
    pub sigma: f64,
}

/// L, ax and ay, m: all that the spring's law needs to know of its mounting.
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
    let (mut moment, mut spread) = (Matrix3::zeros(), Matrix3::zeros());
    for (q, p) in points {
        let u = unit(*q) - mean_unit;
        moment += u * (p - mean).transpose();
        spread += u * u.transpose();
    }
    let turned = spread.symmetric_eigenvalues();
    let mut turned = [turned[0], turned[1], turned[2]];
    turned.sort_by(f64::total_cmp);
    if turned[1] < 1e-9 * turned[2].max(f64::MIN_POSITIVE) || turned[2] < 1e-9 {
        return refuse("the angles of P1 are all the same, or only two: turn the joint further");
    }
    let svd = moment.svd(true, true);
    let (Some(u), Some(v)) = (svd.u, svd.v_t) else { return refuse("the circle's directions cannot be separated") };
    if svd.singular_values[1] < 1e-9 * svd.singular_values[0].max(f64::MIN_POSITIVE) {
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
    let (mut moment, mut right) = (Matrix3::zeros(), Vector3::zeros());
    for arc in arcs {
        let mean = arc.iter().sum::<Vector3<f64>>() / arc.len() as f64 - middle;
        let mean_square = arc.iter().map(|p| (p - middle).norm_squared()).sum::<f64>() / arc.len() as f64;
        for p in arc {
            let (p, square) = (p - middle - mean, (p - middle).norm_squared() - mean_square);
            moment += p * p.transpose();
            right += p * (0.5 * square);
        }
    }
    // Singular values of the stacked points are the roots of these, their directions the same.
    let mut directions: Vec<(f64, Vector3<f64>)> = {
        let found = moment.symmetric_eigen();
        (0..3).map(|k| (found.eigenvalues[k], found.eigenvectors.column(k).into_owned())).collect()
    };
    directions.sort_by(|a, b| b.0.total_cmp(&a.0));
    if directions[1].0 < 1e-9 * directions[0].0.max(f64::MIN_POSITIVE) || directions[0].0 <= 0.0 {
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
    let mut found = circle(points)?;
    let mut hung = [0.0; 2];
    let mut rings: Vec<[f64; 2]> = Vec::new();
    if !arcs.is_empty() {
        let local = found.axes.transpose() * (anchor(arcs)? - found.centre);
        hung = [local.x, local.y];
        rings = arcs.iter().map(|arc| ring(&found, hung, arc)).collect();
    }
    let rows = 3 * points.len() + 2 * arcs.iter().map(Vec::len).sum::<usize>();
    let columns = 7 + if arcs.is_empty() { 0 } else { 2 + 2 * arcs.len() };
    let (mut residual, mut jacobian) = (DVector::zeros(rows), DMatrix::zeros(rows, columns));
    for _ in 0..50 {
        linearise(&found, hung, &rings, points, arcs, &mut residual, &mut jacobian);
        let scale = DVector::from_iterator(columns, jacobian.column_iter().map(|c| c.norm().max(f64::MIN_POSITIVE)));
        let scaled = DMatrix::from_fn(rows, columns, |i, j| jacobian[(i, j)] / scale[j]);
        let Ok(step) = scaled.svd(true, true).solve(&residual, 1e-12) else { break };
        let step = step.component_div(&scale);
        found.axes = Rotation3::new(Vector3::new(step[0], step[1], step[2])).matrix() * found.axes;
        found.centre += Vector3::new(step[3], step[4], step[5]);
        found.radius += step[6];
        if !arcs.is_empty() {
            hung = [hung[0] + step[7], hung[1] + step[8]];
            for (k, ring) in rings.iter_mut().enumerate() {
                *ring = [ring[0] + step[9 + 2 * k], ring[1] + step[10 + 2 * k]];
            }
        }
        if step.norm() < 1e-13 {
            break;
        }
    }
    linearise(&found, hung, &rings, points, arcs, &mut residual, &mut jacobian);
    let degrees = rows as f64 - columns as f64;
    let sigma = if degrees > 0.0 { residual.norm() / degrees.sqrt() } else { f64::NAN };
    let cofactor = cofactor(&jacobian);
    let value = |value: f64, k: usize| Value { value, ci95: t95(degrees) * sigma * cofactor[(k, k)].max(0.0).sqrt() };
    let anchor = (!arcs.is_empty()).then(|| [value(-hung[1], 8), value(-hung[0], 7)]);
    Ok(Mounting { circle: found, lever: value(found.radius, 6), anchor, sigma })
}

/// Radius about the anchor and height along the axis of a reference point's arc.
fn ring(circle: &Circle, hung: [f64; 2], arc: &[Vector3<f64>]) -> [f64; 2] {
    let mut mean = [0.0; 2];
    for p in arc {
        let d = circle.axes.transpose() * (p - circle.centre);
        mean[0] += (d.x - hung[0]).hypot(d.y - hung[1]) / arc.len() as f64;
        mean[1] += d.z / arc.len() as f64;
    }
    mean
}

/// Measured less modelled, and derivatives of the model: rotation of the axes, P2, L, P0 in the plane, then radius and
/// height of each arc.
fn linearise(
    circle: &Circle,
    hung: [f64; 2],
    rings: &[[f64; 2]],
    points: &[(f64, Vector3<f64>)],
    arcs: &[Vec<Vector3<f64>>],
    residual: &mut DVector<f64>,
    jacobian: &mut DMatrix<f64>,
) {
    jacobian.fill(0.0);
    let mut row = 0;
    for (q, p) in points {
        let direction = circle.axes * Vector3::new(q.cos(), q.sin(), 0.0);
        let arm = direction * circle.radius;
        residual.fixed_rows_mut::<3>(row).copy_from(&(p - circle.centre - arm));
        jacobian.fixed_view_mut::<3, 3>(row, 0).copy_from(&-arm.cross_matrix());
        jacobian.fixed_view_mut::<3, 3>(row, 3).copy_from(&Matrix3::identity());
        jacobian.fixed_view_mut::<3, 1>(row, 6).copy_from(&direction);
        row += 3;
    }
    let back = circle.axes.transpose();
    for (k, (arc, ring)) in arcs.iter().zip(rings).enumerate() {
        for p in arc {
            let from_centre = p - circle.centre;
            let d = back * from_centre - Vector3::new(hung[0], hung[1], 0.0);
            let radius = d.x.hypot(d.y).max(f64::MIN_POSITIVE);
            let outwards = Vector3::new(d.x / radius, d.y / radius, 0.0);
            residual[row] = ring[0] - radius;
            residual[row + 1] = ring[1] - d.z;
            // Of radius and height, by rotation and by P2; what is modelled is that both keep their arc's values.
            let turned = back * from_centre.cross_matrix();
            for (at, direction) in [(row, outwards), (row + 1, Vector3::z())] {
                jacobian.fixed_view_mut::<1, 3>(at, 0).copy_from(&(direction.transpose() * turned));
                jacobian.fixed_view_mut::<1, 3>(at, 3).copy_from(&-(direction.transpose() * back));
            }
            jacobian[(row, 7)] = -outwards.x;
            jacobian[(row, 8)] = -outwards.y;
            jacobian[(row, 9 + 2 * k)] = -1.0;
            jacobian[(row + 1, 10 + 2 * k)] = -1.0;
            row += 2;
        }
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
            "{} compliances do not tell three numbers: three angles or more are needed",
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
    let quantile = normal95();
    // Of a stiffness 1/k.
    let sigma = |k: &JointCompliance| match k.ci95 {
        Some(ci) if stated => ci / quantile / (k.compliance * k.compliance),
        _ => 1.0,
    };
    let matrix = DMatrix::from_fn(found.len(), 3, |i, j| at.row(found[i].angle)[j] / sigma(&found[i]));
    let right = DVector::from_iterator(found.len(), found.iter().map(|k| 1.0 / k.compliance / sigma(k)));
    let norms: Vec<f64> = matrix.column_iter().map(|c| c.norm().max(f64::MIN_POSITIVE)).collect();
    let svd = DMatrix::from_fn(found.len(), 3, |i, j| matrix[(i, j)] / norms[j]).svd(true, true);
    let least = svd.singular_values.min() / svd.singular_values.max();
    let Ok(scaled) = svd.solve(&right, 0.0) else { return refuse("the stiffnesses cannot be separated") };
    if least < 1e-9 {
        return refuse("the angles do not tell the joint from the spring: three different angles or more are needed");
    }
    let [joint, rate, preload] = [0, 1, 2].map(|k| scaled[k] / norms[k]);
    if joint <= 0.0 || rate <= 0.0 {
        return refuse(format!(
            "no spring explains these compliances: the joint alone would have {joint:.3e} N.m/rad and the spring {rate:.3e} N/m"
        ));
    }
    let left = &right - &matrix * DVector::from_column_slice(&[joint, rate, preload]);
    let degrees = found.len() as f64 - 3.0;
    let (size, quantile) = match (degrees > 0.0, stated) {
        (true, _) => (left.norm() / degrees.sqrt(), t95(degrees)),
        (false, true) => (1.0, quantile),
        (false, false) => (f64::NAN, quantile),
    };
    let cofactor = cofactor(&matrix);
    // Widths of 1/K0, 1/Kc and (s0 Kc)/Kc to first order.
    let width = |gradient: [f64; 3]| {
        let g = DVector::from_column_slice(&gradient);
        quantile * size * (&cofactor * &g).dot(&g).max(0.0).sqrt()
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
