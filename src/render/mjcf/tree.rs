//! Frames as bodies, with their joints, the springs after them, masses and points.

use std::f64::consts::PI;

use nalgebra::{Point3, Rotation3, Translation3, Vector3};

use super::scale::{TIME, directions, is_held, pedestal};
use super::writer::{Writer, escaped, placed, triple};
use crate::description::elastic::JointStiffness;
use crate::description::frame::{Frame, FrameIndex, Motion};
use crate::description::khalil_kleinfinger::Isometry;
use crate::description::raw::{JointKind, LoopKind};
use crate::description::robot::{Loop, SliderCrank};

/// Radius of gyration where the description says a mass and a centre only, m. Statics do not depend on it.
const GYRATION: f64 = 0.1;

/// Springs along x, y, z and about them, by the index of each in a joint's or the pedestal's list.
const AXES: [&str; 3] = ["1 0 0", "0 1 0", "0 0 1"];

impl Writer<'_> {
    /// A frame, what hangs on it, and points on it.
    pub fn body(&mut self, frame: FrameIndex, depth: usize) {
        let robot = self.robot;
        let own = &robot.frames[frame];
        let name = if frame == 0 { "base".to_string() } else { escaped(&own.name) };
        let at = if frame == 0 { Isometry::identity() } else { self.constants(own) };
        let mut deep = depth;
        if let Motion::Actuator(which) = own.motion
            && let Some(screw) = robot.actuators.get(which)
        {
            // The screw holds the joint before the joint's springs: a body of its own carries its pin.
            self.line(deep, format!("<body name=\"{name}.drive\" {}>", placed(&at)));
            self.joint(frame, own, &name, deep + 1);
            let [_, kappa, _, l1, _] = screw.constants;
            let pin = Vector3::new(l1 * kappa.cos(), -l1 * kappa.sin(), 0.0);
            self.site(&format!("{}.2", escaped(&screw.name)), &pin, deep + 1);
            deep += 1;
            self.line(deep, format!("<body name=\"{name}\">"));
        } else {
            self.line(deep, format!("<body name=\"{name}\" {}>", placed(&at)));
            self.joint(frame, own, &name, deep + 1);
        }
        self.inertia(frame, deep + 1);
        if frame == 0 {
            self.springs("base", &pedestal(robot), Vector3::zeros(), deep + 1);
        }
        for joint in robot.elastic.joints.iter().filter(|joint| frame != 0 && joint.frame == frame) {
            self.springs(&name, &directions(robot, joint), self.place(joint), deep + 1);
        }
        self.sites(frame, deep + 1);
        let children = (1..robot.frames.len()).filter(|&child| robot.frames[child].antecedent == frame);
        children.for_each(|child| self.body(child, deep + 1));
        (depth..=deep).rev().for_each(|depth| self.line(depth, "</body>"));
    }

    fn inertia(&mut self, frame: FrameIndex, depth: usize) {
        let Some(body) = self.robot.elastic.bodies.iter().find(|body| body.frame == frame) else { return };
        if body.mass > 0.0 {
            let (mass, inertia) = (body.mass, body.mass * GYRATION * GYRATION);
            let at = triple(&body.com);
            self.line(
                depth,
                format!("<inertial pos=\"{at}\" mass=\"{mass}\" diaginertia=\"{inertia} {inertia} {inertia}\"/>"),
            );
        }
    }

    fn joint(&mut self, index: FrameIndex, frame: &Frame, name: &str, depth: usize) {
        let kind = match frame.joint {
            _ if index == 0 => return,
            JointKind::Revolute => "hinge",
            JointKind::Prismatic => "slide",
            JointKind::Fixed => return,
        };
        let limits =
            frame.limits.filter(|limits| limits.iter().all(|limit| limit.is_finite()) && limits[0] < limits[1]);
        let range = limits.map_or_else(String::new, |[low, high]| format!(" range=\"{low} {high}\""));
        let armature = match frame.motion {
            Motion::Passive | Motion::Fixed => self.scale.passive(),
            Motion::Variable { .. } | Motion::Coupling(_) => self.scale.servo(frame.joint).armature,
            Motion::Actuator(which) => {
                let screw = self.robot.actuators.get(which);
                screw.map_or(self.scale.passive(), |screw| self.scale.screw(self.robot, which, screw).armature)
            }
        };
        self.qpos.push(self.start.joints.get(index).copied().unwrap_or_default());
        self.line(
            depth,
            format!("<joint name=\"{name}\" type=\"{kind}\" axis=\"0 0 1\"{range} armature=\"{armature}\"/>"),
        );
    }

    /// Springs of a frame: each compliant direction is a joint that returns to zero, about `at` (m).
    fn springs(&mut self, name: &str, all: &[(usize, String, f64)], at: Vector3<f64>, depth: usize) {
        let at = triple(&at);
        for (direction, symbol, stiffness) in all {
            let (kind, axis) = if *direction < 3 { ("slide", *direction) } else { ("hinge", *direction - 3) };
            let (damping, armature, axis) = (2.0 * TIME * stiffness, TIME * TIME * stiffness, AXES[axis]);
            self.qpos.push(0.0);
            self.line(
                depth,
                format!(
                    "<joint name=\"{name}.{symbol}\" type=\"{kind}\" axis=\"{axis}\" pos=\"{at}\" \
                     stiffness=\"{stiffness}\" damping=\"{damping}\" armature=\"{armature}\"/>"
                ),
            );
        }
    }

    /// Where the springs of a joint act, in its frame.
    fn place(&self, joint: &JointStiffness) -> Vector3<f64> {
        let node = joint.at.and_then(|at| self.robot.elastic.nodes.get(at));
        node.filter(|node| node.at == joint.frame).map_or_else(Vector3::zeros, |node| node.point)
    }

    /// Tool, markers, anchors of springs and pins of screws.
    fn sites(&mut self, frame: FrameIndex, depth: usize) {
        let robot = self.robot;
        if robot.tool.frame == frame {
            let turn = Rotation3::new(robot.tool.placement.rotation);
            let at = Isometry::from_parts(Translation3::from(robot.tool.placement.position), turn);
            self.line(depth, format!("<site name=\"TCP\" {}/>", placed(&at)));
        }
        for marker in robot.markers.iter().filter(|marker| marker.frame == frame) {
            self.site(&escaped(&marker.name), &marker.position, depth);
        }
        for spring in robot.elastic.springs.iter().filter(|spring| is_held(spring)) {
            for k in (0..2).filter(|&k| spring.bodies[k] == frame) {
                self.site(&format!("{}.{}", escaped(&spring.name), k + 1), &spring.anchors[k], depth);
            }
        }
        for screw in robot.actuators.iter().filter(|screw| robot.frames[screw.joint].antecedent == frame) {
            let at = self.fixed_pin(screw);
            self.site(&format!("{}.1", escaped(&screw.name)), &at, depth);
        }
        for own in &robot.loops {
            let [a, b] = own.frames;
            let name = escaped(&own.name);
            if a == frame {
                self.site(&format!("{name}.1"), &Vector3::zeros(), depth);
            }
            if b == frame {
                self.site(&format!("{name}.2"), &self.second_point(own), depth);
            }
        }
    }

    /// Where the first frame of a loop meets the second, in that: links of a planar loop may lie next to each other.
    fn second_point(&self, own: &Loop) -> Vector3<f64> {
        let [a, b] = own.frames.map(|frame| self.start.frames[frame]);
        let gap = (b.inverse() * a).translation.vector;
        if own.kind == LoopKind::Planar && gap.z.abs() > 1e-9 { Vector3::z() * gap.z } else { Vector3::zeros() }
    }

    fn site(&mut self, name: &str, at: &Vector3<f64>, depth: usize) {
        self.line(depth, format!("<site name=\"{name}\" pos=\"{}\"/>", triple(at)));
    }

    /// Pin of a screw on the body before its joint, in the frame before: where [`crate::elements::screw_pins`] has it.
    fn fixed_pin(&self, screw: &SliderCrank) -> Vector3<f64> {
        let frame = &self.robot.frames[screw.joint];
        let [_, _, lambda, _, l3] = screw.constants;
        let angle = lambda - PI + frame.offset;
        let pin = Point3::new(l3 * angle.cos(), l3 * angle.sin(), 0.0);
        (self.constants(frame) * pin).coords
    }
}
