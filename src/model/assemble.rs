//! Builds the elastic structure of a resolved robot.

use std::sync::Arc;

use nalgebra::{Isometry3, Rotation3, Translation3, Vector3};

use super::structure::{Edge, MassElement, Spot, Structure, Vertex, nearest};
use super::{Fault, Model};
use crate::description::elastic::{BASE_SYMBOLS, Elastic, JOINT_SYMBOLS, Shear, Stiffness};
use crate::description::raw::{JointKind, LoadPath, LoopKind, Meet, Support};
use crate::description::resolve::power;
use crate::description::robot::{FrameIndex, Motion, Robot};
use crate::elements::{
    Axes, BodyPoint, Law, Lumped, Material, Screw, ScrewTriangle, Section, Spring, VertexIndex, screw_pins,
};
use crate::parameter::{Group, Kind, Parameter, Slot};

/// Compliance by which what is declared rigid is commonly off, m/N and rad/(N.m): a start for effects.
const COMMON: [f64; 2] = [1e-9, 1e-7];
/// Symbols of lumped springs about a joint: along x, y, z (its axis), about x, y, z.
const LUMPED: [&str; 6] = ["kr", "kr", "ka", "krr", "krr", "kar"];

pub(super) struct Builder<'a> {
    pub(super) robot: &'a Robot,
    pub(super) model: &'a mut Model,
    pub(super) structure: Structure,
    pub(super) edges: Vec<Edge>,
    pub(super) only_closing: Vec<Edge>,
    pub(super) faults: Vec<Fault>,
}

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

/// Frames with all joints at zero.
fn home(robot: &Robot) -> Vec<Isometry3<f64>> {
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
            * Translation3::new(0.0, 0.0, c.r);
        home.push(match home.get(frame.antecedent) {
            Some(antecedent) => antecedent * own,
            None => Isometry3::identity(),
        });
    }
    home
}

impl Builder<'_> {
    fn elastic(&self) -> &Elastic {
        &self.robot.elastic
    }

    /// Adds a parameter held as `nominal`; `inverted` where it is written as its inverse.
    #[allow(clippy::too_many_arguments)] // a parameter has that many sides
    fn add(
        &mut self,
        name: String,
        kind: Kind,
        nominal: f64,
        bounds: [f64; 2],
        tolerance: f64,
        free: bool,
        inverted: bool,
    ) -> Slot {
        let calibration = &self.robot.calibration;
        let flip = |bounds: [f64; 2]| if inverted { [1.0 / bounds[1], 1.0 / bounds[0]] } else { bounds };
        // What is stated narrows what the quantity allows.
        let bounds = calibration.bounds.get(&name).copied().map_or(bounds, |stated| {
            let [low, high] = flip(stated);
            [bounds[0].max(low), bounds[1].min(high)]
        });
        let tolerance = calibration
            .tolerances
            .get(&name)
            .map_or(tolerance, |&stated| if inverted && nominal != 0.0 { stated * nominal * nominal } else { stated });
        let free = (free || calibration.free.contains(&name)) && !calibration.fixed.contains(&name);
        let group = Group::Elastic;
        let parameter = Parameter { name, kind, group, nominal, bounds, tolerance, free, closing: false, inverted };
        self.model.registry.add(parameter)
    }

    /// A compliance as declared, rigid where it is not.
    fn compliance(&mut self, name: String, kind: Kind, given: Option<Stiffness>) -> Slot {
        let common = COMMON[usize::from(kind == Kind::RotationalCompliance)];
        let (nominal, identifiable, bounds, as_compliance) = given
            .map_or((0.0, false, [0.0, f64::INFINITY], false), |s| {
                (s.compliance, s.identifiable, s.bounds, s.as_compliance)
            });
        let tolerance = if nominal > 0.0 { 0.3 * nominal } else { common };
        self.add(name, kind, nominal, bounds, tolerance, identifiable, !as_compliance)
    }

    /// A parameter that is written as it is computed with.
    pub(super) fn plain(&mut self, name: String, kind: Kind, value: f64, bounds: [f64; 2], tolerance: f64) -> Slot {
        self.add(name, kind, value, bounds, tolerance, false, false)
    }

    fn sections(&mut self) {
        let positive = [0.0, f64::INFINITY];
        for (name, material) in self.robot.elastic.materials.clone() {
            let young = self.plain(
                format!("{name}.young"),
                Kind::Pressure,
                material.young,
                [1e-9 * material.young, f64::INFINITY],
                0.05 * material.young,
            );
            let (shear, is_poisson) = match material.shear {
                Shear::Modulus(g) => {
                    (self.plain(format!("{name}.shear"), Kind::Pressure, g, [1e-9 * g, f64::INFINITY], 0.05 * g), false)
                }
                Shear::Poisson(nu) => {
                    (self.plain(format!("{name}.poisson"), Kind::Other("1"), nu, [-0.999, 0.5], 0.02), true)
                }
            };
            let kind = Kind::Other("kg/m3");
            let density = self.plain(
                format!("{name}.density"),
                kind,
                material.density,
                positive,
                (0.05 * material.density).max(1.0),
            );
            self.structure.materials.push(Material { young, shear, is_poisson, density });
        }
        for (name, section) in self.robot.elastic.sections.clone() {
            let slots = section.values.iter().map(|&(symbol, value)| {
                let kind = match power(symbol) {
                    1 => Kind::Length,
                    2 => Kind::Other("m2"),
                    _ => Kind::Other("m4"),
                };
                let slot =
                    self.plain(format!("{name}.{symbol}"), kind, value, [1e-9 * value, f64::INFINITY], 0.05 * value);
                (symbol, slot)
            });
            let slots = slots.collect();
            self.structure.sections.push(Section { shape: section.shape, slots });
        }
    }

    /// The frame that moves a frame's body.
    pub(super) fn root(&self, mut frame: FrameIndex) -> FrameIndex {
        while frame != 0 && self.robot.frames[frame].joint == JointKind::Fixed {
            frame = self.robot.frames[frame].antecedent;
        }
        frame
    }

    pub(super) fn vertex(&mut self, name: impl Into<String>, spot: Spot) -> VertexIndex {
        self.structure.vertices.push(Vertex { name: name.into(), spot });
        self.structure.vertices.len() - 1
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

    fn carrier(&self, frame: FrameIndex, at: &Vector3<f64>) -> VertexIndex {
        nearest(&self.structure.bodies[frame], at, |vertex| self.structure.at_home(vertex))
    }

    fn base(&mut self) {
        let springs = self.elastic().base.unwrap_or_default();
        let mut laws = [Law::Rigid; 6];
        for (k, symbol) in BASE_SYMBOLS.into_iter().enumerate() {
            let kind = if k < 3 { Kind::LinearCompliance } else { Kind::RotationalCompliance };
            laws[k] = Law::Compliance(self.compliance(format!("base.{symbol}"), kind, springs[k]));
        }
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
            let declared = self.elastic().joints.iter().find(|joint| joint.frame == index).cloned();
            let springs = declared.as_ref().map_or([None; 4], |joint| joint.springs);
            let axis = if frame.joint == JointKind::Prismatic { 0 } else { 2 };
            let screw = match frame.motion {
                Motion::Actuator(which) => self.model.actuators.iter().position(|a| a.joint == index).zip(Some(which)),
                _ => None,
            };
            let mut slots = [0; 4];
            for (k, symbol) in JOINT_SYMBOLS.into_iter().enumerate() {
                let name = format!("joint{}.{symbol}", frame.name);
                let kind = if k < 2 { Kind::LinearCompliance } else { Kind::RotationalCompliance };
                // A passive axis is free, or held by a soft spring: a stiffness, zero where none is given.
                slots[k] = if frame.motion == Motion::Passive && k == axis {
                    let (nominal, identifiable, bounds) = springs[k].map_or((0.0, false, [0.0, f64::INFINITY]), |s| {
                        (1.0 / s.compliance, s.identifiable, [1.0 / s.bounds[1], 1.0 / s.bounds[0]])
                    });
                    let inverted = springs[k].is_some_and(|s| s.as_compliance);
                    self.add(name, kind.inverse(), nominal, bounds, (0.3 * nominal).max(1.0), identifiable, inverted)
                } else {
                    // What the screw holds is free of itself, and the joint's own spring is then rigid.
                    let given = springs[k].filter(|s| s.compliance.is_finite());
                    self.compliance(name, kind, given)
                };
            }
            let [ka, kr, kar, krr] = slots;
            let mut laws = [kr, kr, ka, krr, krr, kar].map(Law::Compliance);
            let along = if axis == 0 { 2 } else { 5 };
            if frame.motion == Motion::Passive {
                laws[along] = Law::Released(Some(slots[axis]));
            }
            if let Some((actuator, which)) = screw {
                let given = self.elastic().screws.get(&which).copied();
                let name = format!("{}.axial", self.model.actuators[actuator].name);
                let axial = self.compliance(name, Kind::LinearCompliance, given.map(|screw| screw.axial));
                let triangle = self.triangle(actuator);
                if given.is_some_and(|screw| screw.path == LoadPath::Pins) {
                    laws[along] = Law::Released(None);
                    let antecedent = self.structure.bodies[frame.antecedent].clone();
                    let ends = [antecedent.first().copied().unwrap_or(0), self.structure.bodies[index][0]];
                    let element = Arc::new(Screw { triangle, own: kar, axial });
                    let name = format!("actuator:{}", self.model.actuators[actuator].name);
                    self.only_closing.push(Edge { name, ends: self.pins(index, ends, actuator), element });
                } else {
                    laws[along] = Law::Driven { own: kar, axial, screw: triangle };
                }
            }
            let origin = BodyPoint { frame: index, point: Vector3::zeros() };
            let at = declared.and_then(|joint| joint.at).map_or(origin, |node| self.node(node));
            let home = (self.structure.home[at.frame] * nalgebra::Point3::from(at.point)).coords;
            let ends = [self.carrier(frame.antecedent, &home), self.carrier(index, &home)];
            let element = Arc::new(Lumped { at, axes: Axes::Frame(index), laws, symbols: LUMPED, end_of: None });
            self.edges.push(Edge { name: format!("joint:{}", frame.name), ends, element });
        }
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
            let element = Arc::new(Lumped { laws, ..Lumped::rigid(a, LUMPED) });
            self.edges.push(Edge { name: format!("loop:{}", closed.name), ends: [end(a), end(b)], element });
        }
    }

    fn loads(&mut self) {
        for body in &self.robot.elastic.bodies {
            let name = &self.robot.frames[body.frame].name;
            let free = [f64::NEG_INFINITY, f64::INFINITY];
            let slot =
                self.plain(format!("body{name}.mass"), Kind::Mass, body.mass, [0.0, f64::INFINITY], 0.1 * body.mass);
            for (k, symbol) in ["x", "y", "z"].into_iter().enumerate() {
                self.plain(format!("body{name}.{symbol}"), Kind::Length, body.com[k], free, 0.02);
            }
            let at = (self.structure.home[body.frame] * nalgebra::Point3::from(body.com)).coords;
            let vertex = self.carrier(body.frame, &at);
            self.structure.masses.push(MassElement { frame: body.frame, vertex, slot });
        }
        for spring in &self.robot.elastic.springs {
            let name = &spring.name;
            let free = [f64::NEG_INFINITY, f64::INFINITY];
            let rate = 1.0 / spring.rate.compliance;
            let bounds = [1.0 / spring.rate.bounds[1], 1.0 / spring.rate.bounds[0]];
            let rate_slot = self.add(
                format!("{name}.stiffness"),
                Kind::LinearStiffness,
                rate,
                bounds,
                0.3 * rate,
                spring.rate.identifiable,
                spring.rate.as_compliance,
            );
            let length = spring.free_length.unwrap_or_default();
            let mut slots = [rate_slot; 8];
            slots[1] = self.plain(format!("{name}.free_length"), Kind::Length, length, free, 0.02);
            for (k, symbol) in ["x1", "y1", "z1", "x2", "y2", "z2"].into_iter().enumerate() {
                let value = spring.anchors[k / 3][k % 3];
                slots[k + 2] = self.plain(format!("{name}.{symbol}"), Kind::Length, value, free, 1e-3);
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
