//! Beams between nodes, with what their ends are released in, and links whose give nobody declared.

use std::sync::Arc;

use nalgebra::Vector3;

use super::Fault;
use super::builder::Builder;
use super::structure::{Boom, Edge, Spot};
use crate::description::elastic;
use crate::description::raw::{BeamTheory, JointKind};
use crate::description::robot::{FrameIndex, PLACEMENT_SYMBOLS};
use crate::diagnostic::Diagnostic;
use crate::elements::{Axes, Beam, BodyPoint, Law, Lumped, Normal, Rigidity, VertexIndex};
use crate::parameter::Kind;

/// Sine of the angle to a slide below which a beam lies along it, 10 deg: others turn as they get shorter, and keep a length.
const ALONG: f64 = 0.17;

impl Builder<'_> {
    /// Every link of a rigid body that carries another joint could be a beam: its compliances are parameters at zero.
    pub(super) fn links(&mut self) {
        for index in 1..self.robot.frames.len() {
            let rigid = self.structure.bodies[index].len() == 1
                && !self.robot.elastic.nodes.iter().any(|node| self.root(node.body) == index);
            if self.robot.frames[index].joint == JointKind::Fixed || !rigid {
                continue;
            }
            let own = self.structure.home[index].translation.vector;
            let children: Vec<FrameIndex> = (index + 1..self.robot.frames.len())
                .filter(|&child| {
                    self.robot.frames[child].joint != JointKind::Fixed
                        && self.root(self.robot.frames[child].antecedent) == index
                })
                .collect();
            let Some(&far) = children
                .iter()
                .filter(|&&child| (self.structure.home[child].translation.vector - own).norm() > 1e-3)
                .find(|&&child| self.robot.frames[child].joint == JointKind::Revolute)
            else {
                continue;
            };
            let name = &self.robot.frames[index].name;
            let unit = Kind::Other("1/(N.m2)");
            let slots = ["bending_y", "bending_z", "torsion"]
                .map(|symbol| self.plain(format!("link{name}.{symbol}"), unit, 0.0, [0.0, f64::INFINITY], 1e-7));
            let near = self.structure.bodies[index][0];
            let end = self.vertex(format!("end of link {name}"), Spot::At(far, Vector3::zeros()));
            // Every frame of this body may be carried by either end; joints further out find the nearer one.
            for frame in 0..self.robot.frames.len() {
                if self.root(frame) == index {
                    self.structure.bodies[frame] = vec![near, end];
                }
            }
            for edge in &mut self.edges {
                let joins_far = children.iter().any(|&child| {
                    edge.name == format!("joint:{}", self.robot.frames[child].name)
                        && (self.structure.home[child].translation.vector - self.structure.home[far].translation.vector)
                            .norm()
                            < (self.structure.home[child].translation.vector - own).norm()
                });
                if joins_far {
                    for vertex in &mut edge.ends {
                        if *vertex == near {
                            *vertex = end;
                        }
                    }
                }
            }
            let normal = self.normal(index, [near, end].map(|end| self.structure.at_home(end)));
            let element = Arc::new(Beam { normal, rigidity: Rigidity::Inverse(slots) });
            self.edges.push(Edge { name: format!("link:{name}"), ends: [near, end], element });
        }
    }

    /// The axis of a frame that sets a beam's local z: z, or x where that lies along the beam.
    fn normal(&self, frame: FrameIndex, [a, b]: [Vector3<f64>; 2]) -> Normal {
        let z = self.structure.home[frame] * Vector3::z();
        Normal { frame, axis: if z.cross(&(b - a)).norm() < 1e-3 * (b - a).norm() { 0 } else { 2 } }
    }

    pub(super) fn beams(&mut self) {
        let named = |builder: &Self, node: usize| {
            let name = &builder.robot.elastic.nodes[node].name;
            builder.structure.nodes.iter().find(|(known, _)| known == name).map(|n| n.1)
        };
        for beam in &self.robot.elastic.beams {
            let (Some(first), Some(last)) = (named(self, beam.nodes[0]), named(self, beam.nodes[1])) else { continue };
            let length = (self.structure.at_home(first) - self.structure.at_home(last)).norm();
            if length < 1e-9 {
                let message = format!("beam `{}` has no length: its two nodes lie at one point", beam.name);
                let remedy = "name two nodes that lie apart (of a boom that slides, in the middle of its `limits`), or leave it out";
                let diagnostic = Diagnostic::error(message).remedy(remedy);
                self.faults.push(Fault::new(&["beams", &beam.name], diagnostic));
                continue;
            }
            if let Some(boom) = self.boom(beam, [first, last]) {
                if let Some(fault) = self.drawn_in(&boom, length) {
                    self.faults.push(fault);
                    continue;
                }
                self.structure.booms.push(boom);
            }
            let normal = self.normal(beam.normal, [first, last].map(|end| self.structure.at_home(end)));
            let parts = beam.elements.max(1);
            let points = beam.nodes.map(|node| self.node(node));
            let own = Axes::Beam(points, normal);
            let [a, b] = beam.sections;
            let section = |index: usize| self.structure.sections[index].clone();
            let sections = (section(a), (a != b).then(|| section(b)));
            let material = self.structure.materials[beam.material];
            let [near, far] = std::array::from_fn(|end| self.released(beam, end, [first, last][end], own));
            let mut previous = near;
            for part in 0..parts {
                let share = [part as f64 / parts as f64, (part + 1) as f64 / parts as f64];
                let middle = 0.5 * (share[0] + share[1]);
                let next = if part + 1 == parts {
                    far
                } else {
                    self.vertex(format!("{}/{}", beam.name, part + 1), Spot::Between([first, last], share[1]))
                };
                let shear = beam.theory == BeamTheory::Timoshenko;
                let rigidity = Rigidity::Section { sections: sections.clone(), middle, material, shear };
                let element = Arc::new(Beam { normal, rigidity });
                self.edges.push(Edge { name: format!("beam:{}", beam.name), ends: [previous, next], element });
                previous = next;
            }
        }
    }

    /// A beam along the slide of the prismatic joint of its body, one end of which moves with it, and the other does not.
    fn boom(&self, beam: &elastic::Beam, ends: [VertexIndex; 2]) -> Option<Boom> {
        let nodes = beam.nodes.map(|node| &self.robot.elastic.nodes[node]);
        let frame = self.root(nodes[0].body);
        let moves = nodes.map(|node| self.root(node.at) == frame);
        let along = self.structure.at_home(ends[1]) - self.structure.at_home(ends[0]);
        let axis = self.structure.home[frame] * Vector3::z();
        let is_along = axis.dot(&along) > 0.0;
        let is_parallel = axis.cross(&along).norm() < ALONG * along.norm();
        let is_prismatic = self.robot.frames[frame].joint == JointKind::Prismatic;
        let slides = is_prismatic && is_parallel && moves[0] != moves[1];
        slides.then(|| Boom { name: beam.name.clone(), ends, frame, second_slides: moves[1], is_along })
    }

    /// Of a boom: limits of its joint within which nothing of it is out of its sleeve. Its length (m) is that with the slide in the middle of
    /// them.
    fn drawn_in(&self, beam: &Boom, length: f64) -> Option<Fault> {
        let frame = &self.robot.frames[beam.frame];
        let [low, high] = frame.limits.filter(|limits| limits.iter().all(|limit| limit.is_finite()))?;
        let along = (self.structure.at_home(beam.ends[1]) - self.structure.at_home(beam.ends[0])) / length;
        let axis = (self.structure.home[beam.frame] * Vector3::z()).dot(&along);
        let rate = if beam.second_slides { axis } else { -axis };
        let at = if rate > 0.0 { low } else { high };
        let least = length + rate * (at - 0.5 * (low + high));
        if least > 0.0 {
            return None;
        }
        let message = format!(
            "beam `{}` is drawn into its sleeve within the limits of joint `{}`: at {:.4} m it is {least:.4} m long",
            beam.name, frame.name, at
        );
        let remedy = format!("narrow `limits` of frame `{}`, or look at where the sleeve ends", frame.name);
        Some(Fault::new(&["beams", &beam.name], Diagnostic::error(message).remedy(remedy)))
    }

    /// The vertex that an end of a beam holds: its node's, or one of its own where it is released from that.
    fn released(&mut self, beam: &elastic::Beam, end: usize, node: VertexIndex, axes: Axes) -> VertexIndex {
        let released = beam.released[end];
        if !released.contains(&true) {
            return node;
        }
        let at = self.node(beam.nodes[end]);
        let own = self.vertex(&self.robot.elastic.nodes[beam.nodes[end]].name, Spot::At(at.frame, at.point));
        let laws = released.map(|free| if free { Law::Released(None) } else { Law::Rigid });
        let (symbols, end_of) = (PLACEMENT_SYMBOLS, Some(beam.name.clone()));
        let name = format!("release:{}.{}", beam.name, ["from", "to"][end]);
        let element = Arc::new(Lumped { at, axes, laws, symbols, end_of, in_plane: false });
        self.edges.push(Edge { name, ends: [node, own], element });
        own
    }

    /// Where a node is.
    pub(super) fn node(&self, node: usize) -> BodyPoint {
        let node = &self.robot.elastic.nodes[node];
        BodyPoint { frame: node.at, point: node.point }
    }
}
