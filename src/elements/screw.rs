//! Ball screw or cylinder: an axial spring between two pins, or lumped at the joint that it drives.
//!
//! Source: IR663 calibration paper, Fig. A.19 (prismatic joint between two pins); the lumped form k_axial (dr/dtheta)^2
//! follows from its slider-crank law.

use nalgebra::{Matrix3, Point3, Vector3};
use num_dual::{Dual64, DualNum};

use super::element::{
    Configuration, Direction, ElasticElement, Frames, Motion, MotionRate, ParameterUse, Placed, Rate, VertexIndex,
    VertexMotion,
};
use super::flexibility::Flexibility;
use super::per_length::PerLength;
use crate::description::robot::FrameIndex;
use crate::parameter::Slot;

/// A screw that holds its joint through two pins.
#[derive(Debug, Clone, PartialEq)]
pub struct Screw {
    /// Its triangle with the joint.
    pub triangle: ScrewTriangle,
    /// The joint's own compliance, in series.
    pub own: Slot,
    /// Axial compliance.
    pub axial: Slot,
}

/// The slider-crank of a screw and the joint that it turns.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScrewTriangle {
    /// Joint turned.
    pub joint: FrameIndex,
    /// First of the slots of stroke, kappa, lambda, l1, l3.
    pub slot: Slot,
    /// Slot of the joint's moving coordinate.
    pub moving: Slot,
    /// Declared constant of that coordinate: its value less this is the joint's zero.
    pub home: f64,
}

impl ScrewTriangle {
    /// kappa, lambda, l1, l3, and the angle of the joint as the slider-crank's law counts it, without the joint's zero.
    fn sides(&self, values: &[f64], joints: &[f64]) -> [f64; 5] {
        let zero = values[self.moving] - self.home;
        let [_, kappa, lambda, l1, l3] = std::array::from_fn(|k| values[self.slot + k]);
        [kappa, lambda, l1, l3, joints[self.joint] - zero]
    }

    /// How the sides change with a motion.
    fn sides_rate(&self, motion: &Motion) -> [f64; 5] {
        let unit = |slot: Slot| f64::from(u8::from(motion.by == Some(slot)));
        let own = |k: usize| unit(self.slot + k);
        [own(1), own(2), own(3), own(4), (motion.joints)(self.joint) - unit(self.moving)]
    }

    /// How much the screw's length changes per turn of its joint, m/rad: the lever arm of its force.
    pub fn lever(&self, values: &[f64], joints: &[f64]) -> f64 {
        lever(self.sides(values, joints))
    }

    /// The lever, and its derivative by a motion.
    pub fn lever_rate(&self, at: &Configuration, motion: &Motion) -> [f64; 2] {
        let (sides, rate) = (self.sides(at.values, at.joints), self.sides_rate(motion));
        let found = lever(std::array::from_fn::<_, 5, _>(|k| Dual64::new(sides[k], rate[k])));
        [found.re, found.eps]
    }

    /// The pins on the antecedent and on the moving body, in the joint's frame.
    fn pins(&self, values: &[f64], joints: &[f64]) -> [Vector3<f64>; 2] {
        screw_pins(&values[self.slot..self.slot + 5], self.sides(values, joints)[4])
    }

    /// How the pins move in the joint's frame.
    fn pins_rate(&self, of: &[Vector3<f64>; 2], motion: &Motion) -> [Vector3<f64>; 2] {
        let rate = self.sides_rate(motion);
        let along = |pin: &Vector3<f64>| pin / pin.norm().max(f64::MIN_POSITIVE);
        let about = |pin: &Vector3<f64>, turn: f64| Vector3::new(-pin.y, pin.x, 0.0) * turn;
        [along(&of[0]) * rate[3] + about(&of[0], rate[1] - rate[4]), along(&of[1]) * rate[2] + about(&of[1], -rate[0])]
    }
}

fn lever<D: DualNum<Primitive = f64> + Copy>([kappa, lambda, l1, l3, turn]: [D; 5]) -> D {
    let angle = kappa + lambda - turn;
    let square = l1 * l1 + l3 * l3 + l1 * l3 * angle.cos() * 2.0;
    l1 * l3 * angle.sin() / if square.re() > 0.0 { square.sqrt() } else { D::from(f64::MIN_POSITIVE) }
}

/// Pins of a slider-crank in the frame of its joint, at joint value `joint` (rad): the one on the antecedent body, the
/// one on the moving body, m. `values` are stroke, kappa, lambda, l1, l3.
///
/// Neither paper draws where kappa and lambda are counted from, only their sum enters the stroke: here the moving pin
/// lies at -kappa from the frame's x axis, the other at lambda - 180 deg from where that axis is at joint value zero.
pub fn screw_pins(values: &[f64], joint: f64) -> [Vector3<f64>; 2] {
    let at = |length: f64, angle: f64| Vector3::new(length * angle.cos(), length * angle.sin(), 0.0);
    [at(values[4], values[2] - std::f64::consts::PI - joint), at(values[3], -values[1])]
}

/// Parts: the axial compliance, the joint's own.
const AXIAL: usize = 0;
const OWN: usize = 1;

impl Screw {
    /// Axes (x along the screw, from the antecedent's pin to the moving one) and the moving pin, base frame.
    fn axes(&self, values: &[f64], frames: &Frames, joints: &[f64]) -> (Matrix3<f64>, Vector3<f64>) {
        let frame = &frames[self.triangle.joint];
        let [from, to] = self.triangle.pins(values, joints).map(|pin| (frame * Point3::from(pin)).coords);
        let z = frame.rotation.matrix().column(2).into_owned();
        (super::beam::axes(&from, &to, &z).0, to)
    }
}

impl ElasticElement for Screw {
    fn directions(&self) -> [Direction; 6] {
        // Pins carry nothing but the force along the screw.
        let mut all = [Direction::Released(None); 6];
        all[0] = Direction::Flexible;
        all
    }

    fn parameters(&self) -> Vec<ParameterUse> {
        vec![ParameterUse { slot: self.axial, part: AXIAL }, ParameterUse { slot: self.own, part: OWN }]
    }

    fn is_active(&self, _: &[f64]) -> bool {
        true
    }

    fn place(&self, at: &Configuration, _: [VertexIndex; 2], _: &PerLength) -> Placed {
        let (rotation, origin) = self.axes(at.values, at.frames, at.joints);
        let lever = self.triangle.lever(at.values, at.joints);
        let compliance = at.values[self.axial] + at.values[self.own] * lever.powi(2);
        Placed::new(&rotation, &origin, Flexibility::Single(0, compliance))
    }

    fn by_parameter(&self, part: usize, at: &Configuration) -> Rate {
        let rate = if part == OWN { self.triangle.lever(at.values, at.joints).powi(2) } else { 1.0 };
        Rate::Flexibility(Flexibility::Single(0, rate))
    }

    fn by_motion(&self, at: &Configuration, _: [VertexIndex; 2], moves: &VertexMotion) -> MotionRate {
        let joint = self.triangle.joint;
        let frame = &at.frames[joint];
        let pins = self.triangle.pins(at.values, at.joints);
        let [a, b] = pins.map(|pin| (frame * Point3::from(pin)).coords);
        // The pins are laid out in the joint's frame, and move in it.
        let [own_a, own_b] = self.triangle.pins_rate(&pins, moves.motion);
        let (da, db) =
            (moves.point(joint, &a).0 + frame.rotation * own_a, moves.point(joint, &b).0 + frame.rotation * own_b);
        let along = b - a;
        let turn = along.cross(&(db - da)) / along.norm_squared().max(f64::MIN_POSITIVE);
        let mut found = MotionRate::of(&b, db, turn);
        if at.values[self.own] != 0.0 {
            let [lever, rate] = self.triangle.lever_rate(at, moves.motion);
            found.rate = Rate::Flexibility(Flexibility::Single(0, 2.0 * lever * rate * at.values[self.own]));
        }
        found
    }
}
