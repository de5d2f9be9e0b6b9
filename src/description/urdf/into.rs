//! A description written into the URDF that it came from: what differs is changed, all else stays as it stands.

use std::ops::Range;

use nalgebra::{Point3, Vector3};
use roxmltree::Node;

use super::chain::Request;
use super::elements::Kind;
use super::export::{Writer, origin, whole};
use super::follow::{Followers, direction, joint_unit};
use super::import::{Builder, built};
use super::motion::Isometry;
use super::xml::{number, triple};
use crate::description::raw::{RawBody, RawFrame, RawRobot, RawTool};
use crate::diagnostic::Diagnostic;

/// What differs by less (m, rad, kg, relative) is round-off of the way through the description's units, and stays as written.
const ROUND_OFF: f64 = 1e-10;

/// Writes a description into the URDF that it came from (`text`, shown as `file`; `robot.urdf` says which chain).
///
/// Origins of joints are changed where the geometry has changed, limits and masses where these have; link frames stay
/// where they were in their bodies, so that shapes, inertia tensors, efforts, velocities and everything else that the file
/// holds stay valid and as they stand. The tool goes to the fixed joint of its link. Frames, markers and tools that the
/// file has not are added as links.
///
/// A description whose frames are no longer those of the file is written by itself, as [`export`](super::export()) does,
/// with a warning.
///
/// # Errors
///
/// As [`export`](super::export()).
pub fn export_into(robot: &RawRobot, file: &str, text: &str) -> Result<(String, Vec<Diagnostic>), Vec<Diagnostic>> {
    let mut writer = Writer::new(robot);
    let followers = writer.check()?;
    let keys = robot.urdf.clone().unwrap_or_default();
    let weighed: Vec<&str> = robot.bodies.keys().map(String::as_str).collect();
    let request = Request { keys: &keys, units: robot.units, weighed: &weighed, locate: &|_| None };
    let outcome = built(file, text, &request, |builder, imported| {
        Into { builder, imported, writer: &mut writer, followers: &followers, edits: Vec::new() }.text()
    });
    let why = match outcome {
        Ok((_, Ok(text), _)) => return Ok((text, writer.diagnostics)),
        Ok((_, Err(why), _)) => why,
        Err(reported) => reported.first().map_or_else(String::new, |diagnostic| diagnostic.message.clone()),
    };
    let mut writer = Writer::new(robot);
    let diagnostic =
        Diagnostic::warning(format!("shapes, inertias, efforts and velocities of `{file}` are not kept: {why}"));
    writer.diagnostics.push(diagnostic.remedy("the URDF is written from the description alone"));
    whole(writer, &followers)
}

struct Into<'i, 'w, 'b, 'a> {
    builder: &'i Builder<'b, 'a>,
    /// What the file gives, SI.
    imported: &'i RawRobot,
    writer: &'i mut Writer<'w>,
    followers: &'i Followers<'w>,
    edits: Vec<(Range<usize>, String)>,
}

impl<'a> Into<'_, '_, '_, 'a> {
    /// The changed text; why there can be none.
    fn text(mut self) -> Result<String, String> {
        self.same_structure()?;
        let survey = self.builder.survey;
        self.writer.report_losses();
        self.writer.taken.extend((0..survey.links.len()).map(|link| survey.link(link).to_owned()));
        self.writer.taken.extend((0..survey.joints.len()).map(|joint| survey.joint(joint).to_owned()));
        let root = survey.link(self.builder.chain.root).to_owned();
        self.writer.links.insert("0".to_owned(), (root, Isometry::identity()));
        for joint in 0..survey.joints.len() {
            if let Some((frame, own)) = self.builder.carriers[self.builder.tree.carries[joint]]
                && frame == survey.joint(joint)
            {
                let link = survey.link(self.builder.tree.carries[joint]).to_owned();
                self.writer.links.insert(frame.to_owned(), (link, own));
                self.joint(joint, own);
                self.body(joint);
            }
        }
        self.link_bodies();
        let added = self.added();
        let Some(document) = survey.links.first().map(|link| link.node.document()) else { return Ok(String::new()) };
        let (xml, end) = (document.input_text(), document.root_element().range().end);
        let closing = xml.get(..end).and_then(|text| text.rfind("</")).unwrap_or(end);
        self.edits.push((closing..closing, added));
        self.edits.sort_by_key(|(at, _)| at.start);
        let (mut text, mut from) = (String::with_capacity(xml.len()), 0);
        for (at, by) in &self.edits {
            text.push_str(xml.get(from..at.start).unwrap_or(""));
            text.push_str(by);
            from = at.end;
        }
        text.push_str(xml.get(from..).unwrap_or(""));
        Ok(text)
    }

    /// Whether the frames of the file hang and move as they did.
    fn same_structure(&self) -> Result<(), String> {
        for (name, before) in &self.imported.frames {
            let robot = self.writer.robot;
            let same = robot.frames.get(name).is_some_and(|after| {
                after.antecedent == before.antecedent
                    && after.joint == before.joint
                    && after.variable.is_some() == before.variable.is_some()
                    && after.coaxial.is_none()
                    && (before.variable.is_some() || direction(after) == direction(before))
            });
            if !same {
                return Err(format!("the frame `{name}` is not placed or moved as in the file"));
            }
        }
        let survey = self.builder.survey;
        for joint in (0..survey.joints.len()).filter(|&joint| self.builder.tree.mimics[joint].is_some()) {
            let follower = self.followers.get(survey.joint(joint)).and_then(|follower| follower.master);
            let (factor, name) = (self.builder.follows(joint).0, survey.joint(self.builder.master(joint)));
            let same = follower.is_some_and(|(master, found)| master == name && (found - factor).abs() < ROUND_OFF);
            if self.imported.frames.contains_key(survey.joint(joint)) && !same {
                return Err(format!("the joint `{}` does not follow `{name}` as in the file", survey.joint(joint)));
            }
        }
        Ok(())
    }

    fn child(&self, node: Node<'a, 'a>, element: &str) -> Option<Node<'a, 'a>> {
        node.children().find(|child| child.is_element() && child.tag_name().name() == element)
    }

    /// Puts an element in the place of one of its name, or where `before` stands.
    fn put(&mut self, node: Node<'a, 'a>, element: &str, before: &str, text: String) {
        if let Some(found) = self.child(node, element) {
            self.edits.push((found.range(), text));
        } else if let Some(found) = self.child(node, before) {
            let at = found.range().start;
            self.edits.push((at..at, text + "\n    "));
        }
    }

    fn joint(&mut self, joint: usize, own: Isometry) {
        let (survey, name) = (self.builder.survey, self.builder.survey.joint(joint));
        let Some(frame) = self.writer.robot.frames.get(name) else { return };
        let node = survey.joints[joint].node;
        let sense = self.builder.direction(joint);
        let constant = self.followers.get(name).map_or(0.0, |follower| follower.constant);
        let constant = constant - sense * self.builder.follows(joint).1;
        let Some(parent) = self.parent(joint) else { return };
        let at = parent * self.writer.constants(frame, constant).isometry() * own.inverse();
        if !same_pose(&at, &self.builder.displaced(joint, 0.0)) {
            self.put(node, "origin", "parent", origin(&at));
        }
        if survey.joints[joint].kind == Kind::Fixed {
            return;
        }
        if direction(frame) != sense {
            let axis = -Vector3::from(survey.joints[joint].axis);
            self.put(node, "axis", "parent", format!("<axis xyz=\"{}\"/>", triple(&axis.map(|value| value + 0.0))));
        }
        self.limits(joint, frame);
    }

    /// Pose of the antecedent frame in the link on which a joint hangs.
    fn parent(&self, joint: usize) -> Option<Isometry> {
        let (_, parent) = self.builder.tree.above[self.builder.tree.carries[joint]]?;
        self.builder.carriers[parent].map(|(_, pose)| pose)
    }

    fn limits(&mut self, joint: usize, frame: &RawFrame) {
        let (survey, name) = (self.builder.survey, self.builder.survey.joint(joint));
        let unit = joint_unit(self.writer.robot, frame);
        let limits = frame.limits.map(|limits| limits.map(|limit| limit * unit));
        let before = self.imported.frames.get(name).and_then(|frame| frame.limits);
        let same = |a: [f64; 2], b: [f64; 2]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < ROUND_OFF);
        let Some(mut limits) = limits.filter(|&limits| !before.is_some_and(|before| same(limits, before))) else {
            return;
        };
        if self.builder.tree.mimics[joint].is_some() {
            // They bound the frame's joint variable, not the file's.
            let (sense, offset) = (self.builder.direction(joint), self.builder.follows(joint).1);
            limits = limits.map(|limit| sense * limit + offset);
            limits = [limits[0].min(limits[1]), limits[0].max(limits[1])];
        }
        let Some(node) =
            self.child(survey.joints[joint].node, "limit").filter(|_| limits.iter().all(|l| l.is_finite()))
        else {
            let message = format!("limits of `{name}` are not written: the joint of the file has none");
            return self.writer.diagnostics.push(Diagnostic::warning(message));
        };
        for (attribute, limit) in ["lower", "upper"].into_iter().zip(limits) {
            match node.attribute_node(attribute) {
                Some(found) => self.edits.push((found.range_value(), number(limit))),
                None => {
                    let at = node.range().start + "<limit".len();
                    self.edits.push((at..at, format!(" {attribute}=\"{}\"", number(limit))));
                }
            }
        }
    }

    /// Mass and centre, SI.
    fn described(&self, body: &RawBody) -> (f64, Vector3<f64>) {
        (body.mass.unwrap_or(0.0) * self.writer.robot.units.mass.factor(), self.writer.position(body.com).vector)
    }

    /// What a frame weighs more than in the file goes to the link of its joint.
    fn body(&mut self, joint: usize) {
        let (name, link) = (self.builder.survey.joint(joint), self.builder.tree.carries[joint]);
        let named = self.builder.survey.link(link);
        let own = named == name || !self.writer.robot.bodies.contains_key(named);
        let Some(body) = self.writer.robot.bodies.get(name).filter(|_| own) else { return };
        let (mass, centre) = self.described(body);
        // Links that the description names carry what it says; the frame's body is then that of its other links.
        let links = (0..self.builder.survey.links.len()).filter(|&other| other != link);
        let others = links.filter(|&other| self.builder.carriers[other].is_some_and(|(frame, _)| frame == name));
        let others = others.filter(|&other| !self.writer.robot.bodies.contains_key(self.builder.survey.link(other)));
        let (mut rest, mut moment) = (mass, centre * mass);
        for (mass, centre) in others.filter_map(|other| self.builder.weight(other)) {
            rest -= mass;
            moment -= centre * mass;
        }
        let Some((_, pose)) = self.builder.carriers[link] else { return };
        if rest.abs() <= ROUND_OFF * mass {
            rest = 0.0;
        }
        if rest < 0.0 {
            let message =
                format!("the mass of `{name}` is not written: less than the file gives to links attached to it");
            return self.writer.diagnostics.push(Diagnostic::warning(message));
        }
        let centre = if rest > 0.0 { (pose * Point3::from(moment / rest)).coords } else { Vector3::zeros() };
        self.weigh(link, rest, centre);
    }

    /// Bodies that the description gives by the name of a link.
    fn link_bodies(&mut self) {
        let survey = self.builder.survey;
        for link in 0..survey.links.len() {
            let name = survey.link(link);
            let known = self.builder.carriers[link].is_some() && !self.imported.frames.contains_key(name);
            if let Some(body) = self.writer.robot.bodies.get(name).filter(|_| known) {
                let (mass, centre) = self.described(body);
                self.weigh(link, mass, centre);
            }
        }
    }

    /// Changes the mass of a link where it has changed; the centre is in the link's frame.
    fn weigh(&mut self, link: usize, mass: f64, centre: Vector3<f64>) {
        let before = &self.builder.survey.links[link];
        let moved = (centre - Vector3::from(before.com)).norm() > ROUND_OFF * (1.0 + centre.norm());
        if (mass - before.mass).abs() <= ROUND_OFF * mass && (!moved || mass == 0.0) {
            return;
        }
        let node = before.node;
        let mass = format!("<mass value=\"{}\"/>", number(mass));
        let centre = format!("<origin xyz=\"{}\"/>", triple(&centre));
        if let Some(inertial) = self.child(node, "inertial") {
            self.put(inertial, "mass", "inertia", mass);
            if let Some(xyz) = self.child(inertial, "origin").and_then(|origin| origin.attribute_node("xyz")) {
                // The tensor keeps its axes.
                self.edits.push((xyz.range(), centre.trim_start_matches("<origin ").trim_end_matches("/>").to_owned()));
            } else {
                self.put(inertial, "origin", "mass", centre);
            }
            return;
        }
        let tensor = "<inertia ixx=\"0\" ixy=\"0\" ixz=\"0\" iyy=\"0\" iyz=\"0\" izz=\"0\"/>";
        let inertial = format!("<inertial>{centre}{mass}{tensor}</inertial>");
        let whole = node.document().input_text().get(node.range()).unwrap_or("");
        let end = node.range().end;
        if let Some(open) = whole.strip_suffix("/>") {
            let at = node.range().start + open.len();
            self.edits.push((at..end, format!(">{inertial}</link>")));
        } else {
            let at = node.range().start + whole.rfind("</").unwrap_or(whole.len());
            self.edits.push((at..at, inertial));
        }
    }

    /// Links and joints that the file has not.
    fn added(&mut self) -> String {
        let (robot, survey) = (self.writer.robot, self.builder.survey);
        let mut out = String::new();
        let frame = robot.tool.frame.as_deref().or(self.imported.tool.frame.as_deref()).unwrap_or("0");
        let at = self.pose(&robot.tool, self.writer);
        let placed = self.place_tool(frame, &at);
        let is_link = |name: &str| (0..survey.links.len()).any(|link| survey.link(link) == name);
        for (name, given) in &robot.frames {
            if !self.imported.frames.contains_key(name) && !is_link(name) {
                self.writer.link(&mut out, name, name);
                self.writer.joint(&mut out, name, given, self.followers.get(name.as_str()));
            }
        }
        // Among several ends a link with the name of a tool shows which it is.
        let called = self.builder.tool_joint.is_some_and(|joint| self.builder.called_tool(joint).is_some());
        if !placed || !(called || robot.markers.is_empty() && out.is_empty()) {
            let name = self.writer.free_name("tool0");
            self.writer.fixed_link(&mut out, &name, frame, &at);
        }
        for (marker, place) in &robot.markers {
            let name = self.writer.free_name(marker);
            let at = Isometry::from_parts(self.writer.position(place.at), nalgebra::Rotation3::identity());
            self.writer.fixed_link(&mut out, &name, place.frame.as_deref().unwrap_or(frame), &at);
        }
        out
    }

    /// Brings the link that is the tool's in the file to where the tool is in its frame; whether it is there.
    fn place_tool(&mut self, frame: &str, at: &Isometry) -> bool {
        let si = RawRobot::default();
        let nominal = self.pose(&self.imported.tool, &Writer::new(&si));
        let (tree, survey) = (self.builder.tree, self.builder.survey);
        let Some(joint) = self.builder.tool_joint.filter(|_| self.imported.tool.frame.as_deref() == Some(frame)) else {
            return false;
        };
        if same_pose(at, &nominal) {
            return true;
        }
        let link = tree.carries[joint];
        let alone = survey.joints[joint].kind == Kind::Fixed && tree.leaving[link].is_empty();
        let (true, Some(parent)) = (alone && survey.links[link].mass == 0.0, self.parent(joint)) else { return false };
        let constants = |writer: &Writer, name: &str| {
            writer.robot.frames.get(name).map(|frame| writer.constants(frame, 0.0).isometry())
        };
        let own = constants(self.writer, frame).filter(|_| frame == survey.joint(joint));
        let node = survey.joints[joint].node;
        self.edits.retain(|(range, _)| !node.range().contains(&range.start));
        self.put(node, "origin", "parent", origin(&(parent * own.unwrap_or_else(Isometry::identity) * at)));
        // Frames that stay where they were in the body are now elsewhere in the link.
        let name = survey.link(link).to_owned();
        let back = at.inverse();
        if let Some(link_frame) = constants(self.writer, &name).filter(|_| frame != name) {
            self.writer.links.insert(name.clone(), (name.clone(), back * link_frame));
        }
        if own.is_some() {
            self.writer.links.insert(frame.to_owned(), (name, back));
        }
        true
    }

    fn pose(&self, tool: &RawTool, writer: &Writer) -> Isometry {
        Isometry::from_parts(writer.position(tool.at), writer.rotation(tool.rotation))
    }
}

fn same_pose(a: &Isometry, b: &Isometry) -> bool {
    let shift = (a.translation.vector - b.translation.vector).norm();
    shift < ROUND_OFF * (1.0 + b.translation.vector.norm())
        && (a.rotation.matrix() - b.rotation.matrix()).amax() < ROUND_OFF
}
