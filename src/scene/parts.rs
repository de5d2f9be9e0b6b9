//! Parts of a robot, read off its description.

use nalgebra::{Rotation3, Vector3};

use super::{Beam, Drive, Form, Part, PartKind, Point, Scene, Spot};
use crate::description::elastic::Section;
use crate::description::raw::{JointKind, SectionShape};
use crate::description::robot::{FrameIndex, Motion, Robot};
use crate::elements::VertexIndex;
use crate::kinematics::{Geometry, Placements};
use crate::model::Model;

/// Length of axes over the robot's size.
const AXIS: f64 = 0.06;
/// Below this (m) a length is not drawn.
const LEAST: f64 = 1e-6;
/// Points around a round section.
const ROUND: usize = 10;

/// Draws up the scene of a robot. `geometry` holds the values of lengths, `placements` any configuration, whose size sets
/// that of axes.
pub fn draw(robot: &Robot, geometry: &Geometry, placements: &Placements) -> Scene {
    let mut drawing = Drawing { robot, model: geometry.model, values: geometry.values(), scene: Scene::default() };
    let reach = placements.frames.iter().map(|frame| frame.translation.vector.norm()).fold(0.0, f64::max);
    drawing.scene.axis = AXIS * if reach > LEAST { reach } else { 1.0 };
    for frame in 1..drawing.model.frames.len() {
        drawing.link(frame);
    }
    drawing.beams();
    for frame in 0..drawing.model.frames.len() {
        drawing.frame(frame);
    }
    drawing.loops();
    drawing.actuators();
    drawing.springs();
    drawing.masses();
    drawing.measured(geometry);
    drawing.scene
}

struct Drawing<'a> {
    robot: &'a Robot,
    model: &'a Model,
    values: &'a [f64],
    scene: Scene,
}

impl Drawing<'_> {
    /// A point of a frame that yields with the nearest vertex of the frame's body.
    fn at(&mut self, frame: FrameIndex, local: Vector3<f64>) -> usize {
        let vertex = self.model.structure.carrier(frame, &local);
        self.point(Spot::At(frame, local), vertex)
    }

    fn point(&mut self, spot: Spot, vertex: VertexIndex) -> usize {
        self.scene.points.push(Point { spot, vertex });
        self.scene.points.len() - 1
    }

    fn add(&mut self, kind: PartKind, name: &str, words: String, points: Vec<usize>) -> &mut Part {
        let part = Part { kind, name: name.into(), words, form: None, drive: None, sites: Vec::new(), points };
        self.scene.parts.push(part);
        let last = self.scene.parts.len() - 1;
        &mut self.scene.parts[last]
    }

    /// The antecedent's body up to a frame: along b, d and r.
    fn link(&mut self, index: FrameIndex) {
        let frame = &self.model.frames[index];
        let (name, antecedent) = (frame.name.clone(), frame.antecedent);
        let [beta, gamma, b, _, d, ..] = frame.slots.map(|slot| self.values[slot]);
        let tilt = Rotation3::from_axis_angle(&Vector3::y_axis(), beta);
        let foot = tilt * Vector3::z() * b;
        let turned = tilt * Rotation3::from_axis_angle(&Vector3::z_axis(), gamma);
        let end = foot + turned * Vector3::x() * d;
        let mut points = vec![self.at(antecedent, Vector3::zeros())];
        let mut last = Vector3::zeros();
        for corner in [foot, end] {
            if (corner - last).norm() > LEAST {
                points.push(self.at(antecedent, corner));
                last = corner;
            }
        }
        points.push(self.at(index, Vector3::zeros()));
        let from = self.model.frames[antecedent].name.clone();
        let part = self.add(PartKind::Link, &from, format!("body {from}, up to frame {name}"), points);
        part.sites = vec![format!("link:{from}"), format!("frame:{name}")];
        if antecedent == 0 {
            part.sites.push("base".into());
        }
    }

    /// A frame's axes, and its joint.
    fn frame(&mut self, index: FrameIndex) {
        let frame = &self.model.frames[index];
        let (name, joint, motion, limits) = (frame.name.clone(), frame.joint, frame.motion, frame.limits);
        let axis = self.scene.axis;
        let origin = self.at(index, Vector3::zeros());
        let tips: Vec<usize> =
            [Vector3::x(), Vector3::y(), Vector3::z()].map(|unit| self.at(index, unit * axis)).to_vec();
        let words = if index == 0 { "base frame".to_string() } else { format!("frame {name}") };
        self.add(PartKind::Frame, &name, words, [vec![origin], tips.clone()].concat()).sites =
            vec![if index == 0 { "base".into() } else { format!("frame:{name}") }];
        if index == 0 {
            return;
        }
        let (form, what) = match joint {
            JointKind::Revolute => (Form::Revolute, "turns"),
            JointKind::Prismatic => (Form::Prismatic, "slides"),
            JointKind::Fixed => return,
        };
        let (drive, by) = match motion {
            Motion::Fixed => return,
            Motion::Variable { index, .. } => (Drive::Variable, self.model.variables[index].name.clone()),
            Motion::Actuator(which) => (Drive::Actuator, self.model.actuators[which].name.clone()),
            Motion::Coupling(_) => (Drive::Coupling, "a coupling".into()),
            Motion::Passive => (Drive::Passive, "its loop".into()),
        };
        let mut words = format!("joint {name} {what} by {by}");
        if let Some([low, high]) = limits {
            let (size, unit) =
                if joint == JointKind::Revolute { (180.0 / std::f64::consts::PI, "deg") } else { (1e3, "mm") };
            words += &format!(", {:.1} to {:.1} {unit}", low * size, high * size);
        }
        let sites = vec![format!("joint:{name}")];
        let part = self.add(PartKind::Joint, &name, words, vec![origin, tips[2]]);
        (part.form, part.drive, part.sites) = (Some(form), Some(drive), sites);
    }

    fn loops(&mut self) {
        for closed in &self.robot.loops {
            let points = closed.frames.map(|frame| self.at(frame, Vector3::zeros())).to_vec();
            let [a, b] = closed.frames.map(|frame| self.model.frames[frame].name.clone());
            let words = format!("loop {} closes where frames {a} and {b} meet", closed.name);
            self.add(PartKind::Cut, &closed.name, words, points);
        }
    }

    fn actuators(&mut self) {
        for (index, actuator) in self.model.actuators.iter().enumerate() {
            let antecedent = self.model.frames[actuator.joint].antecedent;
            let ground = self.model.structure.carrier(antecedent, &Vector3::zeros());
            let moved = self.model.structure.carrier(actuator.joint, &Vector3::zeros());
            let points = vec![self.point(Spot::Pin(index, 0), ground), self.point(Spot::Pin(index, 1), moved)];
            let (joint, variable) =
                (self.model.frames[actuator.joint].name.clone(), self.model.variables[actuator.variable].name.clone());
            let words = format!("actuator {}, length {variable}, turns joint {joint}", actuator.name);
            let sites = vec![format!("actuator:{}", actuator.name)];
            self.add(PartKind::Actuator, &actuator.name, words, points).sites = sites;
        }
    }

    fn beams(&mut self) {
        let elastic = &self.robot.elastic;
        for (index, beam) in elastic.beams.iter().enumerate() {
            let nodes = beam.nodes.map(|node| &elastic.nodes[node]);
            let ends = nodes.map(|node| (node.at, node.point));
            self.scene.beams.push(Beam { nodes: ends, normal: beam.normal });
            let vertex =
                |name: &str| self.model.structure.nodes.iter().find(|(known, _)| known == name).map_or(0, |n| n.1);
            let vertices = nodes.map(|node| vertex(&node.name));
            let round = beam.sections.iter().all(|&at| elastic.sections.get_index(at).is_some_and(|s| is_round(s.1)));
            let mut points = Vec::new();
            for (end, vertex) in vertices.into_iter().enumerate() {
                let Some((_, section)) = elastic.sections.get_index(beam.sections[end]) else { continue };
                let corners = outline(section, round);
                points.extend(corners.into_iter().map(|corner| {
                    self.scene.points.push(Point { spot: Spot::Corner(index, end, corner), vertex });
                    self.scene.points.len() - 1
                }));
            }
            let of = |end: usize| elastic.sections.get_index(beam.sections[end]);
            let described: Vec<String> = (0..2).filter_map(of).map(|(name, section)| in_words(name, section)).collect();
            let section = match described.as_slice() {
                [a, b] if a != b => format!("{a} to {b}"),
                _ => described.first().cloned().unwrap_or_default(),
            };
            let material = elastic.materials.get_index(beam.material).map_or("", |(name, _)| name.as_str());
            let words =
                format!("beam {} from {} to {}: {section}, {material}", beam.name, nodes[0].name, nodes[1].name);
            let body = self.model.frames[nodes[0].body].name.clone();
            let part = self.add(PartKind::Beam, &beam.name, words, points);
            part.form = Some(if round { Form::Round } else { Form::Box });
            part.sites = vec![format!("link:{body}")];
        }
    }

    fn springs(&mut self) {
        for spring in &self.robot.elastic.springs {
            let points =
                vec![self.at(spring.bodies[0], spring.anchors[0]), self.at(spring.bodies[1], spring.anchors[1])];
            let [a, b] = spring.bodies.map(|body| self.model.frames[body].name.clone());
            let rate = spring.rate.nominal;
            let words = format!("spring {} between bodies {a} and {b}, {:.4e} N/m", spring.name, rate);
            let sites = vec![format!("spring:{}", spring.name)];
            self.add(PartKind::Spring, &spring.name, words, points).sites = sites;
        }
    }

    fn masses(&mut self) {
        for body in &self.robot.elastic.bodies {
            let name = self.model.frames[body.frame].name.clone();
            let point = self.at(body.frame, body.com);
            let words = format!("centre of mass of body {name}, {:.3} kg", body.mass);
            self.add(PartKind::Mass, &name, words, vec![point]);
        }
    }

    /// Tool, markers, anchors of the instrument.
    fn measured(&mut self, geometry: &Geometry) {
        let (frame, tool, axis) = (self.model.tool.0, geometry.tool(), self.scene.axis);
        let from = self.at(frame, Vector3::zeros());
        let origin = tool.translation.vector;
        let mut points = vec![from, self.at(frame, origin)];
        for unit in [Vector3::x(), Vector3::y(), Vector3::z()] {
            points.push(self.at(frame, origin + tool.rotation * unit * axis));
        }
        self.add(PartKind::Tool, "tool", "tool centre point".into(), points).sites = vec!["tool".into()];
        for (index, marker) in self.model.markers.iter().enumerate() {
            let points =
                vec![self.at(marker.frame, Vector3::zeros()), self.at(marker.frame, geometry.marker(index).coords)];
            self.add(PartKind::Marker, &marker.name, format!("marker {}", marker.name), points);
        }
        for (name, anchor) in &self.model.anchors {
            let point = self.point(Spot::Measured(*anchor), 0);
            self.add(PartKind::Anchor, name, format!("anchor {name} of the instrument"), vec![point]).sites =
                vec!["instrument".into()];
        }
    }
}

fn value(section: &Section, symbol: &str) -> f64 {
    section.values.iter().find(|(known, _)| *known == symbol).map_or(0.0, |(_, value)| *value)
}

fn is_round(section: &Section) -> bool {
    matches!(section.shape, Some(SectionShape::Tube | SectionShape::Rod) | None)
}

/// Outline of a section along local y and z, m: its corners, or points around it. One that is given by its area alone is
/// drawn as a rod of that area.
fn outline(section: &Section, round: bool) -> Vec<[f64; 2]> {
    let (width, height) = match section.shape {
        None => [2.0 * (value(section, "area") / std::f64::consts::PI).max(0.0).sqrt(); 2].into(),
        Some(SectionShape::Tube | SectionShape::Rod) => [value(section, "diameter"); 2].into(),
        Some(_) => (value(section, "width"), value(section, "height")),
    };
    let (y, z) = (0.5 * width, 0.5 * height);
    if !round {
        return vec![[-y, -z], [y, -z], [y, z], [-y, z]];
    }
    let turn = std::f64::consts::TAU / ROUND as f64;
    (0..ROUND).map(|k| (turn * k as f64).sin_cos()).map(|(sine, cosine)| [y * cosine, z * sine]).collect()
}

fn in_words(name: &str, section: &Section) -> String {
    let mm = |symbol: &str| format!("{:.0}", 1e3 * value(section, symbol));
    match section.shape {
        Some(SectionShape::Box) => format!("{name}, box {} x {} x {} mm", mm("width"), mm("height"), mm("wall")),
        Some(SectionShape::Rectangle) => format!("{name}, {} x {} mm", mm("width"), mm("height")),
        Some(SectionShape::I) => format!("{name}, I {} x {} mm", mm("width"), mm("height")),
        Some(SectionShape::Tube) => format!("{name}, tube {} x {} mm", mm("diameter"), mm("wall")),
        Some(SectionShape::Rod) => format!("{name}, rod {} mm", mm("diameter")),
        None => format!("{name}, area {:.0} mm2", 1e6 * value(section, "area")),
    }
}
