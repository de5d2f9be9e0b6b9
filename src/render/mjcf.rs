//! A description as a model of the simulator MuJoCo (MJCF).
//!
//! Each frame is a body of its name with a joint of its name, whose value is that of the description's joint (rad, m). Springs of joints
//! and of the pedestal are joints of their own after it (`2.kar`), couplings and closed loops equality constraints, springs between
//! bodies tendons. Source: MuJoCo's XML reference (modelling of equalities, tendons, actuators).

use std::fmt::Write;

use nalgebra::{Rotation3, Translation3, UnitQuaternion, Vector3};

use crate::description::elastic::{JointStiffness, Stiffness};
use crate::description::frame::{Frame, FrameIndex, Motion};
use crate::description::khalil_kleinfinger::Isometry;
use crate::description::raw::{JointKind, LoopKind, Meet, SpringAction};
use crate::description::robot::Robot;
use crate::diagnostic::Diagnostic;
use crate::kinematics::{AssemblyError, Geometry, Placements};
use crate::model::Model;
use crate::parameter::Kind;

/// Mass of what has none, kg: MuJoCo moves nothing without.
const LEAST_MASS: f64 = 1e-6;
/// Radius of gyration where the description says a mass and a centre only, m. Statics do not depend on it.
const GYRATION: f64 = 0.1;
/// Inertia of a motor, so that it and the spring after it do not move as one, kg.m2 (kg).
const ARMATURE: f64 = 1.0;
/// Gain of the position actuators, N.m/rad (N/m), and its damping.
const GAIN: [f64; 2] = [1e7, 1e5];
/// Damping of springs over their stiffness, s: vibrations die out.
const DAMPING: f64 = 0.01;

/// Springs along x, y, z and about them, by the index of each in a joint's or the pedestal's list.
const AXES: [&str; 3] = ["1 0 0", "0 1 0", "0 0 1"];

/// The model as XML, and warnings of what it does not hold.
///
/// # Errors
/// Loops that cannot be closed as described.
pub fn mjcf(robot: &Robot, model: &Model) -> Result<(String, Vec<Diagnostic>), AssemblyError> {
    let geometry = Geometry::nominal(model)?;
    let mut placements = Placements::default();
    geometry.place(&model.middle(), &mut placements)?;
    let mut writer = Writer { robot, out: String::new(), lost: Vec::new() };
    writer.lost_parts();
    let name = escaped(&robot.name);
    let g = robot.elastic.gravity;
    writer.line(0, format!("<mujoco model=\"{name}\">"));
    writer.line(
        1,
        format!("<compiler angle=\"radian\" autolimits=\"true\" boundmass=\"{LEAST_MASS}\" boundinertia=\"1e-9\"/>"),
    );
    writer.line(1, format!("<option gravity=\"{}\" integrator=\"implicitfast\"/>", triple(&g)));
    writer.line(1, "<worldbody>");
    writer.body(0, 2);
    writer.line(1, "</worldbody>");
    writer.equalities(&placements);
    writer.tendons();
    writer.actuators();
    writer.line(0, "</mujoco>");
    let lost = writer.lost;
    let diagnostics = (!lost.is_empty()).then(|| {
        Diagnostic::warning(format!("not written to the MJCF: {}", lost.join(", ")))
            .remedy("keep the description beside it: `pose`, `compensate` and `simulate` know them")
    });
    Ok((writer.out, diagnostics.into_iter().collect()))
}

struct Writer<'a> {
    robot: &'a Robot,
    out: String,
    /// What is not written.
    lost: Vec<String>,
}

impl Writer<'_> {
    fn line(&mut self, depth: usize, text: impl AsRef<str>) {
        let _ = writeln!(self.out, "{:1$}{2}", "", 2 * depth, text.as_ref());
    }

    /// A frame, what hangs on it, and points on it.
    fn body(&mut self, frame: FrameIndex, depth: usize) {
        let robot = self.robot;
        let own = &robot.frames[frame];
        let name = if frame == 0 { "base".to_string() } else { escaped(&own.name) };
        let at = if frame == 0 { Isometry::identity() } else { self.constants(own) };
        self.line(depth, format!("<body name=\"{name}\" {}>", placed(&at)));
        self.inertia(frame, depth + 1);
        if frame == 0 {
            self.springs("base", &pedestal(robot), Vector3::zeros(), depth + 1);
        } else {
            self.joint(own, &name, depth + 1);
            let stiffness = robot.elastic.joints.iter().filter(|joint| joint.frame == frame);
            for joint in stiffness {
                self.springs(&name, &directions(joint), self.place(joint), depth + 1);
            }
        }
        self.sites(frame, depth + 1);
        let children = (1..robot.frames.len()).filter(|&child| robot.frames[child].antecedent == frame);
        children.for_each(|child| self.body(child, depth + 1));
        self.line(depth, "</body>");
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

    fn joint(&mut self, frame: &Frame, name: &str, depth: usize) {
        let kind = match frame.joint {
            JointKind::Revolute => "hinge",
            JointKind::Prismatic => "slide",
            JointKind::Fixed => return,
        };
        let limits =
            frame.limits.filter(|limits| limits.iter().all(|limit| limit.is_finite()) && limits[0] < limits[1]);
        let range = limits.map_or_else(String::new, |[low, high]| format!(" range=\"{low} {high}\""));
        let armature =
            if frame.motion == Motion::Passive { String::new() } else { format!(" armature=\"{ARMATURE}\"") };
        self.line(depth, format!("<joint name=\"{name}\" type=\"{kind}\" axis=\"0 0 1\"{range}{armature}/>"));
    }

    /// Springs of a frame: each compliant direction is a joint that returns to zero, about `at` (m).
    fn springs(&mut self, name: &str, all: &[(usize, String, Stiffness)], at: Vector3<f64>, depth: usize) {
        for (direction, symbol, spring) in all.iter().filter(|(_, _, spring)| spring.nominal > 0.0) {
            let (kind, axis) = if *direction < 3 { ("slide", *direction) } else { ("hinge", *direction - 3) };
            let (stiffness, at) = (stiffness(spring), triple(&at));
            let damping = DAMPING * stiffness;
            let axis = AXES[axis];
            self.line(
                depth,
                format!("<joint name=\"{name}.{symbol}\" type=\"{kind}\" axis=\"{axis}\" pos=\"{at}\" stiffness=\"{stiffness}\" damping=\"{damping}\"/>"),
            );
        }
    }

    /// Where the springs of a joint act, in its frame.
    fn place(&self, joint: &JointStiffness) -> Vector3<f64> {
        let node = joint.at.and_then(|at| self.robot.elastic.nodes.get(at));
        node.filter(|node| node.at == joint.frame).map_or_else(Vector3::zeros, |node| node.point)
    }

    /// Tool, markers and anchors of springs.
    fn sites(&mut self, frame: FrameIndex, depth: usize) {
        let robot = self.robot;
        if robot.tool.frame == frame {
            let turn = Rotation3::new(robot.tool.placement.rotation);
            let at = Isometry::from_parts(Translation3::from(robot.tool.placement.position), turn);
            self.line(depth, format!("<site name=\"TCP\" {}/>", placed(&at)));
        }
        for marker in robot.markers.iter().filter(|marker| marker.frame == frame) {
            let (name, at) = (escaped(&marker.name), triple(&marker.position));
            self.line(depth, format!("<site name=\"{name}\" pos=\"{at}\"/>"));
        }
        for spring in &robot.elastic.springs {
            for k in (0..2).filter(|&k| spring.bodies[k] == frame) {
                let (name, at) = (escaped(&spring.name), triple(&spring.anchors[k]));
                self.line(depth, format!("<site name=\"{name}.{}\" pos=\"{at}\"/>", k + 1));
            }
        }
        for own in &robot.loops {
            for k in (0..2).filter(|&k| own.frames[k] == frame) {
                self.line(depth, format!("<site name=\"{}.{}\"/>", escaped(&own.name), k + 1));
            }
        }
    }

    /// Constants of a frame in its antecedent, of which it may share some.
    fn constants(&self, frame: &Frame) -> Isometry {
        let mut constants = frame.constants;
        if let Some(shared) = frame.coaxial.and_then(|index| self.robot.frames.get(index)) {
            let (theta, r) = (constants.theta, constants.r);
            constants = shared.constants;
            (constants.theta, constants.r) = (theta, r);
        }
        constants.isometry()
    }

    fn name(&self, frame: FrameIndex) -> String {
        escaped(&self.robot.frames[frame].name)
    }

    /// Loops and couplings.
    fn equalities(&mut self, placements: &Placements) {
        let robot = self.robot;
        if robot.loops.is_empty() && robot.couplings.is_empty() {
            return;
        }
        self.line(1, "<equality>");
        for own in &robot.loops {
            let name = escaped(&own.name);
            // Planar loops are closed in their plane: links that lie beside each other stay so, which sites cannot say.
            let [a, b] = own.frames.map(|frame| placements.frames[frame]);
            let gap = (b.inverse() * a).translation.vector;
            if own.kind == LoopKind::Planar && gap.norm() > 1e-9 {
                let at = triple(&(a.inverse() * b).translation.vector);
                let [one, other] = own.frames.map(|frame| self.name(frame));
                self.line(2, format!("<connect name=\"{name}\" body1=\"{one}\" body2=\"{other}\" anchor=\"{at}\"/>"));
                self.lost.push(format!("the offset of loop `{name}` along its axes ({:.3} mm)", 1e3 * gap.norm()));
                continue;
            }
            let kind = if own.meet == Meet::Origin { "connect" } else { "weld" };
            self.line(2, format!("<{kind} name=\"{name}\" site1=\"{name}.1\" site2=\"{name}.2\"/>"));
        }
        for coupling in &robot.couplings {
            let follower = self.name(coupling.joint);
            if let [(factor, followed)] = coupling.terms[..] {
                let followed = self.name(followed);
                self.line(
                    2,
                    format!("<joint joint1=\"{follower}\" joint2=\"{followed}\" polycoef=\"0 {factor} 0 0 0\"/>"),
                );
            } else {
                self.line(2, format!("<tendon tendon1=\"{follower}.coupling\" polycoef=\"0 0 0 0 0\"/>"));
            }
        }
        self.line(1, "</equality>");
    }

    /// Springs between bodies, and sums of joints that a coupling keeps at zero.
    fn tendons(&mut self) {
        let robot = self.robot;
        let springs: Vec<_> = robot.elastic.springs.iter().filter(|spring| spring.acts == SpringAction::Full).collect();
        let sums: Vec<_> = robot.couplings.iter().filter(|coupling| coupling.terms.len() != 1).collect();
        if springs.is_empty() && sums.is_empty() {
            return;
        }
        self.line(1, "<tendon>");
        for spring in springs.into_iter().filter(|spring| spring.rate.nominal > 0.0) {
            let name = escaped(&spring.name);
            let rate = stiffness(&spring.rate);
            let length = spring.free_length.map_or_else(String::new, |length| format!(" springlength=\"{length}\""));
            self.line(2, format!("<spatial name=\"{name}\" stiffness=\"{rate}\"{length}>"));
            self.line(3, format!("<site site=\"{name}.1\"/><site site=\"{name}.2\"/>"));
            self.line(2, "</spatial>");
        }
        for coupling in sums {
            self.line(2, format!("<fixed name=\"{}.coupling\">", self.name(coupling.joint)));
            self.line(3, format!("<joint joint=\"{}\" coef=\"1\"/>", self.name(coupling.joint)));
            for (factor, followed) in &coupling.terms {
                self.line(3, format!("<joint joint=\"{}\" coef=\"{}\"/>", self.name(*followed), -factor));
            }
            self.line(2, "</fixed>");
        }
        self.line(1, "</tendon>");
    }

    /// A position actuator for each variable that moves a joint itself; its control is the controller's value.
    fn actuators(&mut self) {
        let robot = self.robot;
        let [gain, damping] = GAIN;
        self.line(1, "<actuator>");
        for frame in &robot.frames {
            let Motion::Variable { index, direction } = frame.motion else { continue };
            let (variable, joint) = (escaped(&robot.variables[index].name), escaped(&frame.name));
            let zero = gain * direction * frame.offset;
            self.line(
                2,
                format!("<general name=\"{variable}\" joint=\"{joint}\" gear=\"{direction}\" biastype=\"affine\" gainprm=\"{gain}\" biasprm=\"{zero} {} {}\"/>", -gain, -damping),
            );
        }
        self.line(1, "</actuator>");
    }

    /// What no model of MuJoCo holds, or this one does not.
    fn lost_parts(&mut self) {
        let robot = self.robot;
        let names = |all: Vec<&str>| all.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ");
        let weak = robot.elastic.springs.iter().filter(|spring| spring.acts != SpringAction::Full);
        let lost_rules: &[&str] = if robot.fuzzy.is_some() || robot.spring_rules.is_some() { &["fuzzy"] } else { &[] };
        let parts = [
            ("actuators beside their joints", robot.actuators.iter().map(|own| own.name.as_str()).collect::<Vec<_>>()),
            ("beams", robot.elastic.beams.iter().map(|own| own.name.as_str()).collect()),
            ("springs that act on the stiffness alone", weak.map(|own| own.name.as_str()).collect()),
            ("limits of sums", robot.limits.iter().map(|own| own.name.as_str()).collect()),
            ("boxes to keep out of", robot.keep_out.iter().map(|own| own.name.as_str()).collect()),
            ("effects", robot.effects.iter().filter_map(|own| own.effect.as_deref()).collect()),
            ("rules", lost_rules.to_vec()),
        ];
        let lost = parts.into_iter().filter(|(_, all)| !all.is_empty());
        self.lost.extend(lost.map(|(what, all)| format!("{what} ({})", names(all))));
    }
}

/// Direction, symbol and spring of what a joint has: along x, y, z, about x, y, z.
fn directions(joint: &JointStiffness) -> Vec<(usize, String, Stiffness)> {
    let held = crate::description::parameters::joint_directions(|spring| joint.springs[spring].is_some());
    let own = held.into_iter().enumerate().filter_map(|(direction, spring)| {
        let across = ["x", "y", "", "x", "y", ""][direction];
        let symbol = ["ka", "kr", "kar", "krr", "kr", "kr", "krr", "krr"][spring];
        Some((direction, format!("{symbol}{across}"), joint.springs[spring]?))
    });
    own.collect()
}

fn pedestal(robot: &Robot) -> Vec<(usize, String, Stiffness)> {
    let symbols = ["kx", "ky", "kz", "krx", "kry", "krz"];
    let own = robot.elastic.base.iter().zip(symbols).enumerate();
    own.filter_map(|(k, (spring, symbol))| Some((k, symbol.to_string(), (*spring)?))).collect()
}

/// N/m or N.m/rad.
fn stiffness(spring: &Stiffness) -> f64 {
    match spring.kind {
        Kind::LinearCompliance | Kind::RotationalCompliance => 1.0 / spring.nominal,
        _ => spring.nominal,
    }
}

fn triple(vector: &Vector3<f64>) -> String {
    format!("{} {} {}", vector.x, vector.y, vector.z)
}

/// `pos` and `quat` of a displacement.
fn placed(at: &Isometry) -> String {
    let q = UnitQuaternion::from_rotation_matrix(&at.rotation);
    format!("pos=\"{}\" quat=\"{} {} {} {}\"", triple(&at.translation.vector), q.w, q.i, q.j, q.k)
}

/// Text as it stands within an attribute; what XML cannot hold is replaced.
fn escaped(text: &str) -> String {
    let text: String = text.chars().map(|c| if super::diagnostics::is_active(c) { '_' } else { c }).collect();
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
