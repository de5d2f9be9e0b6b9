//! The constants that place one frame in another: from a displacement to the table, and back.
//!
//! W. Khalil and J. F. Kleinfinger, "A new geometric notation for open and closed-loop robots", Proc. IEEE Int. Conf. on
//! Robotics and Automation, 1986; the turn beta in front is that of S. A. Hayati, "Robot arm geometric link parameter
//! estimation", Proc. 22nd IEEE Conf. on Decision and Control, 1983.

use std::f64::consts::{FRAC_PI_2, PI};

use nalgebra::{IsometryMatrix3, Matrix3, Rotation3, Translation3, Vector3};

use crate::description::robot::Constants;

/// A displacement: the pose of a frame in another, metres.
pub type Isometry = IsometryMatrix3<f64>;

/// Below this sine of their angle two axes count as parallel. Round-off leaves 1e-15; nothing that is built is so true.
pub(crate) const PARALLEL: f64 = 5e-13;

/// Below this sine of their angle (about 3 degrees) the common normal of two axes may lie far away: up to 20 times their
/// offset at this limit, without bound below it. The tilt then goes into beta and the normal stays at hand.
const NEARLY_PARALLEL: f64 = 0.05;

/// Least share of the normal that must lie along the antecedent's x for a small beta to give it the wanted tilt.
const WITHIN_REACH: f64 = 0.1;

impl Constants {
    /// The displacement: the product of the elementary transforms.
    pub fn isometry(&self) -> Isometry {
        about_y(self.beta)
            * screw_z(self.gamma, self.b)
            * Isometry::from_parts(Translation3::new(self.d, 0.0, 0.0), about_x(self.alpha))
            * screw_z(self.theta, self.r)
    }
}

/// Constants of a displacement: their product is `t` to round-off (1e-12 of the unit or of the displacement's length).
///
/// * gamma lies in (-90, 90] degrees, so that gamma = b = 0 whenever the antecedent's x already lies along the common
///   normal of the two z axes, whichever its sense.
/// * Parallel axes (sine of the angle up to 5e-13): alpha is 0 or 180 degrees exactly, b = 0, gamma and d give the offset.
/// * Nearly parallel axes (sine up to 0.05): their common normal may be kilometres off, so b = 0, d is the distance from
///   the antecedent's origin to the axis, and a small beta gives the tilt that is left. Where beta cannot (the axis lies
///   off along y, which it turns about), beta is 90 degrees and the remaining constants are well conditioned.
/// * Otherwise beta = 0 and the constants follow from the common normal.
///
/// Angles within round-off of a multiple of 15 degrees, and numbers within round-off of one of twelve decimals, are given
/// as just that.
pub fn khalil_kleinfinger(t: &Isometry) -> Constants {
    match Normal::of(t) {
        Normal::Parallel { gamma, d } => {
            let up = t.rotation.matrix()[(2, 2)] > 0.0;
            let along = Vector3::new(gamma.cos(), gamma.sin(), 0.0);
            let axis = Vector3::new(0.0, 0.0, if up { 1.0 } else { -1.0 });
            let r = t.translation.vector.dot(&axis);
            Constants { gamma, d, alpha: if up { 0.0 } else { PI }, r, ..Constants::default() }.turned(t, &along, &axis)
        }
        Normal::Near { along } => {
            // The sense with cos(gamma) > 0.
            let along = if along.x < 0.0 { -along } else { along };
            if along.x < WITHIN_REACH {
                let remainder = about_y(-FRAC_PI_2) * t;
                return Constants { beta: FRAC_PI_2, ..crossed(&remainder) };
            }
            let axis = axis_of(t);
            let beta = (-along.z).atan2(along.x);
            let gamma = along.y.atan2(along.x.hypot(along.z));
            let before = Vector3::new(beta.sin(), 0.0, beta.cos());
            let alpha = along.dot(&before.cross(&axis)).atan2(before.dot(&axis));
            let (d, r) = (t.translation.vector.dot(&along), t.translation.vector.dot(&axis));
            Constants { beta, gamma, b: 0.0, alpha, d, theta: 0.0, r }.turned(t, &along, &axis)
        }
        Normal::Crossed => crossed(t),
    }
}

/// The constants when the axes cross at a good angle: beta = 0.
fn crossed(t: &Isometry) -> Constants {
    let (axis, p) = (axis_of(t), t.translation.vector);
    let gamma = fold(axis.x.atan2(-axis.y));
    let (sin, cos) = sin_cos(gamma);
    let along = Vector3::new(cos, sin, 0.0);
    let across = Vector3::new(-sin, cos, 0.0);
    // The axis is cos(alpha) z - sin(alpha) across.
    let (sin_alpha, cos_alpha) = (-across.dot(&axis), axis.z);
    let r = -p.dot(&across) / sin_alpha;
    Constants {
        gamma,
        b: p.z - r * cos_alpha,
        alpha: sin_alpha.atan2(cos_alpha),
        d: p.dot(&along),
        r,
        ..Constants::default()
    }
    .turned(t, &along, &axis)
}

/// By how much the antecedent must turn about its z and slide along it to see the frame `t` with gamma = b = 0 (and, if
/// the axes are nearly parallel, with the smallest beta): the lesser of the two turns, and of two quarter turns that with
/// a positive d. Radians, metres.
pub(crate) fn shift_to_normal(t: &Isometry) -> (f64, f64) {
    let (turn, slide, d) = match Normal::of(t) {
        Normal::Parallel { gamma, d } => (gamma, 0.0, d),
        Normal::Near { along } => {
            let turn = fold(along.y.atan2(along.x));
            let (sin, cos) = sin_cos(turn);
            (turn, 0.0, t.translation.vector.x * cos + t.translation.vector.y * sin)
        }
        Normal::Crossed => {
            let Constants { gamma, b, d, .. } = crossed(t);
            (gamma, b, d)
        }
    };
    (if turn == FRAC_PI_2 && d < 0.0 { -turn } else { turn }, slide)
}

/// How the two z axes lie.
enum Normal {
    /// Parallel: the offset in polar form, gamma in (-90, 90] degrees.
    Parallel { gamma: f64, d: f64 },
    /// Nearly parallel: the unit vector from the antecedent's origin straight to the axis.
    Near { along: Vector3<f64> },
    /// At an angle.
    Crossed,
}

impl Normal {
    fn of(t: &Isometry) -> Self {
        let (axis, p) = (axis_of(t), t.translation.vector);
        let sine = axis.x.hypot(axis.y);
        if sine > NEARLY_PARALLEL {
            return Self::Crossed;
        }
        if sine <= PARALLEL {
            let d = p.x.hypot(p.y);
            if d <= 1e-15 * (1.0 + p.norm()) {
                return Self::Parallel { gamma: 0.0, d: 0.0 };
            }
            let gamma = clean_angle(fold(p.y.atan2(p.x)));
            let (sin, cos) = sin_cos(gamma);
            return Self::Parallel { gamma, d: p.x * cos + p.y * sin };
        }
        let across = |v: Vector3<f64>| v - axis * v.dot(&axis);
        let foot = across(p);
        // Twice, so that the normal of a tiny offset is square to the axis too.
        let along = if foot.norm() <= 1e-14 * (1.0 + p.norm()) { Vector3::x() } else { foot.normalize() };
        Self::Near { along: across(across(along)).normalize() }
    }
}

impl Constants {
    /// With theta, the angle from the normal `along` to the x axis of `t` about its z axis; and rid of round-off.
    fn turned(self, t: &Isometry, along: &Vector3<f64>, axis: &Vector3<f64>) -> Self {
        let x = t.rotation.matrix().column(0).into_owned();
        let theta = axis.dot(&along.cross(&x)).atan2(along.dot(&x));
        let scale = 1.0 + t.translation.vector.norm();
        Self {
            beta: clean_angle(self.beta),
            gamma: clean_angle(self.gamma),
            b: clean(self.b, scale),
            alpha: clean_angle(self.alpha),
            d: clean(self.d, scale),
            theta: clean_angle(theta),
            r: clean(self.r, scale),
        }
    }
}

fn axis_of(t: &Isometry) -> Vector3<f64> {
    t.rotation.matrix().column(2).into_owned()
}

/// The angle of the same line within (-90, 90] degrees.
fn fold(angle: f64) -> f64 {
    let angle = clean_angle(angle);
    if angle > FRAC_PI_2 {
        angle - PI
    } else if angle <= -FRAC_PI_2 {
        angle + PI
    } else {
        angle
    }
}

/// An angle in (-pi, pi] rid of round-off: a multiple of 15 degrees or a number of twelve decimals if it is within 2e-15
/// of one.
pub(crate) fn clean_angle(angle: f64) -> f64 {
    let step = (angle / (PI / 12.0)).round();
    let exact = if step % 6.0 == 0.0 { step / 6.0 * FRAC_PI_2 } else { (15.0 * step).to_radians() };
    if (angle - exact).abs() > 2e-15 {
        return clean(angle, 1.0);
    }
    if exact <= -PI { PI } else { exact + 0.0 }
}

/// A number of twelve decimals if `value` is within round-off of one, `scale` being the size of what it was computed from.
pub(crate) fn clean(value: f64, scale: f64) -> f64 {
    let rounded = (value * 1e12).round() / 1e12;
    // `+ 0.0` turns -0 into 0.
    if (value - rounded).abs() <= 2e-15 * scale { rounded + 0.0 } else { value }
}

/// Sine and cosine, exact at multiples of 90 degrees.
fn sin_cos(angle: f64) -> (f64, f64) {
    let quarter = (angle / FRAC_PI_2).round();
    if (angle - quarter * FRAC_PI_2).abs() > 4e-16 * quarter.abs().max(0.25) {
        return angle.sin_cos();
    }
    match quarter.rem_euclid(4.0) {
        1.0 => (1.0, 0.0),
        2.0 => (0.0, -1.0),
        3.0 => (-1.0, 0.0),
        _ => (0.0, 1.0),
    }
}

/// Rotation about x, exact at multiples of 90 degrees.
pub(crate) fn about_x(angle: f64) -> Rotation3<f64> {
    let (s, c) = sin_cos(angle);
    Rotation3::from_matrix_unchecked(Matrix3::new(1.0, 0.0, 0.0, 0.0, c, -s, 0.0, s, c))
}

/// Rotation about y, exact at multiples of 90 degrees.
pub(crate) fn about_y(angle: f64) -> Rotation3<f64> {
    let (s, c) = sin_cos(angle);
    Rotation3::from_matrix_unchecked(Matrix3::new(c, 0.0, s, 0.0, 1.0, 0.0, -s, 0.0, c))
}

/// Rotation about z, exact at multiples of 90 degrees.
pub(crate) fn about_z(angle: f64) -> Rotation3<f64> {
    let (s, c) = sin_cos(angle);
    Rotation3::from_matrix_unchecked(Matrix3::new(c, -s, 0.0, s, c, 0.0, 0.0, 0.0, 1.0))
}

/// Rotation about z and translation along it.
pub(crate) fn screw_z(angle: f64, length: f64) -> Isometry {
    Isometry::from_parts(Translation3::new(0.0, 0.0, length), about_z(angle))
}

/// Roll, pitch and yaw whose rotation is this one to round-off, at a pitch of 90 degrees too.
pub(crate) fn roll_pitch_yaw(rotation: &Rotation3<f64>) -> Vector3<f64> {
    let m = rotation.matrix();
    let level = m[(0, 0)].hypot(m[(1, 0)]);
    // Any yaw does at a pitch of 90 degrees; roll and pitch are read from what remains once yaw is undone.
    let yaw = if level < 4e-16 { 0.0 } else { clean_angle(m[(1, 0)].atan2(m[(0, 0)])) };
    let unyawed = about_z(-yaw) * rotation;
    let unyawed = unyawed.matrix();
    let pitch = (-unyawed[(2, 0)]).atan2(unyawed[(0, 0)]).clamp(-FRAC_PI_2, FRAC_PI_2);
    let roll = (-unyawed[(1, 2)]).atan2(unyawed[(1, 1)]);
    Vector3::new(clean_angle(roll), clean_angle(pitch), yaw)
}
