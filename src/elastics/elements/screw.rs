//! Ball screw or cylinder: an axial spring between two pins, or lumped at the joint that it drives.
//!
//! Source: IR663 calibration paper, Fig. A.19 (prismatic joint between two pins); the lumped form k_axial (dr/dtheta)^2
//! follows from its slider-crank law.

use nalgebra::{Matrix3, Vector3};
use num_dual::{Dual64, DualNum};

use crate::kinematics::Placements;
use crate::model::{Model, ScrewElement, screw_pins};
use crate::parameter::Slot;

/// What a screw's triangle is made of: kappa, lambda, l1, l3, and the angle of its joint counted as its law counts it,
/// without the joint's zero.
fn triangle(model: &Model, values: &[f64], actuator: usize, joints: &[f64]) -> [f64; 5] {
    let screw = &model.actuators[actuator];
    let frame = &model.frames[screw.joint];
    let zero = values[frame.moving_slot()] - frame.home;
    let [_, kappa, lambda, l1, l3] = std::array::from_fn(|k| values[screw.slot + k]);
    [kappa, lambda, l1, l3, joints[screw.joint] - zero]
}

/// How the triangle changes with a slot (none: a variable) that turns the joint at `rate`.
pub fn triangle_rate(model: &Model, actuator: usize, by: Option<Slot>, rate: f64) -> [f64; 5] {
    let screw = &model.actuators[actuator];
    let unit = |slot: Slot| f64::from(u8::from(by == Some(slot)));
    let own = |k: usize| unit(screw.slot + k);
    [own(1), own(2), own(3), own(4), rate - unit(model.frames[screw.joint].moving_slot())]
}

fn lever_of<D: DualNum<Primitive = f64> + Copy>([kappa, lambda, l1, l3, turn]: [D; 5]) -> D {
    let angle = kappa + lambda - turn;
    let square = l1 * l1 + l3 * l3 + l1 * l3 * angle.cos() * 2.0;
    l1 * l3 * angle.sin() / if square.re() > 0.0 { square.sqrt() } else { D::from(f64::MIN_POSITIVE) }
}

/// How much the screw's length changes per turn of its joint, m/rad: the lever arm of its force.
pub fn lever(model: &Model, values: &[f64], actuator: usize, joints: &[f64]) -> f64 {
    lever_of(triangle(model, values, actuator, joints))
}

/// Derivative of the lever by what changes the triangle at `rate`.
pub fn lever_rate(model: &Model, values: &[f64], actuator: usize, joints: &[f64], rate: &[f64; 5]) -> f64 {
    let of = triangle(model, values, actuator, joints);
    lever_of(std::array::from_fn(|k| Dual64::new(of[k], rate[k]))).eps
}

/// The pins on the antecedent and on the moving body, in the joint's frame.
pub fn pins(model: &Model, values: &[f64], actuator: usize, joints: &[f64]) -> [Vector3<f64>; 2] {
    let slot = model.actuators[actuator].slot;
    screw_pins(&values[slot..slot + 5], triangle(model, values, actuator, joints)[4])
}

/// How the pins move in the joint's frame.
pub fn pins_rate(model: &Model, values: &[f64], actuator: usize, joints: &[f64], rate: &[f64; 5]) -> [Vector3<f64>; 2] {
    let of = pins(model, values, actuator, joints);
    let along = |pin: &Vector3<f64>| pin / pin.norm().max(f64::MIN_POSITIVE);
    let about = |pin: &Vector3<f64>, turn: f64| Vector3::new(-pin.y, pin.x, 0.0) * turn;
    [along(&of[0]) * rate[3] + about(&of[0], rate[1] - rate[4]), along(&of[1]) * rate[2] + about(&of[1], -rate[0])]
}

/// Axes (x along the screw, from the antecedent's pin to the moving one) and the moving pin, base frame.
pub fn axes(model: &Model, values: &[f64], placements: &Placements, of: &ScrewElement) -> (Matrix3<f64>, Vector3<f64>) {
    let frame = &placements.frames[model.actuators[of.actuator].joint];
    let [from, to] =
        pins(model, values, of.actuator, &placements.joints).map(|pin| (frame * nalgebra::Point3::from(pin)).coords);
    let z = frame.rotation.matrix().column(2).into_owned();
    (super::beam::axes(&from, &to, &z).0, to)
}

/// Compliance along the screw: its own, and its joint's seen through the lever.
pub fn compliance(model: &Model, values: &[f64], joints: &[f64], of: &ScrewElement) -> f64 {
    values[of.axial] + values[of.own] * lever(model, values, of.actuator, joints).powi(2)
}
