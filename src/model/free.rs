//! Which geometric parameters calibration frees, by rule: a robot needs no list of its own.

use nalgebra::{Rotation3, Vector3};

use super::Model;
use crate::description::parameters::Owner;
use crate::description::raw::{JointKind, LoopKind};
use crate::description::robot::{FrameIndex, Motion, NEAR_PARALLEL, Robot, branches};
use crate::parameter::Slot;

/// The rule, before `calibration.free` and `calibration.fixed` are applied to it:
///
/// * a frame that carries the tool or a marker: alpha, d, r, and theta if a variable of its own, or a coupling, moves it;
/// * beta as well where its axis is near-parallel to that of the joint before it (Hayati 1983);
/// * a fixed frame only at the end of the chain, without theta (which its joint's zero already gives);
/// * a frame that only closes a planar loop: its length d, where it has one, and the zero of its joint, if a variable of its own
///   or a coupling moves it; one that closes a spatial loop: as above;
/// * a slider-crank: all five of its parameters.
///
/// Pose of the base, tool and markers are added by the campaign. What the data cannot tell apart is found later.
pub fn free_by_rule(model: &Model, robot: &Robot) -> Vec<Slot> {
    let carries = carrying(model);
    let mut in_spatial = vec![false; model.frames.len()];
    let mut in_planar = vec![false; model.frames.len()];
    for closed in &robot.loops {
        for index in branches(&robot.frames, closed.frames[0], closed.frames[1]).concat() {
            match closed.kind {
                LoopKind::Planar => in_planar[index] = true,
                LoopKind::Spatial => in_spatial[index] = true,
            }
        }
    }
    let mut free = Vec::new();
    for (index, frame) in model.frames.iter().enumerate().skip(1) {
        let named = |symbol: &str| model.registry.slot(&Owner::Frame(&frame.name).parameter(symbol));
        let mut symbols: Vec<&str> = Vec::new();
        let is_end = !robot.frames.iter().skip(1).any(|other| other.antecedent == index);
        if carries[index] || in_spatial[index] {
            if frame.moves() || is_end {
                if near_parallel(robot, index) {
                    symbols.push("beta");
                }
                symbols.extend(["alpha", "d"]);
                if is_driven(frame.motion) && frame.joint == JointKind::Revolute || frame.joint == JointKind::Prismatic
                {
                    symbols.push("theta");
                }
                symbols.push("r");
            }
        } else if in_planar[index] {
            if robot.frames[index].constants.d != 0.0 {
                symbols.push("d");
            }
            if is_driven(frame.motion) {
                symbols.push("theta");
            }
        }
        // Constants shared with a coaxial frame have no name of this frame's and are skipped.
        free.extend(symbols.into_iter().filter_map(named));
        if let Motion::Actuator(which) = frame.motion
            && let Some(actuator) = model.actuators.get(which)
        {
            free.extend(actuator.slot..actuator.slot + 5);
        }
    }
    for name in &robot.calibration.free {
        free.extend(model.registry.slot(name));
    }
    free.retain(|&slot| !robot.calibration.fixed.contains(&model.registry[slot].name));
    free.sort_unstable();
    free.dedup();
    free
}

/// Whether a joint has a zero of its own: that of its encoder, or the angle at which it was coupled to others.
fn is_driven(motion: Motion) -> bool {
    matches!(motion, Motion::Variable { .. } | Motion::Coupling(_))
}

/// Which frames carry the tool or a marker.
fn carrying(model: &Model) -> Vec<bool> {
    let mut carries = vec![false; model.frames.len()];
    let ends = std::iter::once(model.tool.0).chain(model.markers.iter().map(|marker| marker.frame));
    for end in ends {
        for index in model.path(end) {
            carries[index] = true;
        }
    }
    carries
}

/// Constants of frames that only close a loop, but for the zeros of joints that a variable of their own moves.
pub fn closing_lengths(model: &Model, robot: &Robot) -> Vec<Slot> {
    let carries = carrying(model);
    let members =
        robot.loops.iter().flat_map(|closed| branches(&robot.frames, closed.frames[0], closed.frames[1]).concat());
    members
        .filter(|&index| !carries[index] && robot.frames[index].coaxial.is_none())
        .flat_map(|index| {
            let frame = &model.frames[index];
            let zero = is_driven(frame.motion).then(|| frame.moving_slot());
            frame.slots.into_iter().filter(move |slot| Some(*slot) != zero)
        })
        .collect()
}

/// Whether the frame's z axis is near-parallel to that of the last joint before it, at nominal values and joints zero.
fn near_parallel(robot: &Robot, index: FrameIndex) -> bool {
    let mut axis = robot.frames[index].constants.before_joint() * Vector3::z();
    let mut above = robot.frames[index].antecedent;
    while above != 0 && robot.frames[above].joint == JointKind::Fixed {
        let constants = &robot.frames[above].constants;
        axis = constants.before_joint() * Rotation3::from_axis_angle(&Vector3::z_axis(), constants.theta) * axis;
        above = robot.frames[above].antecedent;
    }
    above != 0 && axis.xy().norm() < NEAR_PARALLEL
}
