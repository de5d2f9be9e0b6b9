//! The elastic keys of a description that has no faults: names to indices, units to SI.

use indexmap::IndexMap;
use nalgebra::Vector3;

use super::super::elastic::{
    Beam, Body, Elastic, JointStiffness, Material, Node, Screw, Section, Shear, Spring, Stiffness, own_axis,
};
use super::super::frame::{FrameIndex, Motion};
use super::super::parameters::{
    AXIAL, DENSITY, EXPANSION, JOINT, MASS, Number, PEDESTAL, POISSON, RATE, SECTION, SHEAR, Stiffness as Row, YOUNG,
    section_symbols,
};
use super::super::raw::{
    BeamTheory, LoadPath, RawBaseStiffness, RawBeam, RawBody, RawJointStiffness, RawMaterial, RawRobot, RawSection,
    RawSpring, RawStiffness, SpringAction,
};
use super::super::robot::SliderCrank;
use super::super::units::Units;
use super::tree::Tree;
use crate::parameter::Kind;

/// Standard gravity of a description that states none, m/s2.
const GRAVITY: [f64; 3] = [0.0, 0.0, -9.81];

/// Values of the elastic keys. Entries whose names are unknown, which validation has reported, are passed over.
pub fn resolve(raw: &RawRobot, tree: &Tree) -> Elastic {
    let mut values = Values { raw, tree, units: &raw.units, nodes: Vec::new() };
    values.declared_nodes();
    // Beams and joints add the origins of frames that they name as nodes.
    let (beams, joints) = (values.beams(), values.joints());
    let mass = |body: &RawBody| MASS.si(body, &raw.units).unwrap_or_default();
    let bodies = raw.bodies.iter().filter_map(|(name, body)| {
        Some(Body { frame: values.frame(name)?, mass: mass(body), com: values.point(body.com) })
    });
    let pedestal = |row: Row<RawBaseStiffness>| {
        Some(stiffness((row.get)(raw.base_stiffness.as_ref()?)?, row.kind, row.kind.inverse(), &raw.units))
    };
    Elastic {
        gravity: Vector3::from(raw.gravity.unwrap_or(GRAVITY)),
        bodies: bodies.collect(),
        materials: raw.materials.iter().map(|(name, given)| (name.clone(), material(given, &raw.units))).collect(),
        sections: raw.sections.iter().map(|(name, given)| (name.clone(), section(given, &raw.units))).collect(),
        beams,
        joints,
        base: PEDESTAL.map(pedestal),
        springs: raw.springs.iter().filter_map(|(name, spring)| values.spring(name, spring)).collect(),
        screws: values.screws(),
        nodes: values.nodes,
    }
}

fn material(given: &RawMaterial, units: &Units) -> Material {
    let number = |row: &Number<RawMaterial>| row.si(given, units);
    Material {
        young: number(&YOUNG).unwrap_or_default(),
        shear: number(&SHEAR).map_or(Shear::Poisson(number(&POISSON).unwrap_or_default()), Shear::Modulus),
        density: number(&DENSITY).unwrap_or_default(),
        expansion: number(&EXPANSION).unwrap_or_default(),
    }
}

fn section(given: &RawSection, units: &Units) -> Section {
    let needed = section_symbols(given.shape);
    let used = SECTION.iter().filter(|row| needed.contains(&row.symbol) || row.symbol.starts_with("shear_"));
    let values = used.filter_map(|row| Some((row.symbol, row.si(given, units)?))).collect();
    Section { shape: given.shape, values }
}

struct Values<'r> {
    raw: &'r RawRobot,
    tree: &'r Tree,
    units: &'r Units,
    nodes: Vec<Node>,
}

impl Values<'_> {
    fn frame(&self, name: &str) -> Option<FrameIndex> {
        self.tree.frames.iter().position(|frame| frame.name == name)
    }

    fn point(&self, given: Option<[f64; 3]>) -> Vector3<f64> {
        Vector3::from(given.unwrap_or_default()) * self.units.length.factor()
    }

    fn declared_nodes(&mut self) {
        for (name, node) in &self.raw.nodes {
            let Some(body) = node.body.as_deref().and_then(|body| self.frame(body)) else { continue };
            let at = node.at.as_deref().and_then(|at| self.frame(at)).unwrap_or(body);
            let (point, support) = (self.point(node.point), node.support);
            self.nodes.push(Node { name: name.clone(), body, at, point, support });
        }
    }

    /// The node of a name. A frame's name stands for its origin: on its own body, or on the body given.
    fn node(&mut self, name: &str, body: Option<&str>) -> Option<usize> {
        let on = body.filter(|body| *body != name && !self.raw.nodes.contains_key(name));
        let shown = on.map_or_else(|| name.to_string(), |body| format!("{name} on {body}"));
        if let Some(known) = self.nodes.iter().position(|node| node.name == shown) {
            return Some(known);
        }
        let (at, body) = (self.frame(name)?, self.frame(on.unwrap_or(name))?);
        self.nodes.push(Node { name: shown, body, at, point: Vector3::zeros(), support: None });
        Some(self.nodes.len() - 1)
    }

    fn beams(&mut self) -> Vec<Beam> {
        self.raw.beams.iter().filter_map(|(name, beam)| self.beam(name, beam)).collect()
    }

    fn beam(&mut self, name: &str, beam: &RawBeam) -> Option<Beam> {
        let raw = self.raw;
        let (from, to) = (beam.from.as_deref()?, beam.to.as_deref()?);
        // A beam from frame to frame is the body of the inner one.
        let carries = |a: &str, b: &str| raw.frames.get(b).is_some_and(|f| f.antecedent.as_deref() == Some(a));
        let body = if carries(from, to) { Some(from) } else { carries(to, from).then_some(to) };
        let nodes = [self.node(from, body)?, self.node(to, body)?];
        let section = raw.sections.get_index_of(beam.section.as_ref()?)?;
        let other = beam.section_to.as_ref().and_then(|name| raw.sections.get_index_of(name));
        let own = body.or_else(|| raw.nodes.get(from)?.body.as_deref()).and_then(|name| self.frame(name));
        Some(Beam {
            name: name.to_owned(),
            nodes,
            sections: [section, other.unwrap_or(section)],
            material: raw.materials.get_index_of(beam.material.as_ref()?)?,
            normal: beam.normal.as_deref().and_then(|name| self.frame(name)).or(own).unwrap_or(0),
            theory: beam.theory.unwrap_or(BeamTheory::EulerBernoulli),
            // A taper is followed in steps; eight leave 1.2 % where the depth falls to 0.4 of itself.
            elements: beam.elements.map_or(if other.is_some() { 8 } else { 1 }, |n| n.max(1) as usize),
            released: [&beam.release.from, &beam.release.to]
                .map(|axes| std::array::from_fn(|k| axes.iter().any(|axis| *axis as usize == k))),
        })
    }

    fn joints(&mut self) -> Vec<JointStiffness> {
        let raw = self.raw;
        let joint = |(name, joint): (&String, &RawJointStiffness)| {
            let frame = self.frame(name)?;
            let moved = &self.tree.frames[frame];
            let springs = std::array::from_fn(|k| {
                // What resists a passive joint's own motion acts in parallel with it.
                let parallel = moved.motion == Motion::Passive && k == own_axis(moved.joint);
                let kind = JOINT[k].kind;
                let held = if parallel { kind } else { kind.inverse() };
                (JOINT[k].get)(joint).map(|given| stiffness(given, kind, held, self.units))
            });
            Some(JointStiffness { frame, at: joint.at.as_ref().and_then(|at| self.node(at, None)), springs })
        };
        raw.joint_stiffness.iter().filter_map(joint).collect()
    }

    fn spring(&self, name: &str, spring: &RawSpring) -> Option<Spring> {
        let [a, b] = spring.bodies.as_ref()?;
        let length = self.units.length.factor();
        let rate = stiffness((RATE.get)(spring)?, RATE.kind, RATE.kind, self.units);
        let free_length = spring.free_length.map(|l| l * length).or_else(|| {
            let preload = spring.preload? * self.units.force.factor();
            Some(spring.preload_length? * length - preload / rate.nominal)
        });
        Some(Spring {
            name: name.to_owned(),
            bodies: [self.frame(a)?, self.frame(b)?],
            anchors: spring.anchors?.map(|anchor| self.point(Some(anchor))),
            rate,
            free_length,
            acts: spring.acts.unwrap_or(SpringAction::Full),
        })
    }

    fn screws(&self) -> IndexMap<usize, Screw> {
        let screw = |(index, actuator): (usize, &SliderCrank)| {
            let raw = self.raw.actuators.get(&actuator.name)?;
            let axial = stiffness((AXIAL.get)(raw)?, AXIAL.kind, AXIAL.kind.inverse(), self.units);
            let held = axial.nominal == 0.0 && !axial.identifiable;
            let path = raw.path.unwrap_or(if held { LoadPath::Joint } else { LoadPath::Pins });
            Some((index, Screw { axial, path }))
        };
        self.tree.actuators.iter().enumerate().filter_map(screw).collect()
    }
}

/// A stiffness of the file, held as the model computes with it: once inverted here, it is not inverted again.
fn stiffness(given: &RawStiffness, declared: Kind, held: Kind, units: &Units) -> Stiffness {
    let factor = units.of(declared);
    let by_value = given.value.is_some();
    let written = given.value.map_or_else(|| given.compliance.unwrap_or_default() / factor, |value| value * factor);
    let inverted = by_value != (declared == held);
    let nominal = if inverted { 1.0 / written } else { written };
    // Bounds are those of the stiffness, however its value is declared.
    let bounds = given.bounds.map_or([0.0, f64::INFINITY], |[low, high]| {
        let [low, high] = [low * factor, high * factor];
        if declared == held { [low, high] } else { [1.0 / high, 1.0 / low] }
    });
    Stiffness { kind: held, nominal, identifiable: given.identifiable, bounds, inverted }
}
