//! `contact`: a ball on the tool touches a fixture. No instrument: the reading is that it touches, so nothing is measured and
//! every residual is a distance (m) of the ball's centre from where the fixture holds it. The place of the fixture, in the
//! measurement frame, is known or estimated.
//!
//! A socket gives three residuals, a face or a sphere one. Pivoting about a point (tool-centre calibration) is a socket.

use nalgebra::{Matrix3, Vector3};

use super::kind::{
    CONTACT_COLUMN, MOST_TARGET_VALUES, MeasuredPoint, Noise, Observation, PointDerivative, Rows, TargetValues,
    centre_of, row, rows_of,
};

/// As files name the kind; what is touched says which of the others a reading is.
pub(super) struct Contact;
/// A socket; values of its target: its centre (m).
pub(super) struct Socket;
/// What holds the ball in one direction alone.
pub(super) enum Surface {
    /// A face; values of its target: a normal of any length, and the distance of the ball's centre from the origin along it (m).
    Plane,
    /// A sphere; values of its target: its centre and the distance of the ball's centre from it (m).
    Sphere,
}

/// What contacts depend on.
const CONTACT: &str = "where the ball is on the tool, its radius, and what it touches";

fn mean(read: &[MeasuredPoint]) -> Vector3<f64> {
    read.iter().map(MeasuredPoint::position).sum::<Vector3<f64>>() / read.len().max(1) as f64
}

impl Observation for Contact {
    fn name(&self) -> &'static str {
        "contact"
    }

    fn about(&self) -> &'static str {
        "A ball on the tool touches a socket, a face or a sphere."
    }

    fn target_column(&self) -> Option<&'static str> {
        Some(CONTACT_COLUMN)
    }

    // The ball and what it touches are as long as they are.
    fn is_scaled(&self) -> bool {
        false
    }

    fn value(&self, _point: &MeasuredPoint) -> Rows {
        row(0.0)
    }

    fn derivative(&self, _point: &MeasuredPoint, _by: &PointDerivative) -> Rows {
        row(0.0)
    }

    fn sigmas(&self, noise: &Noise) -> Rows {
        rows_of(&noise.position.into())
    }
}

impl Observation for Socket {
    fn name(&self) -> &'static str {
        "contact-socket"
    }

    fn depends_on(&self) -> &'static str {
        CONTACT
    }

    fn about(&self) -> &'static str {
        "A ball on the tool sits in a socket."
    }

    fn rows(&self) -> usize {
        3
    }

    fn length_rows(&self) -> usize {
        3
    }

    fn target_column(&self) -> Option<&'static str> {
        Some(CONTACT_COLUMN)
    }

    // The ball and what it touches are as long as they are.
    fn is_scaled(&self) -> bool {
        false
    }

    fn holds_point(&self) -> bool {
        true
    }

    fn value(&self, point: &MeasuredPoint) -> Rows {
        rows_of(&(point.position() - point.anchor()))
    }

    fn derivative(&self, _point: &MeasuredPoint, by: &PointDerivative) -> Rows {
        rows_of(&by.total().displacement)
    }

    fn target_start(&self, read: &[MeasuredPoint]) -> Option<TargetValues> {
        let mut start = [0.0; MOST_TARGET_VALUES];
        start[..3].copy_from_slice(mean(read).as_slice());
        Some(start)
    }

    fn by_target(&self, _point: &MeasuredPoint, k: usize) -> Rows {
        let mut rows = [0.0; 6];
        rows[k] = -1.0;
        rows
    }

    fn disturb(&self, measured: &mut Rows, noise: &Noise, normal: &mut dyn FnMut() -> f64) {
        *measured = rows_of(&Vector3::from_fn(|k, _| noise.position[k] * normal()));
    }
}

/// Unit normal, length of the normal, and signed distance of the ball from the face.
fn over_face(point: &MeasuredPoint) -> (Vector3<f64>, f64, f64) {
    let normal = point.anchor();
    let length = normal.norm().max(f64::MIN_POSITIVE);
    let unit = normal / length;
    (unit, length, unit.dot(&point.position()) - point.target[3])
}

/// Direction from the centre to the ball, and how far its distance is from the one that touches.
fn over_sphere(point: &MeasuredPoint) -> (Vector3<f64>, f64) {
    let arm = point.position() - point.anchor();
    let length = arm.norm();
    (arm / length.max(f64::MIN_POSITIVE), length - point.target[3])
}

/// The plane of least squares through points; its normal points away from the base of the arrangement.
fn plane_through(read: &[MeasuredPoint]) -> (Vector3<f64>, f64) {
    let mean = mean(read);
    let spread: Matrix3<f64> =
        read.iter().map(|point| (point.position() - mean) * (point.position() - mean).transpose()).sum();
    let eigen = spread.symmetric_eigen();
    let normal = eigen.eigenvectors.column(eigen.eigenvalues.imin()).into_owned();
    let normal = if normal.dot(&mean) < 0.0 { -normal } else { normal };
    (normal, normal.dot(&mean))
}

/// The sphere of least squares of |p|^2 = 2 a.p + (R^2 - |a|^2), which is linear.
fn sphere_through(read: &[MeasuredPoint]) -> Option<(Vector3<f64>, f64)> {
    let (centre, left) = centre_of(read.iter().map(|point| (point.position(), point.position().norm_squared())))?;
    Some((centre, (left + centre.norm_squared()).max(0.0).sqrt()))
}

impl Observation for Surface {
    fn name(&self) -> &'static str {
        match self {
            Self::Plane => "contact-plane",
            Self::Sphere => "contact-sphere",
        }
    }

    fn depends_on(&self) -> &'static str {
        CONTACT
    }

    fn about(&self) -> &'static str {
        match self {
            Self::Plane => "A ball on the tool touches a face.",
            Self::Sphere => "A ball on the tool touches a sphere.",
        }
    }

    fn rows(&self) -> usize {
        1
    }

    fn length_rows(&self) -> usize {
        1
    }

    fn target_column(&self) -> Option<&'static str> {
        Some(CONTACT_COLUMN)
    }

    // The ball and what it touches are as long as they are.
    fn is_scaled(&self) -> bool {
        false
    }

    fn is_on_face(&self) -> bool {
        matches!(self, Self::Plane)
    }

    fn residuals_named(&self) -> &'static str {
        match self {
            Self::Plane => "distances from the face",
            Self::Sphere => "distances from the sphere",
        }
    }

    fn value(&self, point: &MeasuredPoint) -> Rows {
        row(match self {
            Self::Plane => over_face(point).2,
            Self::Sphere => over_sphere(point).1,
        })
    }

    fn derivative(&self, point: &MeasuredPoint, by: &PointDerivative) -> Rows {
        let direction = match self {
            Self::Plane => over_face(point).0,
            Self::Sphere => over_sphere(point).0,
        };
        row(direction.dot(&by.total().displacement))
    }

    fn target_start(&self, read: &[MeasuredPoint]) -> Option<TargetValues> {
        let (first, last) = match self {
            Self::Plane => plane_through(read),
            Self::Sphere => sphere_through(read)?,
        };
        let mut start = [0.0; MOST_TARGET_VALUES];
        start[..3].copy_from_slice(first.as_slice());
        start[3] = last;
        Some(start)
    }

    fn target_start_near(&self, near: &TargetValues, read: &[MeasuredPoint]) -> Option<TargetValues> {
        let centre = Vector3::from_column_slice(&near[..3]);
        let distances = read.iter().map(|point| (point.position() - centre).norm());
        let radius = distances.sum::<f64>() / read.len() as f64;
        let mut start = *near;
        start[3] = radius;
        matches!(self, Self::Sphere).then_some(start)
    }

    fn touched_from(&self, target: &TargetValues, direction: &Vector3<f64>) -> Option<Vector3<f64>> {
        let centre = Vector3::from_column_slice(&target[..3]);
        matches!(self, Self::Sphere).then(|| centre + target[3] * direction)
    }

    fn by_target(&self, point: &MeasuredPoint, k: usize) -> Rows {
        row(match self {
            _ if k == 3 => -1.0,
            Self::Plane => {
                let (unit, length, _) = over_face(point);
                let position = point.position();
                (position[k] - unit[k] * unit.dot(&position)) / length
            }
            Self::Sphere => -over_sphere(point).0[k],
        })
    }

    fn disturb(&self, measured: &mut Rows, noise: &Noise, normal: &mut dyn FnMut() -> f64) {
        *measured = row(noise.position[0] * normal());
    }

    fn is_comparable(&self, _same_point: bool, same_target: bool) -> bool {
        same_target
    }
}
