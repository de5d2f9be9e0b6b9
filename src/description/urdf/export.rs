//! From a robot description to a URDF.

use std::collections::{HashMap, HashSet};

use nalgebra::{Rotation3, Translation3, UnitQuaternion, Vector3};

use super::follow::{Follower, direction, followers, joint_unit};
use super::khalil_kleinfinger::{Isometry, clean};
use super::locate::{KEPT, KEPT_FRAMES};
use super::xml::{allowed, escaped, number, put, roll_pitch_yaw, triple};
use crate::description::raw::{JointKind, RawFrame, RawPlacement, RawRobot, RawTool};
use crate::description::robot::Constants;
use crate::diagnostic::Diagnostic;

/// Bounds written for a prismatic joint that has none, as URDF asks for some, metres.
const REACH: f64 = 10.0;

/// Writes a description, in whatever units, as a URDF.
///
/// Each frame becomes a link and a joint of its name; the base becomes the link `base_link`. The joint's axis is z, or -z
/// where the controller counts the other way (`direction: -1`), so that URDF joint values are the controller's; a calibrated
/// `offset` is part of the origin. A joint that follows one other joint gets a `<mimic>`. The tool (when it is not simply a
/// frame's origin) and the markers become fixed links. An element `elastogeo` makes [`import`](super::import) take the
/// link frames for the description's frames as they are; other readers pass over it. Inertia tensors are written as zero: a description has none.
///
/// With the text come warnings about what a URDF cannot say: closed loops, actuators away from their joint, joints that follow
/// several others, elasticity.
///
/// # Errors
///
/// Every fault that keeps the frames from forming a tree: a missing or unknown antecedent, a circle, an unknown frame in a
/// coupling, a number that is not finite, a name that XML cannot hold.
pub fn export(robot: &RawRobot) -> Result<(String, Vec<Diagnostic>), Vec<Diagnostic>> {
    let mut writer = Writer::new(robot);
    writer.check();
    let followers = followers(robot, &mut writer.diagnostics);
    if writer.diagnostics.iter().any(Diagnostic::is_error) {
        return Err(writer.diagnostics);
    }
    writer.report_losses();
    let text = writer.text(&followers);
    if writer.diagnostics.iter().any(Diagnostic::is_error) {
        Err(writer.diagnostics)
    } else {
        Ok((text, writer.diagnostics))
    }
}

struct Writer<'a> {
    robot: &'a RawRobot,
    length: f64,
    angle: f64,
    /// Link and joint names given so far.
    taken: HashSet<String>,
    base: String,
    diagnostics: Vec<Diagnostic>,
}

impl<'a> Writer<'a> {
    fn new(robot: &'a RawRobot) -> Self {
        let taken = robot.frames.keys().cloned().collect();
        let (length, angle) = (robot.units.length.factor(), robot.units.angle.factor());
        let mut writer = Self { robot, length, angle, taken, base: String::new(), diagnostics: Vec::new() };
        writer.base = writer.free_name("base_link");
        writer
    }

    /// This name, or one made of it that no link and no joint has.
    fn free_name(&mut self, wanted: &str) -> String {
        let mut name = wanted.to_owned();
        while !self.taken.insert(name.clone()) {
            name.push('_');
        }
        name
    }

    fn error(&mut self, message: String) {
        self.diagnostics.push(Diagnostic::error(message));
    }

    fn known(&mut self, what: &str, name: &str) {
        if name != "0" && !self.robot.frames.contains_key(name) {
            let names = self.robot.frames.keys().map(String::as_str).chain(["0"]);
            self.diagnostics.push(Diagnostic::error(format!("{what}: unknown frame `{name}`")).suggest(name, names));
        }
    }

    /// Diagnostics on what keeps the description from being a tree of finite numbers.
    fn check(&mut self) {
        let robot = self.robot;
        self.check_frames();
        self.check_circles();
        for (name, body) in &robot.bodies {
            self.known("bodies", name);
            if body.mass.into_iter().chain(body.com.into_iter().flatten()).any(|value| !value.is_finite()) {
                self.error(format!("the body `{name}` holds a number that is not finite"));
            }
        }
        let tool = robot.tool.at.into_iter().chain(robot.tool.rotation).flatten();
        if tool.chain(robot.markers.values().flat_map(|marker| marker.at).flatten()).any(|value| !value.is_finite()) {
            self.error("the tool or a marker holds a number that is not finite".to_owned());
        }
        self.check_carriers();
        let names = robot.frames.keys().chain(robot.markers.keys()).chain(&robot.robot);
        for name in names.filter(|name| name.chars().any(|c| !allowed(c))) {
            self.error(format!("XML cannot hold the name {name:?}"));
        }
    }

    fn check_frames(&mut self) {
        for (name, frame) in &self.robot.frames {
            if name == "0" {
                self.error("`0` is the base and cannot be a frame".to_owned());
            }
            match &frame.antecedent {
                Some(antecedent) => self.known(&format!("antecedent of `{name}`"), antecedent),
                None => self.error(format!("the frame `{name}` lacks its antecedent")),
            }
            if let Some(other) = &frame.coaxial {
                self.known(&format!("`{name}` coaxial"), other);
            }
            if !matches!(frame.direction, None | Some(1.0 | -1.0)) {
                self.error(format!("the direction of `{name}` is neither 1 nor -1"));
            }
            let RawFrame { beta, gamma, b, alpha, d, theta, r, offset, .. } = frame;
            let constants = [beta, gamma, b, alpha, d, theta, r, offset].into_iter().copied().flatten();
            if constants.chain(frame.limits.into_iter().flatten()).any(|value| !value.is_finite()) {
                self.error(format!("the frame `{name}` holds a number that is not finite"));
            }
        }
    }

    /// Frames whose antecedents never reach the base.
    fn check_circles(&mut self) {
        let robot = self.robot;
        let mut hung: HashSet<&str> = HashSet::from(["0"]);
        for start in robot.frames.keys() {
            let (mut walk, mut at) = (Vec::new(), start.as_str());
            while !hung.contains(at) {
                if walk.contains(&at) {
                    self.error(format!("the antecedents of `{at}` form a circle"));
                    break;
                }
                walk.push(at);
                let Some(next) = robot.frames.get(at).and_then(|frame| frame.antecedent.as_deref()) else { break };
                at = next;
            }
            hung.extend(walk);
        }
    }

    /// The frames that carry the tool and the markers.
    fn check_carriers(&mut self) {
        let robot = self.robot;
        match &robot.tool.frame {
            Some(frame) => self.known("tool", frame),
            None if self.only_leaf().is_some() => {}
            None if robot.tool != RawTool::default() || robot.markers.values().any(|marker| marker.frame.is_none()) => {
                let diagnostic =
                    Diagnostic::error("several frames carry nothing: which of them carries the tool is not said");
                self.diagnostics.push(diagnostic.remedy("say `tool: {frame: ...}`"));
            }
            None => {}
        }
        for (name, marker) in &robot.markers {
            if let Some(frame) = &marker.frame {
                self.known(&format!("marker `{name}`"), frame);
            }
        }
    }

    /// Warnings about what is lost.
    fn report_losses(&mut self) {
        let robot = self.robot;
        let list = |names: Vec<&String>| names.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ");
        let passive: Vec<&String> =
            robot.frames.iter().filter(|(_, frame)| frame.passive).map(|(name, _)| name).collect();
        if !robot.loops.is_empty() || !passive.is_empty() {
            let message = format!("a URDF cannot close loops ({})", list(robot.loops.keys().collect()));
            let remedy = format!("the passive joints {} are written as joints to be set from outside", list(passive));
            self.diagnostics.push(Diagnostic::warning(message).remedy(remedy));
        }
        let actuated: Vec<String> = robot.actuators.values().filter_map(|actuator| actuator.joint.clone()).collect();
        if !robot.actuators.is_empty() {
            let message =
                format!("a URDF cannot say how actuators turn joints ({})", list(robot.actuators.keys().collect()));
            let remedy =
                format!("the joints {} take the joint's value, not the actuator's", list(actuated.iter().collect()));
            self.diagnostics.push(Diagnostic::warning(message).remedy(remedy));
        }
        let sections = [
            ("urdf", robot.urdf.is_none()),
            ("base", robot.base == RawPlacement::default()),
            ("anchors", robot.anchors.is_empty()),
            ("beams", robot.beams.is_empty()),
            ("joint_stiffness", robot.joint_stiffness.is_empty()),
            ("base_stiffness", robot.base_stiffness.is_none()),
            ("springs", robot.springs.is_empty()),
            ("effects", robot.effects.is_empty()),
            ("fuzzy", robot.fuzzy.is_none()),
        ];
        let lost: Vec<String> =
            sections.iter().filter(|(_, absent)| !absent).map(|(name, _)| (*name).to_owned()).collect();
        if !lost.is_empty() {
            self.diagnostics
                .push(Diagnostic::warning(format!("not written to the URDF: {}", list(lost.iter().collect()))));
        }
        if !robot.bodies.is_empty() {
            let message = "inertia tensors are written as zero: the description has none";
            self.diagnostics.push(Diagnostic::warning(message).remedy("masses and centres of mass are written"));
        }
    }

    fn text(&mut self, followers: &HashMap<&str, Follower>) -> String {
        let robot = self.robot;
        let mut out = String::from("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n");
        let name = robot.robot.as_deref().filter(|name| !name.trim().is_empty()).unwrap_or("robot");
        put(&mut out, format_args!("<robot name=\"{}\">\n", escaped(name)));
        if let Some(source) = robot.source.as_ref().filter(|source| source.chars().all(allowed)) {
            put(&mut out, format_args!("  <!-- {} -->\n", source.trim().replace("--", "- -").replace("--", "- -")));
        }
        let (attribute, value) = KEPT_FRAMES;
        put(&mut out, format_args!("  <{KEPT} {attribute}=\"{value}\"/>\n"));
        let base = self.base.clone();
        self.link(&mut out, &base, "0");
        for (name, frame) in &robot.frames {
            self.link(&mut out, name, name);
            self.joint(&mut out, name, frame, followers.get(name.as_str()));
        }
        let only = self.only_leaf();
        let tool = robot.tool.frame.as_deref().or(only).unwrap_or("0");
        let at = Isometry::from_parts(self.position(robot.tool.at), self.rotation(robot.tool.rotation));
        // Among several ends a link with the name of a tool shows which it is.
        let named = tool != "0" && (only != Some(tool) || !robot.markers.is_empty());
        if at != Isometry::identity() || named {
            let name = self.free_name("tool0");
            self.fixed_link(&mut out, &name, tool, &at);
        }
        for (marker, place) in &robot.markers {
            let name = self.free_name(marker);
            let at = Isometry::from_parts(self.position(place.at), Rotation3::identity());
            self.fixed_link(&mut out, &name, place.frame.as_deref().unwrap_or(tool), &at);
        }
        out.push_str("</robot>\n");
        out
    }

    /// The only frame that carries nothing.
    fn only_leaf(&self) -> Option<&'a str> {
        let carriers: HashSet<&str> =
            self.robot.frames.values().filter_map(|frame| frame.antecedent.as_deref()).collect();
        let mut leaves = self.robot.frames.keys().map(String::as_str).filter(|name| !carriers.contains(name));
        leaves.next().filter(|_| leaves.next().is_none())
    }

    fn link_of<'n>(&'n self, frame: &'n str) -> &'n str {
        if frame == "0" { &self.base } else { frame }
    }

    fn link(&self, out: &mut String, link: &str, frame: &str) {
        let Some(body) = self.robot.bodies.get(frame) else {
            put(out, format_args!("  <link name=\"{}\"/>\n", escaped(link)));
            return;
        };
        let mass = body.mass.unwrap_or(0.0) * self.robot.units.mass.factor();
        put(out, format_args!("  <link name=\"{}\">\n    <inertial>\n", escaped(link)));
        let com = self.position(body.com).vector;
        put(out, format_args!("      <origin xyz=\"{}\"/>\n      <mass value=\"{}\"/>\n", triple(&com), number(mass)));
        out.push_str("      <inertia ixx=\"0\" ixy=\"0\" ixz=\"0\" iyy=\"0\" iyz=\"0\" izz=\"0\"/>\n");
        out.push_str("    </inertial>\n  </link>\n");
    }

    fn joint(&mut self, out: &mut String, name: &str, frame: &RawFrame, follower: Option<&Follower>) {
        let kind = match frame.joint {
            Some(JointKind::Revolute) if frame.limits.is_none() => "continuous",
            Some(JointKind::Revolute) => "revolute",
            Some(JointKind::Prismatic) => "prismatic",
            Some(JointKind::Fixed) | None => "fixed",
        };
        let at = self.constants(frame, follower.map_or(0.0, |follower| follower.constant)).isometry();
        let antecedent = frame.antecedent.as_deref().unwrap_or("0");
        self.open_joint(out, name, kind, antecedent, name, &at);
        if let Some(follower) = follower {
            let sign = direction(frame);
            put(out, format_args!("    <axis xyz=\"0 0 {sign}\"/>\n"));
            let unit = joint_unit(self.robot, frame);
            let mut limits = frame.limits.map(|limits| limits.map(|limit| limit * unit));
            if frame.variable.is_none() {
                // They bound the frame's joint variable, not the controller's.
                limits = limits.map(|limits| limits.map(|limit| sign * (limit - follower.constant)));
                limits = limits.map(|[a, b]| [a.min(b), a.max(b)]);
            }
            if limits.is_none() && kind == "prismatic" {
                let message = format!("the prismatic joint `{name}` has no limits, which a URDF must have");
                self.diagnostics.push(Diagnostic::warning(message).remedy(format!("{REACH} m each way are written")));
                limits = Some([-REACH, REACH]);
            }
            if let Some([lower, upper]) = limits {
                let (lower, upper) = (number(lower), number(upper));
                put(
                    out,
                    format_args!("    <limit lower=\"{lower}\" upper=\"{upper}\" effort=\"0\" velocity=\"0\"/>\n"),
                );
            }
            if let Some((master, factor)) = follower.master {
                let (master, factor) = (escaped(master), number(factor));
                put(out, format_args!("    <mimic joint=\"{master}\" multiplier=\"{factor}\"/>\n"));
            }
        }
        out.push_str("  </joint>\n");
    }

    fn fixed_link(&self, out: &mut String, name: &str, frame: &str, at: &Isometry) {
        put(out, format_args!("  <link name=\"{}\"/>\n", escaped(name)));
        self.open_joint(out, name, "fixed", frame, name, at);
        out.push_str("  </joint>\n");
    }

    fn open_joint(&self, out: &mut String, name: &str, kind: &str, parent: &str, child: &str, at: &Isometry) {
        let (name, parent, child) = (escaped(name), escaped(self.link_of(parent)), escaped(child));
        put(out, format_args!("  <joint name=\"{name}\" type=\"{kind}\">\n"));
        put(out, format_args!("    <parent link=\"{parent}\"/>\n    <child link=\"{child}\"/>\n"));
        let scale = 1.0 + at.translation.vector.norm();
        let xyz = triple(&at.translation.vector.map(|length| clean(length, scale)));
        let rpy = triple(&roll_pitch_yaw(&at.rotation));
        put(out, format_args!("    <origin xyz=\"{xyz}\" rpy=\"{rpy}\"/>\n"));
    }

    /// The frame's constants, SI, with `constant` added to the joint variable.
    fn constants(&self, frame: &RawFrame, constant: f64) -> Constants {
        let mut shared = frame;
        // A frame may share its axis with one that shares its own; a circle of them ends too.
        for _ in 0..self.robot.frames.len() {
            match shared.coaxial.as_ref().and_then(|name| self.robot.frames.get(name)) {
                Some(next) => shared = next,
                None => break,
            }
        }
        let angle = |value: Option<f64>| value.unwrap_or(0.0) * self.angle;
        let length = |value: Option<f64>| value.unwrap_or(0.0) * self.length;
        let (mut theta, mut r) = (angle(frame.theta), length(frame.r));
        match frame.joint {
            Some(JointKind::Revolute) => theta += constant,
            Some(JointKind::Prismatic) => r += constant,
            Some(JointKind::Fixed) | None => {}
        }
        let (beta, gamma, alpha) = (angle(shared.beta), angle(shared.gamma), angle(shared.alpha));
        Constants { beta, gamma, b: length(shared.b), alpha, d: length(shared.d), theta, r }
    }

    fn position(&self, at: Option<[f64; 3]>) -> Translation3<f64> {
        Translation3::from(Vector3::from(at.unwrap_or_default()) * self.length)
    }

    /// The rotation of a rotation vector in the file's unit.
    fn rotation(&self, vector: Option<[f64; 3]>) -> Rotation3<f64> {
        let vector = Vector3::from(vector.unwrap_or_default()) * self.angle;
        UnitQuaternion::from_scaled_axis(vector).to_rotation_matrix()
    }
}
