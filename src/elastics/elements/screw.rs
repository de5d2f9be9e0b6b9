//! Ball screw or cylinder: an axial spring between two pins, or lumped at the joint that it drives.
//!
//! Source: IR663 calibration paper, Fig. A.19 (prismatic joint between two pins); the lumped form k_axial (dr/dtheta)^2
//! follows from its slider-crank law.

use nalgebra::{Matrix3, Vector3};

use crate::kinematics::Placements;
use crate::model::{Model, ScrewElement, screw_pins};

/// How much the screw's length changes per turn of its joint, m/rad: the lever arm of its force.
pub fn lever(model: &Model, values: &[f64], actuator: usize, joints: &[f64]) -> f64 {
    let screw = &model.actuators[actuator];
    let [_, kappa, lambda, l1, l3] = std::array::from_fn(|k| values[screw.slot + k]);
    let frame = &model.frames[screw.joint];
    let zero = values[frame.moving_slot()] - frame.home;
    let angle = kappa + lambda - (joints[screw.joint] - zero);
    let length = (l1 * l1 + l3 * l3 + 2.0 * l1 * l3 * angle.cos()).max(0.0).sqrt();
    l1 * l3 * angle.sin() / length.max(f64::MIN_POSITIVE)
}

/// Derivative of lever^2 by the joint's angle.
pub fn square_by_joint(model: &Model, values: &[f64], actuator: usize, joints: &[f64]) -> f64 {
    let screw = &model.actuators[actuator];
    let [_, kappa, lambda, l1, l3] = std::array::from_fn(|k| values[screw.slot + k]);
    let frame = &model.frames[screw.joint];
    let zero = values[frame.moving_slot()] - frame.home;
    let angle = kappa + lambda - (joints[screw.joint] - zero);
    let length = (l1 * l1 + l3 * l3 + 2.0 * l1 * l3 * angle.cos()).max(f64::MIN_POSITIVE).sqrt();
    let lever = l1 * l3 * angle.sin() / length;
    -2.0 * lever * (l1 * l3 * angle.cos() / length + lever * lever / length)
}

/// Derivative of 1 / lever^2 by the joint's angle.
pub fn inverse_square_by_joint(model: &Model, values: &[f64], actuator: usize, joints: &[f64]) -> f64 {
    let lever = lever(model, values, actuator, joints);
    -square_by_joint(model, values, actuator, joints) / lever.powi(4)
}

/// Axes (x along the screw, from the antecedent's pin to the moving one) and the moving pin, base frame.
pub fn axes(model: &Model, values: &[f64], placements: &Placements, of: &ScrewElement) -> (Matrix3<f64>, Vector3<f64>) {
    let screw = &model.actuators[of.actuator];
    let frame = &placements.frames[screw.joint];
    let [fixed, moving] = screw_pins(&values[screw.slot..screw.slot + 5], placements.joints[screw.joint]);
    let (from, to) = (frame * nalgebra::Point3::from(fixed), frame * nalgebra::Point3::from(moving));
    let z = frame.rotation.matrix().column(2).into_owned();
    (super::beam::axes(&from.coords, &to.coords, &z).0, to.coords)
}

/// Compliance along the screw: its own, and its joint's seen through the lever.
pub fn compliance(model: &Model, values: &[f64], joints: &[f64], of: &ScrewElement) -> f64 {
    values[of.axial] + values[of.own] * lever(model, values, of.actuator, joints).powi(2)
}
