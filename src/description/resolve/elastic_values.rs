//! The elastic keys of a description that has no faults: names to indices, units to SI.

use indexmap::IndexMap;
use nalgebra::Vector3;

use super::super::elastic::{
    Beam, Body, Elastic, JointStiffness, Material, Node, Screw, Section, Shear, Spring, Stiffness, section_symbols,
};
use super::super::raw::{BeamTheory, LoadPath, RawRobot, RawSection, RawStiffness, SpringAction};
use super::tree::Tree;

/// Standard gravity of a description that states none, m/s2.
const GRAVITY: [f64; 3] = [0.0, 0.0, -9.81];

/// Values of the elastic keys. Entries whose names are unknown, which validation has told, are passed over.
pub fn resolve(raw: &RawRobot, tree: &Tree) -> Elastic {
    let units = &raw.units;
    let length = units.length.factor();
    let (linear, rotational) = (units.stiffness.factor(), units.rotational_stiffness.factor());
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
        let pressure = units.pressure.factor();
        let shear = match material.shear {
            Some(shear) => Shear::Modulus(shear * pressure),
            None => Shear::Poisson(material.poisson.unwrap_or_default()),
        };
        let resolved = Material {
            young: material.young.unwrap_or_default() * pressure,
            shear,
            density: material.density.unwrap_or_default(),
            expansion: material.expansion.unwrap_or_default(),
        };
        elastic.materials.insert(name.clone(), resolved);
    }
    for (name, section) in &raw.sections {
        let mut values: Vec<(&'static str, f64)> = section_symbols(section.shape)
            .iter()
            .filter_map(|&symbol| number(section, symbol).map(|value| (symbol, value * length.powi(power(symbol)))))
            .collect();
        values.extend(
            ["shear_y", "shear_z"]
                .into_iter()
                .filter_map(|symbol| number(section, symbol).map(|value| (symbol, value * length.powi(power(symbol))))),
        );
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
            let given = |spring: &Option<RawStiffness>, factor: f64| spring.as_ref().map(|s| stiffness(s, factor));
            Some(JointStiffness {
                frame: frame(name)?,
                at: joint.at.as_ref().and_then(|at| node(at, None)),
                springs: [
                    given(&joint.ka, linear),
                    given(&joint.kr, linear),
                    given(&joint.kar, rotational),
                    given(&joint.krr, rotational),
                ],
            })
        })
        .collect();
    elastic.base = raw.base_stiffness.as_ref().map(|base| {
        let all = [&base.kx, &base.ky, &base.kz, &base.krx, &base.kry, &base.krz];
        std::array::from_fn(|k| all[k].as_ref().map(|s| stiffness(s, if k < 3 { linear } else { rotational })))
    });
    elastic.springs = raw
        .springs
        .iter()
        .filter_map(|(name, spring)| {
            let [a, b] = spring.bodies.as_ref()?;
            let [first, second] = spring.anchors?;
            let rate = stiffness(spring.rate.as_ref()?, linear);
            let free_length = spring.free_length.map(|l| l * length).or_else(|| {
                let preload = spring.preload? * units.force.factor();
                Some(spring.preload_length? * length - preload * rate.compliance)
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
            let axial = stiffness(raw.axial.as_ref()?, linear);
            let held = axial.compliance == 0.0 && !axial.identifiable;
            let path = raw.path.unwrap_or(if held { LoadPath::Joint } else { LoadPath::Pins });
            Some((index, Screw { axial, path }))
        })
        .collect::<IndexMap<_, _>>();
    elastic
}

fn number(section: &RawSection, symbol: &str) -> Option<f64> {
    match symbol {
        "width" => section.width,
        "height" => section.height,
        "wall" => section.wall,
        "flange" => section.flange,
        "diameter" => section.diameter,
        "area" => section.area,
        "iy" => section.iy,
        "iz" => section.iz,
        "j" => section.j,
        "shear_y" => section.shear_y,
        "shear_z" => section.shear_z,
        _ => None,
    }
}

/// Power of the length unit in which a section's symbol is written.
pub fn power(symbol: &str) -> i32 {
    match symbol {
        "area" | "shear_y" | "shear_z" => 2,
        "iy" | "iz" | "j" => 4,
        _ => 1,
    }
}

/// A stiffness written in a unit of `factor` SI.
fn stiffness(raw: &RawStiffness, factor: f64) -> Stiffness {
    let compliance = match (raw.value, raw.compliance) {
        (Some(value), _) => 1.0 / (value * factor),
        (None, compliance) => compliance.unwrap_or_default() / factor,
    };
    let bounds = raw.bounds.map_or([0.0, f64::INFINITY], |[low, high]| [1.0 / (high * factor), 1.0 / (low * factor)]);
    Stiffness { compliance, identifiable: raw.identifiable, bounds, as_compliance: raw.value.is_none() }
}
