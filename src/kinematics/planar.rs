//! Closure of a loop in the plane normal to its parallel axes.
//!
//! In the plane only gamma, d and theta count past the first frame of each branch; the first frames' constants place
//! the ground link. Out-of-plane errors (alpha, beta, r) thus leave the closure alone, as in the printed four-bar.

use nalgebra::Rotation3;

use super::constants::{Constants, FrameConstants};
use super::linearisation::{Column, Linearisation};
use super::transform::Transform;
use crate::description::raw::Meet;
use crate::description::robot::FrameIndex;
use crate::model::{LoopPlan, THETA};
use crate::parameter::Slot;

/// GroundLink link of a planar loop: pose of the second branch's first axis in the first one's plane, with derivatives.
#[derive(Debug, Clone)]
pub struct GroundLink {
    x: f64,
    y: f64,
    heading: f64,
    sense: f64,
    by: Vec<(Slot, Column)>,
}

impl GroundLink {
    pub fn new(constants: &Constants, plan: &LoopPlan) -> Self {
        let first = |side: usize| plan.branches[side].first().map(|&frame| (frame, &constants.frames[frame]));
        let (a, b) = (first(0), first(1));
        let shared = match (a, b) {
            (Some((a, _)), Some((b, _))) => {
                constants.model.frames[a].slots[..THETA] == constants.model.frames[b].slots[..THETA]
            }
            _ => false,
        };
        // The transforms without the parts of theta and r, which the branches add themselves.
        let bare = |side: Option<(FrameIndex, &FrameConstants)>| match side {
            None => Transform::identity(),
            Some((frame, constant)) => {
                let alpha = constants.value(constants.model.frames[frame].slots[3]);
                let d = constants.value(constants.model.frames[frame].slots[4]);
                let y1 = constant.z1.cross(&constant.x1);
                let turned =
                    Rotation3::from_matrix_unchecked(nalgebra::Matrix3::from_columns(&[constant.x1, y1, constant.z1]));
                let rotation = turned * Rotation3::from_axis_angle(&nalgebra::Vector3::x_axis(), alpha);
                Transform::from_parts((constant.foot + constant.x1 * d).into(), rotation)
            }
        };
        let (ta, tb) = (bare(a), bare(b));
        let ground = ta.inv_mul(&tb);
        let r = ground.rotation.matrix();
        let (x, y) = (ground.translation.x, ground.translation.y);
        let mut by = Vec::new();
        if !shared {
            for (side, sign) in [(a, -1.0), (b, 1.0)] {
                let Some((frame, constant)) = side else { continue };
                let slots = constants.model.frames[frame].slots;
                let twists = constant.twists();
                for (slot, (axis, point, turns)) in slots.into_iter().zip(twists) {
                    let (w, v) = if turns {
                        (axis, axis.cross(&(tb.translation.vector - point)))
                    } else {
                        (nalgebra::Vector3::zeros(), axis)
                    };
                    let (w, v) = (ta.rotation.inverse() * w * sign, ta.rotation.inverse() * v * sign);
                    by.push((slot, [v.x, v.y, w.z, 0.0, 0.0, 0.0]));
                }
            }
        }
        Self { x, y, heading: r[(1, 0)].atan2(r[(0, 0)]), sense: r[(2, 2)].signum(), by }
    }
}

/// A point of the walk along a branch.
#[derive(Clone, Copy)]
struct Pose {
    x: f64,
    y: f64,
    heading: f64,
    sense: f64,
}

/// Residual (x, y, heading of the first branch's end less the second's) and, if asked, its derivatives.
pub fn linearise(
    constants: &Constants,
    plan: &LoopPlan,
    ground: &GroundLink,
    joints: &[f64],
    slots: bool,
    out: &mut Linearisation,
) {
    let start = [
        Pose { x: 0.0, y: 0.0, heading: 0.0, sense: 1.0 },
        Pose { x: ground.x, y: ground.y, heading: ground.heading, sense: ground.sense },
    ];
    let mut ends = start;
    for side in 0..2 {
        let sign = if side == 0 { 1.0 } else { -1.0 };
        let first_column = out.joints.len();
        let first_slot = out.slots.len();
        let walk = Walk { constants, joints, sign, slots };
        let mut pose = start[side];
        for (position, &frame) in plan.branches[side].iter().enumerate() {
            pose = walk.past(frame, position > 0, pose, out);
        }
        ends[side] = pose;
        // A turn about a point carries the end round it; the column so far holds the point and the sense.
        for (_, column) in out.joints[first_column..].iter_mut() {
            finish(column, pose);
        }
        for (_, column) in out.slots[first_slot..].iter_mut() {
            finish(column, pose);
        }
        if side == 1 && slots {
            // The ground link carries the whole second branch.
            for (slot, by) in &ground.by {
                let (rx, ry) = (pose.x - ground.x, pose.y - ground.y);
                out.slots.push((*slot, [-(by[0] - by[2] * ry), -(by[1] + by[2] * rx), -by[2], 0.0, 0.0, 0.0]));
            }
        }
    }
    let [a, b] = ends;
    out.residual = [a.x - b.x, a.y - b.y, wrap(a.heading - b.heading), 0.0, 0.0, 0.0];
    out.rows = if plan.meet == Meet::Frame { 3 } else { 2 };
}

/// A walk along a branch.
struct Walk<'a> {
    constants: &'a Constants<'a>,
    joints: &'a [f64],
    /// Of the branch in the residual.
    sign: f64,
    /// Whether derivatives by constants are asked for.
    slots: bool,
}

impl Walk<'_> {
    /// Past a frame, whose constants of the plane count where it `is_placed`: unless it is the first; with what turns and shifts
    /// the rest of the branch there.
    fn past(&self, frame: FrameIndex, is_placed: bool, mut pose: Pose, out: &mut Linearisation) -> Pose {
        let model_frame = &self.constants.model.frames[frame];
        if is_placed {
            if self.slots {
                out.slots.push((model_frame.slots[1], turn(pose, self.sign)));
            }
            pose.heading += pose.sense * self.constants.value(model_frame.slots[1]);
            let (sine, cosine) = pose.heading.sin_cos();
            let d = self.constants.value(model_frame.slots[4]);
            pose.x += d * cosine;
            pose.y += d * sine;
            if self.slots {
                out.slots.push((model_frame.slots[4], [self.sign * cosine, self.sign * sine, 0.0, 0.0, 0.0, 0.0]));
            }
            if self.constants.value(model_frame.slots[3]).cos() < 0.0 {
                pose.sense = -pose.sense;
            }
        }
        if model_frame.moves() {
            out.joints.push((frame, turn(pose, self.sign)));
            pose.heading += pose.sense * self.constants.full(frame, self.joints[frame]);
        } else {
            if self.slots {
                out.slots.push((model_frame.slots[THETA], turn(pose, self.sign)));
            }
            pose.heading += pose.sense * self.constants.value(model_frame.slots[THETA]);
        }
        pose
    }
}

/// A turn about `pose`: its point and signed sense, to be finished when the branch's end is known, and its sign, which marks it.
fn turn(pose: Pose, sign: f64) -> Column {
    [pose.x, pose.y, sign * pose.sense, sign, 0.0, 0.0]
}

fn finish(column: &mut Column, end: Pose) {
    if column[3] == 0.0 {
        return; // a translation
    }
    let rate = column[2];
    *column = [-rate * (end.y - column[1]), rate * (end.x - column[0]), rate, 0.0, 0.0, 0.0];
}

fn wrap(angle: f64) -> f64 {
    let turn = std::f64::consts::TAU;
    angle - turn * (angle / turn).round()
}
