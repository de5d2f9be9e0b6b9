//! From a robot description to a URDF.

use std::collections::{HashMap, HashSet};

use nalgebra::{Rotation3, Translation3, UnitQuaternion, Vector3};

use super::elements::{KEPT, KEPT_FRAMES};
use super::follow::{Follower, Followers, direction, followers, joint_unit};
use super::xml::{allowed, escaped, number, put, triple};
use crate::description::convention::khalil_kleinfinger as to_khalil_kleinfinger;
use crate::description::khalil_kleinfinger::{Isometry, clean, roll_pitch_yaw};
use crate::description::raw::{JointKind, RawFrame, RawPlacement, RawRobot, RawTool};
use crate::description::resolve::resolve;
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
/// Every fault of the description, and a name that XML cannot hold.
pub fn export(robot: &RawRobot) -> Result<(String, Vec<Diagnostic>), Vec<Diagnostic>> {
    let (robot, _) = to_khalil_kleinfinger(robot, &|_| None, &|_| false);
    let mut writer = Writer::new(&robot);
    let followers = writer.check()?;
    whole(writer, &followers)
}

/// A URDF of nothing but the description.
pub(super) fn whole(mut writer: Writer, followers: &Followers) -> Result<(String, Vec<Diagnostic>), Vec<Diagnostic>> {
    writer.report_losses();
    if !writer.robot.bodies.is_empty() {
        let message = "inertia tensors are written as zero: the description has none";
        writer.diagnostics.push(Diagnostic::warning(message).remedy("masses and centres of mass are written"));
    }
    let text = writer.text(followers);
    if writer.diagnostics.iter().any(Diagnostic::is_error) {
        Err(writer.diagnostics)
    } else {
        Ok((text, writer.diagnostics))
    }
}

pub(super) struct Writer<'a> {
    pub(super) robot: &'a RawRobot,
    length: f64,
    angle: f64,
    /// Link and joint names given so far.
    pub(super) taken: HashSet<String>,
    /// The link that carries a frame and the frame's pose in it, where that is not a link of the frame's own.
    pub(super) links: HashMap<String, (String, Isometry)>,
    pub(super) diagnostics: Vec<Diagnostic>,
}

impl<'a> Writer<'a> {
    pub(super) fn new(robot: &'a RawRobot) -> Self {
        let taken = robot.frames.keys().cloned().collect();
        let (length, angle) = (robot.units.length.factor(), robot.units.angle.factor());
        Self { robot, length, angle, taken, links: HashMap::new(), diagnostics: Vec::new() }
    }

    /// This name, or one made of it that no link and no joint has.
    pub(super) fn free_name(&mut self, wanted: &str) -> String {
        let mut name = wanted.to_owned();
        while !self.taken.insert(name.clone()) {
            name.push('_');
        }
        name
    }

    /// How joints follow one another; every fault of the description, and names that XML cannot hold.
    pub(super) fn check(&mut self) -> Result<Followers<'a>, Vec<Diagnostic>> {
        let robot = self.robot;
        let mut checked = robot.clone();
        if robot.tool == RawTool::default() && robot.markers.values().all(|marker| marker.frame.is_some()) {
            // Nothing hangs on the tool: which of several ends it is need not be known.
            checked.tool.frame = robot.frames.keys().last().cloned();
        }
        let mut faults = resolve(&checked, &|_| None).1;
        faults.retain(Diagnostic::is_error);
        let names = robot.frames.keys().chain(robot.markers.keys()).chain(&robot.robot);
        let strange = names.filter(|name| name.chars().any(|c| !allowed(c)));
        faults.extend(strange.map(|name| Diagnostic::error(format!("XML cannot hold the name {name:?}"))));
        if faults.is_empty() { Ok(followers(robot, &mut self.diagnostics)) } else { Err(faults) }
    }

    /// Warnings about what is lost.
    pub(super) fn report_losses(&mut self) {
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
            ("base", robot.base == RawPlacement::default()),
            ("limits", robot.limits.is_empty()),
            ("keep_out", robot.keep_out.is_empty()),
            ("anchors", robot.anchors.is_empty()),
            ("beams", robot.beams.is_empty()),
            ("joint_stiffness", robot.joint_stiffness.is_empty()),
            ("base_stiffness", robot.base_stiffness.is_none()),
            ("springs", robot.springs.is_empty()),
            ("payloads", robot.payloads.is_empty()),
            ("effects", robot.effects.is_empty()),
            ("fuzzy", robot.fuzzy.is_none()),
        ];
        let lost: Vec<String> =
            sections.iter().filter(|(_, absent)| !absent).map(|(name, _)| (*name).to_owned()).collect();
        if !lost.is_empty() {
            self.diagnostics
                .push(Diagnostic::warning(format!("not written to the URDF: {}", list(lost.iter().collect()))));
        }
    }

    fn text(&mut self, followers: &Followers) -> String {
        let robot = self.robot;
        let mut out = String::from("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n");
        let name = robot.robot.as_deref().filter(|name| !name.trim().is_empty()).unwrap_or("robot");
        put(&mut out, format_args!("<robot name=\"{}\">\n", escaped(name)));
        if let Some(source) = robot.source.as_ref().filter(|source| source.chars().all(allowed)) {
            put(&mut out, format_args!("  <!-- {} -->\n", source.trim().replace("--", "- -").replace("--", "- -")));
        }
        let (attribute, value) = KEPT_FRAMES;
        put(&mut out, format_args!("  <{KEPT} {attribute}=\"{value}\"/>\n"));
        let base = self.free_name("base_link");
        self.link(&mut out, &base, "0");
        self.links.insert("0".to_owned(), (base, Isometry::identity()));
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

    /// The only frame that carries nothing and closes no loop.
    fn only_leaf(&self) -> Option<&'a str> {
        let carriers: HashSet<&str> =
            self.robot.frames.values().filter_map(|frame| frame.antecedent.as_deref()).collect();
        let closes =
            |name: &str| self.robot.loops.values().any(|l| l.frames.iter().flatten().any(|known| known == name));
        let leaves = self.robot.frames.keys().map(String::as_str);
        let mut leaves = leaves.filter(|name| !carriers.contains(name) && !closes(name));
        leaves.next().filter(|_| leaves.next().is_none())
    }

    pub(super) fn link(&self, out: &mut String, link: &str, frame: &str) {
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

    pub(super) fn joint(&mut self, out: &mut String, name: &str, frame: &RawFrame, follower: Option<&Follower>) {
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

    pub(super) fn fixed_link(&self, out: &mut String, name: &str, frame: &str, at: &Isometry) {
        put(out, format_args!("  <link name=\"{}\"/>\n", escaped(name)));
        self.open_joint(out, name, "fixed", frame, name, at);
        out.push_str("  </joint>\n");
    }

    fn open_joint(&self, out: &mut String, name: &str, kind: &str, parent: &str, child: &str, at: &Isometry) {
        let own = (parent.to_owned(), Isometry::identity());
        let (parent, frame) = self.links.get(parent).unwrap_or(&own);
        let at = frame * at;
        let (name, parent, child) = (escaped(name), escaped(parent), escaped(child));
        put(out, format_args!("  <joint name=\"{name}\" type=\"{kind}\">\n"));
        put(out, format_args!("    <parent link=\"{parent}\"/>\n    <child link=\"{child}\"/>\n"));
        put(out, format_args!("    {}\n", origin(&at)));
    }

    /// The frame's constants, SI, with `constant` added to the joint variable.
    pub(super) fn constants(&self, frame: &RawFrame, constant: f64) -> Constants {
        let shared = frame.coaxial.as_ref().and_then(|name| self.robot.frames.get(name)).unwrap_or(frame);
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

    pub(super) fn position(&self, at: Option<[f64; 3]>) -> Translation3<f64> {
        Translation3::from(Vector3::from(at.unwrap_or_default()) * self.length)
    }

    /// The rotation of a rotation vector in the file's unit.
    pub(super) fn rotation(&self, vector: Option<[f64; 3]>) -> Rotation3<f64> {
        let vector = Vector3::from(vector.unwrap_or_default()) * self.angle;
        UnitQuaternion::from_scaled_axis(vector).to_rotation_matrix()
    }
}

/// `<origin>` of a displacement.
pub(super) fn origin(at: &Isometry) -> String {
    let scale = 1.0 + at.translation.vector.norm();
    let xyz = triple(&at.translation.vector.map(|length| clean(length, scale)));
    format!("<origin xyz=\"{xyz}\" rpy=\"{}\"/>", triple(&roll_pitch_yaw(&at.rotation)))
}
