//! Builds the elastic structure of a resolved robot.

use std::sync::Arc;

use nalgebra::{Isometry3, Rotation3, Translation3, Vector3};

use super::builder::Builder;
use super::structure::{Edge, MassElement, Spot, Structure};
use super::{Fault, Model};
use crate::description::elastic::{BASE_SYMBOLS, Node, Shear, Stiffness, own_axis};
use crate::description::parameters::{
    ANCHORS, AXIAL, CENTRE, DENSITY, FREE_LENGTH, JOINT, MASS, Owner, PEDESTAL, POISSON, RATE, SECTION, SHEAR, YOUNG,
    joint_directions, joint_springs,
};
use crate::description::raw::{JointKind, LoadPath, LoopKind, Meet, Support};
use crate::description::robot::{Frame, FrameIndex, Motion, Robot};
use crate::elements::{
    Axes, BodyPoint, Law, Lumped, Material, Screw, ScrewTriangle, Section, Spring, VertexIndex, screw_pins,
};

/// Symbols of lumped springs at the cut of a loop: along x, y, z, about x, y, z.
const LUMPED: [&str; 6] = ["kr", "kr", "ka", "krr", "krr", "kar"];

/// Adds the elastic parameters to the model's registry and builds its structure.
pub fn assemble(robot: &Robot, model: &mut Model) -> Result<Structure, Vec<Fault>> {
    let structure = Structure { gravity: robot.elastic.gravity, home: home(robot), ..Structure::default() };
    let mut builder =
        Builder { robot, model, structure, edges: Vec::new(), only_closing: Vec::new(), faults: Vec::new() };
    builder.sections();
    builder.vertices();
    builder.base();
    builder.joints();
    builder.links();
    builder.beams();
    builder.loops();
    builder.loads();
    if !builder.faults.is_empty() {
        return Err(builder.faults);
    }
    builder.hang()
}

/// Frames with all joints at zero, but for slides, which are in the middle of their limits: a boom is out of its sleeve there.
fn home(robot: &Robot) -> Vec<Isometry3<f64>> {
    let out = |frame: &Frame| match frame.limits {
        Some([low, high]) if frame.joint == JointKind::Prismatic && (high - low).is_finite() => 0.5 * (low + high),
        _ => 0.0,
    };
    let mut home: Vec<Isometry3<f64>> = Vec::with_capacity(robot.frames.len());
    for frame in &robot.frames {
        let c = &frame.constants;
        let turn = |axis: nalgebra::Unit<Vector3<f64>>, angle: f64| -> Isometry3<f64> {
            Isometry3::from_parts(
                Translation3::identity(),
                nalgebra::UnitQuaternion::from_rotation_matrix(&Rotation3::from_axis_angle(&axis, angle)),
            )
        };
        let own = turn(Vector3::y_axis(), c.beta)
            * turn(Vector3::z_axis(), c.gamma)
            * Translation3::new(0.0, 0.0, c.b)
            * turn(Vector3::x_axis(), c.alpha)
            * Translation3::new(c.d, 0.0, 0.0)
            * turn(Vector3::z_axis(), c.theta)
            * Translation3::new(0.0, 0.0, c.r + out(frame));
        home.push(match home.get(frame.antecedent) {
            Some(antecedent) => antecedent * own,
            None => Isometry3::identity(),
        });
    }
    home
}

impl Builder<'_> {
    fn sections(&mut self) {
        let elastic = &self.robot.elastic;
        for (name, material) in &elastic.materials {
            let owner = Owner::Material(name);
            let young = self.number(owner, &YOUNG, material.young);
            let (shear, is_poisson) = match material.shear {
                Shear::Modulus(modulus) => (self.number(owner, &SHEAR, modulus), false),
                Shear::Poisson(ratio) => (self.number(owner, &POISSON, ratio), true),
            };
            let density = self.number(owner, &DENSITY, material.density);
            self.structure.materials.push(Material { young, shear, is_poisson, density });
        }
        for (name, section) in &elastic.sections {
            let slots = section.values.iter().filter_map(|&(symbol, value)| {
                let row = SECTION.iter().find(|row| row.symbol == symbol)?;
                Some((symbol, self.number(Owner::Section(name), row, value)))
            });
            let slots = slots.collect();
            self.structure.sections.push(Section { shape: section.shape, slots });
        }
    }

    fn vertices(&mut self) {
        self.vertex("ground", Spot::At(0, Vector3::zeros()));
        let robot = self.robot;
        let elastic = &robot.elastic;
        let mut bodies: Vec<Vec<VertexIndex>> = vec![Vec::new(); robot.frames.len()];
        for (index, node) in elastic.nodes.iter().enumerate() {
            let used = elastic.beams.iter().any(|beam| beam.nodes.contains(&index)) || node.support.is_some();
            if used {
                let vertex = self.vertex(&node.name, Spot::At(node.at, node.point));
                bodies[self.root(node.body)].push(vertex);
                self.structure.nodes.push((node.name.clone(), vertex));
            }
        }
        for (frame, of) in robot.frames.iter().enumerate() {
            if self.root(frame) == frame && bodies[frame].is_empty() {
                let vertex = self.vertex(&of.name, Spot::At(frame, Vector3::zeros()));
                bodies[frame].push(vertex);
            }
        }
        for frame in 0..robot.frames.len() {
            bodies[frame] = bodies[self.root(frame)].clone();
        }
        self.structure.bodies = bodies;
    }

    fn base(&mut self) {
        let springs = self.robot.elastic.base;
        let laws = std::array::from_fn(|k| Law::Compliance(self.compliance(Owner::Pedestal, &PEDESTAL[k], springs[k])));
        let mut supported = false;
        for (index, node) in self.robot.elastic.nodes.iter().enumerate() {
            let Some(support) = node.support else { continue };
            supported |= self.root(node.body) == 0;
            let laws = match support {
                Support::Fixed => [Law::Rigid; 6],
                Support::Pinned => std::array::from_fn(|k| if k < 3 { Law::Rigid } else { Law::Released(None) }),
            };
            let vertex = self.structure.nodes.iter().find(|(name, _)| *name == node.name).map_or(0, |n| n.1);
            let element = Arc::new(Lumped { at: self.node(index), laws, ..Lumped::rigid(0, BASE_SYMBOLS) });
            self.edges.push(Edge { name: format!("support:{}", node.name), ends: [0, vertex], element });
        }
        if !supported {
            let element = Arc::new(Lumped { laws, ..Lumped::rigid(0, BASE_SYMBOLS) });
            let vertex = self.carrier(0, &Vector3::zeros());
            self.edges.push(Edge { name: "base".into(), ends: [0, vertex], element });
        }
    }

    fn joints(&mut self) {
        for (index, frame) in self.robot.frames.iter().enumerate().skip(1) {
            if frame.joint == JointKind::Fixed {
                continue;
            }
            let declared = self.robot.elastic.joints.iter().find(|joint| joint.frame == index);
            let springs = declared.map_or([None; 8], |joint| joint.springs);
            let axis = own_axis(frame.joint);
            let screw = match frame.motion {
                Motion::Actuator(which) => self.model.actuators.iter().position(|a| a.joint == index).zip(Some(which)),
                _ => None,
            };
            let owner = Owner::Joint(&frame.name);
            let directions = joint_directions(|k| springs[k].is_some());
            let mut slots = [0; 8];
            for k in joint_springs(directions) {
                // A passive axis is free, or held by a soft spring: a stiffness, zero where none is given.
                slots[k] = if frame.motion == Motion::Passive && k == axis {
                    let given = springs[k].unwrap_or(Stiffness::undeclared(JOINT[k].kind));
                    self.stiffness(owner.parameter(JOINT[k].symbol), given, (0.3 * given.nominal).max(1.0))
                } else {
                    // What the screw holds is free of itself, and the joint's own spring is then rigid.
                    self.compliance(owner, &JOINT[k], springs[k].filter(|given| given.nominal.is_finite()))
                };
            }
            let mut laws = directions.map(|k| Law::Compliance(slots[k]));
            let (symbols, kar) = (directions.map(|k| JOINT[k].symbol), slots[2]);
            let along = if axis == 0 { 2 } else { 5 };
            if frame.motion == Motion::Passive {
                laws[along] = Law::Released(Some(slots[axis]));
            }
            if let Some((actuator, which)) = screw {
                let given = self.robot.elastic.screws.get(&which).copied();
                let owner = Owner::Actuator(&self.robot.actuators[which].name);
                let axial = self.compliance(owner, &AXIAL, given.map(|screw| screw.axial));
                let triangle = self.triangle(actuator);
                if given.is_some_and(|screw| screw.path == LoadPath::Pins) {
                    laws[along] = Law::Released(None);
                    let ends = [frame.antecedent, index].map(|body| self.structure.bodies[body][0]);
                    let element = Arc::new(Screw { triangle, own: kar, axial });
                    let name = format!("actuator:{}", self.model.actuators[actuator].name);
                    self.only_closing.push(Edge { name, ends: self.pins(index, ends, actuator), element });
                } else {
                    laws[along] = Law::Driven { own: kar, axial, screw: triangle };
                }
            }
            let origin = BodyPoint { frame: index, point: Vector3::zeros() };
            let at = declared.and_then(|joint| joint.at).or_else(|| self.sleeve(index));
            let at = at.map_or(origin, |node| self.node(node));
            let home = (self.structure.home[at.frame] * nalgebra::Point3::from(at.point)).coords;
            let ends = [self.carrier(frame.antecedent, &home), self.carrier(index, &home)];
            let element =
                Arc::new(Lumped { at, axes: Axes::Frame(index), laws, symbols, ..Lumped::rigid(index, BASE_SYMBOLS) });
            self.edges.push(Edge { name: format!("joint:{}", frame.name), ends, element });
        }
    }

    /// The node at which a boom leaves its sleeve: the end of a beam of what a prismatic joint moves, at a point of the
    /// antecedent's body.
    fn sleeve(&self, joint: FrameIndex) -> Option<usize> {
        let frame = &self.robot.frames[joint];
        let (own, antecedent) = (self.root(joint), self.root(frame.antecedent));
        let mut nodes = self.robot.elastic.nodes.iter().enumerate();
        let is_sleeve = |(index, node): (usize, &Node)| {
            self.root(node.body) == own
                && self.root(node.at) == antecedent
                && self.robot.elastic.beams.iter().any(|beam| beam.nodes.contains(&index))
        };
        let found = nodes.position(is_sleeve)?;
        (frame.joint == JointKind::Prismatic).then_some(found)
    }

    fn triangle(&self, actuator: usize) -> ScrewTriangle {
        let actuator = &self.model.actuators[actuator];
        let frame = &self.model.frames[actuator.joint];
        ScrewTriangle { joint: actuator.joint, slot: actuator.slot, moving: frame.moving_slot(), home: frame.home }
    }

    /// Vertices nearest to the two pins of a screw.
    fn pins(&self, joint: FrameIndex, default: [VertexIndex; 2], actuator: usize) -> [VertexIndex; 2] {
        let Some(screw) = self.model.actuators.get(actuator) else { return default };
        let values: Vec<f64> = (0..5).map(|k| self.model.registry[screw.slot + k].nominal).collect();
        let home = &self.structure.home[joint];
        let [fixed, moving] = screw_pins(&values, 0.0);
        let at = |point: Vector3<f64>| (home * nalgebra::Point3::from(point)).coords;
        [self.carrier(self.robot.frames[joint].antecedent, &at(fixed)), self.carrier(joint, &at(moving))]
    }

    fn loops(&mut self) {
        for closed in &self.robot.loops {
            let [a, b] = closed.frames;
            let mut laws = [Law::Rigid; 6];
            if closed.meet == Meet::Origin {
                let free: &[usize] = if closed.kind == LoopKind::Planar { &[5] } else { &[3, 4, 5] };
                free.iter().for_each(|&k| laws[k] = Law::Released(None));
            }
            let end = |frame: FrameIndex| self.carrier(frame, &self.structure.home[frame].translation.vector);
            let in_plane = closed.kind == LoopKind::Planar;
            let element = Arc::new(Lumped { laws, in_plane, ..Lumped::rigid(a, LUMPED) });
            self.edges.push(Edge { name: format!("loop:{}", closed.name), ends: [end(a), end(b)], element });
        }
    }

    fn loads(&mut self) {
        for body in &self.robot.elastic.bodies {
            let owner = Owner::Body(&self.robot.frames[body.frame].name);
            let slot = self.number(owner, &MASS, body.mass);
            for (row, &value) in CENTRE.iter().zip(&body.com) {
                self.number(owner, row, value);
            }
            let at = (self.structure.home[body.frame] * nalgebra::Point3::from(body.com)).coords;
            let vertex = self.carrier(body.frame, &at);
            self.structure.masses.push(MassElement { frame: body.frame, vertex, slot });
        }
        for spring in &self.robot.elastic.springs {
            let name = &spring.name;
            let owner = Owner::Spring(name);
            let rate = self.stiffness(owner.parameter(RATE.symbol), spring.rate, 0.3 * spring.rate.nominal);
            let mut slots = [rate; 8];
            slots[1] = self.number(owner, &FREE_LENGTH, spring.free_length.unwrap_or_default());
            for (k, row) in ANCHORS.iter().enumerate() {
                slots[k + 2] = self.number(owner, row, spring.anchors[k / 3][k % 3]);
            }
            let ends = std::array::from_fn(|k| {
                let at = self.structure.home[spring.bodies[k]] * nalgebra::Point3::from(spring.anchors[k]);
                self.carrier(spring.bodies[k], &at.coords)
            });
            // The joint between the two bodies is what lets them move; the outer body's where they are no neighbours.
            let [a, b] = spring.bodies.map(|frame| self.root(frame));
            let pivot = if b != 0 && self.root(self.robot.frames[b].antecedent) == a {
                b
            } else if a != 0 && self.root(self.robot.frames[a].antecedent) == b {
                a
            } else {
                a.max(b)
            };
            let element = Arc::new(Spring { spring: spring.clone(), slots, pivot });
            self.structure.springs.push(Arc::clone(&element));
            self.only_closing.push(Edge { name: format!("spring:{name}"), ends, element });
        }
    }
}
