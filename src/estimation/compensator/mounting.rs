//! Where the spring is hung, from measured points: KR-270 paper, eq. (6), (7). Positions in m in any axes, angles in rad.

use nalgebra::{DMatrix, DVector, Matrix3, Rotation3, Vector3};

use super::value::{CompensatorError, DEGENERATE, Value, refuse};
use crate::estimation::covariance::Covariance;
use crate::least_squares::{self, Bounds, EvaluationError, Problem};
use crate::math::linear::{Svd, singular_values};
use crate::math::{left_jacobian, nearest_rotation};

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
    let values = singular_values(&DMatrix::from_column_slice(3, 3, cross.as_slice())).unwrap_or_default();
    if values.get(1).is_none_or(|second| *second < DEGENERATE * values[0].max(f64::MIN_POSITIVE)) {
        return refuse("the points of P1 lie on a line or in one place: they do not turn with the angles given");
    }
    let axes = nearest_rotation(&cross.transpose()).into_inner();
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
    let (mut points, mut right) = (Vec::new(), Vec::new());
    for arc in arcs {
        let mean = arc.iter().sum::<Vector3<f64>>() / arc.len() as f64 - middle;
        let mean_square = arc.iter().map(|p| (p - middle).norm_squared()).sum::<f64>() / arc.len() as f64;
        points.extend(arc.iter().map(|p| p - middle - mean));
        right.extend(arc.iter().map(|p| 0.5 * ((p - middle).norm_squared() - mean_square)));
    }
    let unseen = || refuse("the reference points move along a line or not at all: no centre is seen from them");
    let stacked = DMatrix::from_fn(points.len(), 3, |row, k| points[row][k]);
    let Some(Svd { left, values, right: directions }) = Svd::new(&stacked) else { return unseen() };
    if values[0] <= 0.0 || values[1] < DEGENERATE.sqrt() * values[0] {
        return unseen();
    }
    let along = left.tr_mul(&DVector::from_vec(right));
    let in_plane: Vector3<f64> =
        (0..2).map(|k| Vector3::from_fn(|i, _| directions[(i, k)]) * (along[k] / values[k])).sum();
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
