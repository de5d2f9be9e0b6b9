//! Springs and gravity compensators between points of two bodies.
//!
//! The relative motion of the two bodies is a twist about the joint between them; the spring's force and its tangent
//! stiffness, tension included, are first and second derivatives of its energy K (s - s0)^2 / 2 by that twist. About a
//! single joint this is eq. (10), (11) of the KR-270 paper.

use nalgebra::{IsometryMatrix3, Matrix3, Matrix6, Point3, Rotation3, Vector3, Vector6};

use super::element::{
    Configuration, Direction, ElasticElement, Frames, Held, MotionRate, ParameterUse, Placed, Rate, VertexIndex,
    VertexMotion,
};
use super::flexibility::Flexibility;
use super::per_length::PerLength;
use crate::description::elastic;
use crate::description::raw::SpringAction;
use crate::description::robot::FrameIndex;
use crate::math::{left_jacobian, rotation_vector};
use crate::parameter::Slot;

/// A spring between points of two bodies.
#[derive(Debug, Clone, PartialEq)]
pub struct Spring {
    /// Its declaration.
    pub spring: elastic::Spring,
    /// Slots of stiffness, free length and the two anchors (x1 y1 z1 x2 y2 z2).
    pub slots: [Slot; 8],
    /// Frame about whose origin the relative motion of the bodies is counted.
    pub pivot: FrameIndex,
}

/// A spring at a placed configuration, base axes.
#[derive(Debug, Clone, Copy)]
pub struct SpringState {
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

impl Spring {
    /// Whether its tension follows its length.
    fn is_strained(&self) -> bool {
        self.spring.free_length.is_some()
    }

    fn rate(&self, values: &[f64]) -> f64 {
        values[self.slots[0]]
    }

    /// The spring between the anchors as they have deflected; `state` with nothing deflected.
    fn deflected(&self, state: &SpringState, at: &Configuration, [first, second]: [VertexIndex; 2]) -> SpringState {
        let b = state.pivot + state.arm;
        let a = at.carried(first, &(b - state.along * state.length));
        let b = at.carried(second, &b);
        let pivot = at.carried(first, &state.pivot);
        let length = (b - a).norm();
        SpringState {
            pivot,
            arm: b - pivot,
            along: (b - a) / length.max(f64::MIN_POSITIVE),
            length,
            tension: state.tension + state.rate * (length - state.length),
            ..*state
        }
    }
}

/// A load on the second body that is dead in the exponential coordinates of its motion against the first, `wrench` with
/// nothing deflected: its force and its moment about the pivot turn along with the first body, and the moment as the
/// coordinates do, `m = J^-T m_0` with J the left Jacobian of the relative turn. Against it the stiffness of
/// [`SpringState::stiffness`] is the exact derivative.
fn carried(
    wrench: &Vector6<f64>,
    state: &SpringState,
    at: &Configuration,
    [first, second]: [VertexIndex; 2],
) -> Vector6<f64> {
    let turned = at.turned(first);
    let relative = Rotation3::from_matrix_unchecked(turned.transpose() * at.turned(second));
    let shift = at.carried(second, &state.pivot) - at.carried(first, &state.pivot);
    let force = turned * wrench.fixed_rows::<3>(0);
    let by_turn = left_jacobian(&rotation_vector(&relative)).transpose();
    let moment = by_turn.try_inverse().unwrap_or_else(Matrix3::identity) * wrench.fixed_rows::<3>(3);
    let moment = turned * moment + shift.cross(&force);
    Vector6::new(force.x, force.y, force.z, moment.x, moment.y, moment.z)
}

impl ElasticElement for Spring {
    fn directions(&self) -> [Direction; 6] {
        [Direction::Sprung; 6]
    }

    fn parameters(&self) -> Vec<ParameterUse> {
        self.slots.iter().enumerate().map(|(part, &slot)| ParameterUse { slot, part }).collect()
    }

    fn is_active(&self, values: &[f64]) -> bool {
        self.rate(values) != 0.0
    }

    fn is_preloaded(&self) -> bool {
        self.spring.acts == SpringAction::Full && self.is_strained()
    }

    fn place(&self, at: &Configuration, [first, _]: [VertexIndex; 2], _: &PerLength) -> Placed {
        let pivot = at.carried(first, &at.frames[self.pivot].translation.vector);
        Placed::new(&Matrix3::identity(), &pivot, Flexibility::Rigid)
    }

    fn pivot(&self, _: &Frames, _: &[Vector3<f64>], _: [VertexIndex; 2]) -> Option<Vector3<f64>> {
        None
    }

    fn held(&self, at: &Configuration, ends: [VertexIndex; 2]) -> Held {
        let state = SpringState::new(self, at.values, at.frames);
        if at.deflected.is_none() {
            return Held { stiffness: state.stiffness(), preload: state.wrench() };
        }
        Held {
            stiffness: self.deflected(&state, at, ends).stiffness(),
            preload: carried(&state.wrench(), &state, at, ends),
        }
    }

    fn drawn(&self, at: &Configuration, ends: [VertexIndex; 2]) -> Vector6<f64> {
        if at.deflected.is_none() {
            return Vector6::zeros();
        }
        let before = SpringState { loads: true, ..SpringState::new(self, at.values, at.frames) };
        let now = self.deflected(&before, at, ends);
        now.wrench() - carried(&before.wrench(), &before, at, ends)
    }

    fn by_parameter(&self, part: usize, at: &Configuration) -> Rate {
        let state = SpringState::new(self, at.values, at.frames);
        Rate::Held(if part < 2 {
            state.by_rate_and_length()[part]
        } else {
            let anchor = (part - 2) / 3;
            let frame: &IsometryMatrix3<f64> = &at.frames[self.spring.bodies[anchor]];
            let step = frame.rotation.matrix().column((part - 2) % 3).into_owned();
            state.by_anchor(anchor, &step, self.is_strained())
        })
    }

    fn by_motion(&self, at: &Configuration, _: [VertexIndex; 2], moves: &VertexMotion) -> MotionRate {
        let state = SpringState::new(self, at.values, at.frames);
        let b = state.pivot + state.arm;
        let a = b - state.along * state.length;
        let [moved_a, moved_b] = [(0, a), (1, b)].map(|(k, anchor)| moves.point(self.spring.bodies[k], &anchor).0);
        let pivot = moves.point(self.pivot, &state.pivot).0;
        let held = state.by_motion(&(moved_b - moved_a), &(moved_b - pivot), self.is_strained());
        MotionRate { rate: Rate::Held(held), ..MotionRate::of(&state.pivot, pivot, Vector3::zeros()) }
    }
}

impl SpringState {
    /// The spring at a configuration.
    pub fn new(of: &Spring, values: &[f64], frames: &Frames) -> Self {
        let anchor = |k: usize| {
            let [x, y, z] = [0, 1, 2].map(|axis| values[of.slots[2 + 3 * k + axis]]);
            (frames[of.spring.bodies[k]] * Point3::new(x, y, z)).coords
        };
        let (a, b) = (anchor(0), anchor(1));
        let pivot = frames[of.pivot].translation.vector;
        let length = (b - a).norm();
        let rate = of.rate(values);
        let stretch = if of.is_strained() { length - values[of.slots[1]] } else { 0.0 };
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
    fn by_rate_and_length(&self) -> [Held; 2] {
        let (gradient, curvature) = (self.gradient(), self.curvature());
        let stretch = if self.rate == 0.0 { 0.0 } else { self.tension / self.rate };
        let load = |by: f64| if self.loads { -gradient * by } else { Vector6::zeros() };
        [
            Held { stiffness: gradient * gradient.transpose() + curvature * stretch, preload: load(stretch) },
            Held { stiffness: curvature * -self.rate, preload: load(-self.rate) },
        ]
    }

    /// Derivatives of stiffness and wrench by moving an anchor (0 on the first body, 1 on the second) along `step`
    /// (base axes); `strained` where the tension follows the length.
    fn by_anchor(&self, anchor: usize, step: &Vector3<f64>, strained: bool) -> Held {
        if anchor == 0 {
            self.by_motion(&-step, &Vector3::zeros(), strained)
        } else {
            self.by_motion(step, step, strained)
        }
    }

    /// The same by moving the second anchor against the first by `pull`, and against the pivot by `dr`.
    fn by_motion(&self, pull: &Vector3<f64>, dr: &Vector3<f64>, strained: bool) -> Held {
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
        let preload = if self.loads { -d_gradient * self.tension - gradient * d_tension } else { Vector6::zeros() };
        Held { stiffness, preload }
    }
}
