//! Springs and gravity compensators between points of two bodies.
//!
//! The relative motion of the two bodies is a twist about the joint between them; the spring's force and its tangent
//! stiffness, tension included, are first and second derivatives of its energy K (s - s0)^2 / 2 by that twist. About a
//! single joint this is eq. (10), (11) of the KR-270 paper.

use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};

use crate::description::raw::SpringAction;
use crate::kinematics::Placements;
use crate::model::SpringElement;

/// A spring at a placed configuration, base axes.
#[derive(Debug, Clone, Copy)]
pub struct State {
    /// The point about which the twist of the second body against the first is counted.
    pub pivot: Vector3<f64>,
    /// Arm from the pivot to the anchor on the second body.
    pub arm: Vector3<f64>,
    /// Unit vector from the first anchor to the second.
    pub along: Vector3<f64>,
    /// Length, m.
    pub length: f64,
    /// Rate, N/m.
    pub rate: f64,
    /// Tension, N; zero where no free length is known.
    pub tension: f64,
    /// Whether the tension loads the bodies.
    pub loads: bool,
}

impl State {
    /// The spring at a configuration.
    pub fn new(of: &SpringElement, values: &[f64], placements: &Placements) -> Self {
        let anchor = |k: usize| {
            let at = nalgebra::Point3::new(
                values[of.slots[2 + 3 * k]],
                values[of.slots[3 + 3 * k]],
                values[of.slots[4 + 3 * k]],
            );
            (placements.frames[of.spring.bodies[k]] * at).coords
        };
        let (a, b) = (anchor(0), anchor(1));
        let pivot = placements.frames[of.pivot].translation.vector;
        let length = (b - a).norm();
        let rate = values[of.slots[0]];
        let stretch = if of.spring.free_length.is_some() { length - values[of.slots[1]] } else { 0.0 };
        Self {
            pivot,
            arm: b - pivot,
            along: (b - a) / length.max(f64::MIN_POSITIVE),
            length,
            rate,
            tension: rate * stretch,
            loads: of.spring.acts == SpringAction::Full,
        }
    }

    /// First derivative of the length by the twist.
    fn gradient(&self) -> Vector6<f64> {
        let turn = self.arm.cross(&self.along);
        Vector6::new(self.along.x, self.along.y, self.along.z, turn.x, turn.y, turn.z)
    }

    /// Second derivative of the length by the twist, in exponential coordinates.
    fn curvature(&self) -> Matrix6<f64> {
        let across = (Matrix3::identity() - self.along * self.along.transpose()) / self.length.max(f64::MIN_POSITIVE);
        let arm = self.arm.cross_matrix();
        let mut matrix = Matrix6::zeros();
        // Displacement of the anchor d + w x arm; and the bow w x (w x arm) / 2 of a finite turn.
        let mixed = -across * arm;
        let bow = 0.5 * (self.along * self.arm.transpose() + self.arm * self.along.transpose())
            - Matrix3::identity() * self.along.dot(&self.arm);
        matrix.fixed_view_mut::<3, 3>(0, 0).copy_from(&across);
        matrix.fixed_view_mut::<3, 3>(0, 3).copy_from(&mixed);
        matrix.fixed_view_mut::<3, 3>(3, 0).copy_from(&mixed.transpose());
        matrix.fixed_view_mut::<3, 3>(3, 3).copy_from(&(arm.transpose() * across * arm + bow));
        matrix
    }

    /// Tangent stiffness about the pivot (force, moment by displacement, rotation).
    pub fn stiffness(&self) -> Matrix6<f64> {
        let gradient = self.gradient();
        gradient * gradient.transpose() * self.rate + self.curvature() * self.tension
    }

    /// Wrench on the second body about the pivot (its opposite acts on the first); zero where only stiffness is to act.
    pub fn wrench(&self) -> Vector6<f64> {
        if self.loads { -self.gradient() * self.tension } else { Vector6::zeros() }
    }

    /// Derivatives of stiffness and wrench by the rate and the free length.
    pub fn by_rate_and_length(&self) -> [(Matrix6<f64>, Vector6<f64>); 2] {
        let (gradient, curvature) = (self.gradient(), self.curvature());
        let stretch = if self.rate == 0.0 { 0.0 } else { self.tension / self.rate };
        let load = |by: f64| if self.loads { -gradient * by } else { Vector6::zeros() };
        [
            (gradient * gradient.transpose() + curvature * stretch, load(stretch)),
            (curvature * -self.rate, load(-self.rate)),
        ]
    }

    /// Derivatives of stiffness and wrench by moving an anchor (0 on the first body, 1 on the second) along `step`
    /// (base axes); `strained` where the tension follows the length.
    pub fn by_anchor(&self, anchor: usize, step: &Vector3<f64>, strained: bool) -> (Matrix6<f64>, Vector6<f64>) {
        if anchor == 0 {
            self.by_motion(&-step, &Vector3::zeros(), strained)
        } else {
            self.by_motion(step, step, strained)
        }
    }

    /// The same by moving the second anchor against the first by `pull`, and against the pivot by `dr`.
    pub fn by_motion(&self, pull: &Vector3<f64>, dr: &Vector3<f64>, strained: bool) -> (Matrix6<f64>, Vector6<f64>) {
        let length = self.length.max(f64::MIN_POSITIVE);
        let (n, r) = (self.along, self.arm);
        let across = (Matrix3::identity() - n * n.transpose()) / length;
        let (dn, dl) = (across * pull, n.dot(pull));
        let d_across = -(dn * n.transpose() + n * dn.transpose()) / length - across * (dl / length);
        let (arm, d_arm) = (r.cross_matrix(), dr.cross_matrix());
        let mut curvature = Matrix6::zeros();
        let mixed = -(d_across * arm + across * d_arm);
        let bow = 0.5 * (dn * r.transpose() + n * dr.transpose() + dr * n.transpose() + r * dn.transpose())
            - Matrix3::identity() * (dn.dot(&r) + n.dot(dr));
        let turned =
            d_arm.transpose() * across * arm + arm.transpose() * d_across * arm + arm.transpose() * across * d_arm;
        curvature.fixed_view_mut::<3, 3>(0, 0).copy_from(&d_across);
        curvature.fixed_view_mut::<3, 3>(0, 3).copy_from(&mixed);
        curvature.fixed_view_mut::<3, 3>(3, 0).copy_from(&mixed.transpose());
        curvature.fixed_view_mut::<3, 3>(3, 3).copy_from(&(turned + bow));
        let gradient = self.gradient();
        let turn = dr.cross(&n) + r.cross(&dn);
        let d_gradient = Vector6::new(dn.x, dn.y, dn.z, turn.x, turn.y, turn.z);
        let d_tension = if strained { self.rate * dl } else { 0.0 };
        let stiffness = (d_gradient * gradient.transpose() + gradient * d_gradient.transpose()) * self.rate
            + curvature * self.tension
            + self.curvature() * d_tension;
        let load = if self.loads { -d_gradient * self.tension - gradient * d_tension } else { Vector6::zeros() };
        (stiffness, load)
    }
}
