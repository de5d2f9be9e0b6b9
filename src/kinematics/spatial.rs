//! Closure of a loop in space.

use nalgebra::Vector3;

use super::constants::Constants;
use super::linearisation::Linearisation;
use super::transform::{Transform, rotation_vector};
use crate::description::raw::{JointKind, Meet};
use crate::model::{LoopPlan, R, THETA};

/// Residual (position, and rotation vector, of the first branch's end against the second's, in the axes of the common
/// ancestor) and its derivatives.
pub fn linearise(constants: &Constants, plan: &LoopPlan, joints: &[f64], slots: bool, out: &mut Linearisation) {
    let mut ends = [Transform::identity(); 2];
    for (side, reached) in ends.iter_mut().enumerate() {
        let sign = if side == 0 { 1.0 } else { -1.0 };
        let (first_column, first_slot) = (out.joints.len(), out.slots.len());
        let mut pose = Transform::identity();
        for &frame in &plan.branches[side] {
            let model_frame = &constants.model.frames[frame];
            let constant = &constants.frames[frame];
            if slots {
                for (slot, (axis, point, turns)) in model_frame.slots.into_iter().zip(constant.twists()) {
                    out.slots.push((
                        slot,
                        line(pose.rotation * axis, (pose * nalgebra::Point3::from(point)).coords, turns, sign),
                    ));
                }
            }
            pose *= constant.transform;
            let mut z = pose.rotation * Vector3::z();
            match model_frame.joint {
                JointKind::Revolute => {
                    pose.translation.vector += z * constant.r;
                    out.joints.push((frame, line(z, pose.translation.vector, true, sign)));
                    let angle = constants.full(frame, joints[frame]);
                    pose.rotation *= nalgebra::Rotation3::from_axis_angle(&Vector3::z_axis(), angle);
                    if slots {
                        out.slots.push((model_frame.slots[R], line(z, pose.translation.vector, false, sign)));
                    }
                }
                JointKind::Prismatic => {
                    if slots {
                        out.slots.push((model_frame.slots[THETA], line(z, pose.translation.vector, true, sign)));
                    }
                    out.joints.push((frame, line(z, pose.translation.vector, false, sign)));
                    pose.translation.vector += z * constants.full(frame, joints[frame]);
                }
                JointKind::Fixed => {
                    z = pose.rotation * Vector3::z();
                    if slots {
                        out.slots.push((model_frame.slots[THETA], line(z, pose.translation.vector, true, sign)));
                        out.slots.push((model_frame.slots[R], line(z, pose.translation.vector, false, sign)));
                    }
                }
            }
        }
        *reached = pose;
        let end = pose.translation.vector;
        for (_, column) in out.joints[first_column..].iter_mut() {
            finish(column, &end);
        }
        for (_, column) in out.slots[first_slot..].iter_mut() {
            finish(column, &end);
        }
    }
    let gap = ends[0].translation.vector - ends[1].translation.vector;
    let twist = rotation_vector(&(ends[0].rotation * ends[1].rotation.inverse()));
    out.residual = [gap.x, gap.y, gap.z, twist.x, twist.y, twist.z];
    out.rows = if plan.meet == Meet::Frame { 6 } else { 3 };
}

/// A twist along a line, marked by a point of the line until the branch's end is known: (v or point, w).
/// A translation has w = 0 and is marked by its direction.
fn line(axis: Vector3<f64>, point: Vector3<f64>, turns: bool, sign: f64) -> [f64; 6] {
    let axis = axis * sign;
    if turns { [point.x, point.y, point.z, axis.x, axis.y, axis.z] } else { [axis.x, axis.y, axis.z, 0.0, 0.0, 0.0] }
}

fn finish(column: &mut [f64; 6], end: &Vector3<f64>) {
    let w = Vector3::new(column[3], column[4], column[5]);
    if w != Vector3::zeros() {
        let v = w.cross(&(end - Vector3::new(column[0], column[1], column[2])));
        column[..3].copy_from_slice(v.as_slice());
    }
}
