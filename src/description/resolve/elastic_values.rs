//! The elastic keys of a description that has no faults: names to indices, units to SI.

use indexmap::IndexMap;
use nalgebra::Vector3;

use super::super::elastic::{
    Beam, Body, Elastic, JointStiffness, Material, Node, Screw, Section, Shear, Spring, Stiffness, own_axis,
};
use super::super::frame::Motion;
use super::super::parameters::{
    AXIAL, DENSITY, EXPANSION, JOINT, Number, PEDESTAL, POISSON, RATE, SECTION, SHEAR, YOUNG, section_symbols,
};
use super::super::raw::{BeamTheory, LoadPath, RawMaterial, RawRobot, RawStiffness, SpringAction};
use super::super::units::Units;
use super::tree::Tree;
use crate::parameter::Kind;

/// Standard gravity of a description that states none, m/s2.
const GRAVITY: [f64; 3] = [0.0, 0.0, -9.81];

/// Values of the elastic keys. Entries whose names are unknown, which validation has reported, are passed over.
pub fn resolve(raw: &RawRobot, tree: &Tree) -> Elastic {
    let units = &raw.units;
    let length = units.length.factor();
    let frame = |name: &str| tree.frames.iter().position(|frame| frame.name == name);
    let vector = |value: Option<[f64; 3]>| Vector3::from(value.unwrap_or_default()) * length;
    let mut elastic = Elastic { gravity: Vector3::from(raw.gravity.unwrap_or(GRAVITY)), ..Elastic::default() };
    elastic.bodies = raw
        .bodies
        .iter()
        .filter_map(|(name, body)| {
            let mass = body.mass.unwrap_or_default() * units.mass.factor();
            Some(Body { frame: frame(name)?, mass, com: vector(body.com) })
        })
        .collect();
    for (name, material) in &raw.materials {
        let number = |row: &Number<RawMaterial>| row.si(material, units);
        let resolved = Material {
            young: number(&YOUNG).unwrap_or_default(),
            shear: number(&SHEAR).map_or(Shear::Poisson(number(&POISSON).unwrap_or_default()), Shear::Modulus),
            density: number(&DENSITY).unwrap_or_default(),
            expansion: number(&EXPANSION).unwrap_or_default(),
        };
        elastic.materials.insert(name.clone(), resolved);
    }
    for (name, section) in &raw.sections {
        let needed = section_symbols(section.shape);
        let used = SECTION.iter().filter(|row| needed.contains(&row.symbol) || row.symbol.starts_with("shear_"));
        let values = used.filter_map(|row| Some((row.symbol, row.si(section, units)?))).collect();
        elastic.sections.insert(name.clone(), Section { shape: section.shape, values });
    }
    for (name, node) in &raw.nodes {
        let Some(body) = node.body.as_deref().and_then(frame) else { continue };
        let at = node.at.as_deref().and_then(frame).unwrap_or(body);
        elastic.nodes.push(Node { name: name.clone(), body, at, point: vector(node.point), support: node.support });
    }
    // A frame's name stands for its origin: on its own body, and for a beam from frame to frame on the body of the
    // inner one.
    let mut node = |name: &str, body: Option<&str>| -> Option<usize> {
        let on = body.filter(|body| *body != name && !raw.nodes.contains_key(name));
        let shown = on.map_or_else(|| name.to_string(), |body| format!("{name} on {body}"));
        if let Some(known) = elastic.nodes.iter().position(|node| node.name == shown) {
            return Some(known);
        }
        let (at, body) = (frame(name)?, frame(on.unwrap_or(name))?);
        elastic.nodes.push(Node { name: shown, body, at, point: Vector3::zeros(), support: None });
        Some(elastic.nodes.len() - 1)
    };
    let inner = |a: &str, b: &str| -> Option<String> {
        let carried = |a: &str, b: &str| raw.frames.get(b).is_some_and(|f| f.antecedent.as_deref() == Some(a));
        if carried(a, b) { Some(a.into()) } else { carried(b, a).then(|| b.into()) }
    };
    elastic.beams = raw
        .beams
        .iter()
        .filter_map(|(name, beam)| {
            let (from, to) = (beam.from.as_ref()?, beam.to.as_ref()?);
            let body = inner(from, to);
            let nodes = [node(from, body.as_deref())?, node(to, body.as_deref())?];
            let section = raw.sections.get_index_of(beam.section.as_ref()?)?;
            let other = beam.section_to.as_ref().and_then(|name| raw.sections.get_index_of(name));
            let own = body.or_else(|| raw.nodes.get(from)?.body.clone()).and_then(|name| frame(&name));
            Some(Beam {
                name: name.clone(),
                nodes,
                sections: [section, other.unwrap_or(section)],
                material: raw.materials.get_index_of(beam.material.as_ref()?)?,
                normal: beam.normal.as_deref().and_then(frame).or(own).unwrap_or(0),
                theory: beam.theory.unwrap_or(BeamTheory::EulerBernoulli),
                // A taper is followed in steps; eight leave 1.2 % where the depth falls to 0.4 of itself.
                elements: beam.elements.map_or(if other.is_some() { 8 } else { 1 }, |n| n.max(1) as usize),
                released: [&beam.release.from, &beam.release.to]
                    .map(|axes| std::array::from_fn(|k| axes.iter().any(|axis| *axis as usize == k))),
            })
        })
        .collect();
    elastic.joints = raw
        .joint_stiffness
        .iter()
        .filter_map(|(name, joint)| {
            let index = frame(name)?;
            let moved = &tree.frames[index];
            let springs = std::array::from_fn(|k| {
                // What resists a passive joint's own motion acts in parallel with it.
                let parallel = moved.motion == Motion::Passive && k == own_axis(moved.joint);
                let kind = JOINT[k].kind;
                let held = if parallel { kind } else { kind.inverse() };
                (JOINT[k].get)(joint).map(|given| stiffness(given, kind, held, units))
            });
            Some(JointStiffness { frame: index, at: joint.at.as_ref().and_then(|at| node(at, None)), springs })
        })
        .collect();
    if let Some(base) = &raw.base_stiffness {
        elastic.base = PEDESTAL.map(|row| Some(stiffness((row.get)(base)?, row.kind, row.kind.inverse(), units)));
    }
    elastic.springs = raw
        .springs
        .iter()
        .filter_map(|(name, spring)| {
            let [a, b] = spring.bodies.as_ref()?;
            let [first, second] = spring.anchors?;
            let rate = stiffness((RATE.get)(spring)?, RATE.kind, RATE.kind, units);
            let free_length = spring.free_length.map(|l| l * length).or_else(|| {
                let preload = spring.preload? * units.force.factor();
                Some(spring.preload_length? * length - preload / rate.nominal)
            });
            Some(Spring {
                name: name.clone(),
                bodies: [frame(a)?, frame(b)?],
                anchors: [vector(Some(first)), vector(Some(second))],
                rate,
                free_length,
                acts: spring.acts.unwrap_or(SpringAction::Full),
            })
        })
        .collect();
    elastic.screws = tree
        .actuators
        .iter()
        .enumerate()
        .filter_map(|(index, actuator)| {
            let raw = raw.actuators.get(&actuator.name)?;
            let axial = stiffness((AXIAL.get)(raw)?, AXIAL.kind, AXIAL.kind.inverse(), units);
            let held = axial.nominal == 0.0 && !axial.identifiable;
            let path = raw.path.unwrap_or(if held { LoadPath::Joint } else { LoadPath::Pins });
            Some((index, Screw { axial, path }))
        })
        .collect::<IndexMap<_, _>>();
    elastic
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
