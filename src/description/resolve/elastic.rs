//! The elastic keys of a description: names, ranges and completeness.

use super::super::elastic::own_axis;
use super::super::parameters::{AXIAL, JOINT, MATERIAL, PEDESTAL, POISSON, SECTION, section_symbols};
use super::super::raw::{JointKind, RawBeam, RawMaterial, RawRobot, RawSection, RawStiffness, SectionShape};
use super::collector::Collector;

/// Checks the elastic keys of a description whose frames are known.
pub fn validate(raw: &RawRobot, frames: &[String], diagnostics: &mut Collector) {
    if let Some(gravity) = raw.gravity {
        diagnostics.vector(&["gravity"], Some(gravity), 1.0);
    }
    bodies(raw, frames, diagnostics);
    raw.materials.iter().for_each(|(name, material)| validate_material(diagnostics, name, material));
    raw.sections.iter().for_each(|(name, section)| validate_section(diagnostics, name, section));
    for (name, node) in &raw.nodes {
        match &node.body {
            Some(body) => diagnostics.known(&["nodes", name, "body"], "frame", body, names(frames)),
            None => {
                diagnostics.lacking(&["nodes", name], "body", format!("node `{name}` lacks `body`"));
            }
        }
        if let Some(at) = &node.at {
            diagnostics.known(&["nodes", name, "at"], "frame", at, names(frames));
            if let Some((body, before)) = node.body.as_deref().and_then(|body| slides_in(raw, body, at)) {
                let message = format!(
                    "node `{name}` lies at `{at}`, which is no frame of body `{body}`, of the one before or of one that it carries"
                );
                let remedy =
                    format!("give the frame of the body before, `{before}`, at which the boom leaves its sleeve");
                diagnostics.reject(&["nodes", name, "at"], message, remedy);
            }
        }
        diagnostics.vector(&["nodes", name, "point"], node.point, raw.units.length.factor());
    }
    raw.beams.iter().for_each(|(name, beam)| validate_beam(raw, frames, name, beam, diagnostics));
    joints(raw, frames, diagnostics);
    if let Some(base) = &raw.base_stiffness {
        for row in &PEDESTAL {
            stiffness(diagnostics, &["base_stiffness", row.symbol], (row.get)(base), Also::Rigid);
        }
    }
    for (name, actuator) in &raw.actuators {
        stiffness(diagnostics, &["actuators", name, AXIAL.symbol], (AXIAL.get)(actuator), Also::Rigid);
    }
    springs(raw, frames, diagnostics);
}

fn names(names: &[String]) -> impl Iterator<Item = &str> + Clone {
    names.iter().map(String::as_str)
}

/// Names of nodes; that of a frame stands for its origin.
fn nodes<'r>(raw: &'r RawRobot, frames: &'r [String]) -> impl Iterator<Item = &'r str> + Clone {
    raw.nodes.keys().map(String::as_str).chain(names(frames))
}

fn bodies(raw: &RawRobot, frames: &[String], diagnostics: &mut Collector) {
    for (name, body) in &raw.bodies {
        diagnostics.known(&["bodies", name], "frame", name, names(frames));
        match body.mass {
            None => {
                diagnostics.lacking(&["bodies", name], "mass", format!("body `{name}` has no `mass`"));
            }
            Some(mass) if !(mass >= 0.0 && mass.is_finite()) => {
                let remedy = "give the mass itself; a spring or a counterweight that pulls upwards is declared as such";
                diagnostics.reject(&["bodies", name, "mass"], format!("mass `{mass}` must be 0 or more"), remedy);
            }
            Some(_) => {}
        }
        diagnostics.vector(&["bodies", name, "com"], body.com, 1.0);
    }
}

fn validate_material(diagnostics: &mut Collector, name: &str, material: &RawMaterial) {
    for row in MATERIAL.iter().filter(|row| row.symbol != POISSON.symbol) {
        positive(diagnostics, &["materials", name, row.symbol], row.symbol, (row.get)(material));
    }
    if material.young.is_none() {
        diagnostics.lacking(&["materials", name], "young", format!("material `{name}` lacks `young`"));
    }
    match (material.poisson, material.shear) {
        (Some(nu), None) if !(nu > -1.0 && nu <= 0.5) => {
            let message = format!("Poisson's ratio `{nu}` is outside (-1, 0.5]");
            diagnostics.error(&["materials", name, "poisson"], message);
        }
        (Some(_), None) | (None, Some(_)) => {}
        _ => {
            let message = format!("material `{name}` needs one of `poisson` and `shear`");
            diagnostics.error(&["materials", name], message);
        }
    }
}

fn joints(raw: &RawRobot, frames: &[String], diagnostics: &mut Collector) {
    for (joint, springs) in &raw.joint_stiffness {
        let path = ["joint_stiffness", joint.as_str()];
        diagnostics.known(&path, "frame", joint, names(frames));
        let frame = raw.frames.get(joint);
        let fixed = frame.is_some_and(|frame| matches!(frame.joint, None | Some(JointKind::Fixed)));
        if fixed && !diagnostics.explained(&["frames", joint, "joint"]) {
            let message = format!("frame `{joint}` is fixed, and has no joint to be stiff");
            diagnostics.reject(&path, message, "name a frame that moves, or lay a beam");
        }
        if let Some(at) = &springs.at {
            diagnostics.known(&["joint_stiffness", joint, "at"], "node", at, nodes(raw, frames));
        }
        let driven = raw.actuators.values().any(|of| of.joint.as_deref() == Some(joint) && of.axial.is_some());
        let held = frame.is_some_and(|frame| frame.passive) || driven;
        let axis = own_axis(frame.and_then(|frame| frame.joint).unwrap_or(JointKind::Revolute));
        for (k, row) in JOINT.iter().enumerate() {
            let also = if held && k == axis { Also::RigidOrFree } else { Also::Rigid };
            stiffness(diagnostics, &["joint_stiffness", joint, row.symbol], (row.get)(springs), also);
        }
        for (all, single) in [(1, [4, 5]), (3, [6, 7])] {
            let given = |k: usize| (JOINT[k].get)(springs).is_some();
            let symbol = JOINT[all].symbol;
            if let Some(&k) = single.iter().find(|&&k| given(all) && given(k)) {
                let message = format!("joint `{joint}` has `{symbol}`, of both directions, and `{}`", JOINT[k].symbol);
                let remedy = format!("give `{symbol}`, or `{symbol}x` and `{symbol}y`");
                diagnostics.reject(&["joint_stiffness", joint, JOINT[k].symbol], message, remedy);
            }
        }
    }
}

fn validate_beam(raw: &RawRobot, frames: &[String], name: &str, beam: &RawBeam, diagnostics: &mut Collector) {
    for (key, node) in [("from", &beam.from), ("to", &beam.to)] {
        match node {
            Some(node) => diagnostics.known(&["beams", name, key], "node", node, nodes(raw, frames)),
            None => {
                diagnostics.lacking(&["beams", name], key, format!("beam `{name}` lacks `{key}`"));
            }
        }
    }
    if let Some((first, second)) = two_bodies(raw, frames, beam) {
        let message = format!("beam `{name}` joins nodes of two bodies, `{first}` and `{second}`");
        let remedy = "declare both nodes on the body that the beam is (`body:`, with `at:` for where)";
        diagnostics.reject(&["beams", name], message, remedy);
    }
    if beam.from.is_some() && beam.from == beam.to {
        diagnostics.error(&["beams", name, "to"], format!("beam `{name}` ends where it begins"));
    }
    let sections = raw.sections.keys().map(String::as_str);
    let materials = raw.materials.keys().map(String::as_str);
    if let Some(section) = &beam.section {
        diagnostics.known(&["beams", name, "section"], "section", section, sections.clone());
    } else {
        diagnostics.lacking(&["beams", name], "section", format!("beam `{name}` lacks `section`"));
    }
    if let Some(section) = &beam.section_to {
        diagnostics.known(&["beams", name, "section_to"], "section", section, sections);
    }
    if let Some(material) = &beam.material {
        diagnostics.known(&["beams", name, "material"], "material", material, materials);
    } else {
        diagnostics.lacking(&["beams", name], "material", format!("beam `{name}` lacks `material`"));
    }
    if let Some(normal) = &beam.normal {
        diagnostics.known(&["beams", name, "normal"], "frame", normal, names(frames));
    }
    if beam.elements.is_some_and(|n| !(1..=1000).contains(&n)) {
        diagnostics.error(&["beams", name, "elements"], "a beam is cut into 1 to 1000 elements");
    }
}

/// The two bodies whose nodes a beam joins, unless they are one, or those of neighbouring frames.
fn two_bodies<'r>(raw: &'r RawRobot, frames: &[String], beam: &'r RawBeam) -> Option<(&'r str, &'r str)> {
    let body = |node: &'r str| {
        let body = raw.nodes.get(node).map_or(Some(node), |node| node.body.as_deref());
        body.filter(|body| names(frames).any(|known| known == *body))
    };
    let (from, to) = (beam.from.as_deref()?, beam.to.as_deref()?);
    let (first, second) = (body(from)?, body(to)?);
    let carries = |a: &str, b: &str| raw.frames.get(b).is_some_and(|f| f.antecedent.as_deref() == Some(a));
    let neighbours =
        ![from, to].iter().any(|name| raw.nodes.contains_key(*name)) && (carries(from, to) || carries(to, from));
    (rigid_root(raw, first) != rigid_root(raw, second) && !neighbours).then_some((first, second))
}

/// The frame of a body that slides, and that of the body before it, where `at` is a frame of neither and of none that it carries.
fn slides_in<'r>(raw: &'r RawRobot, body: &'r str, at: &'r str) -> Option<(&'r str, &'r str)> {
    let own = rigid_root(raw, body);
    let of = |frame: &str| raw.frames.get(frame).and_then(|frame| frame.antecedent.as_deref());
    let before = of(own).filter(|_| raw.frames.get(own).is_some_and(|own| own.joint == Some(JointKind::Prismatic)))?;
    let there = rigid_root(raw, at);
    let is_near =
        there == own || there == rigid_root(raw, before) || of(there).is_some_and(|of| rigid_root(raw, of) == own);
    (!is_near && (at == "0" || raw.frames.contains_key(at))).then_some((own, before))
}

/// The frame that moves a body: fixed frames belong to the body of their antecedent.
fn rigid_root<'r>(raw: &'r RawRobot, frame: &'r str) -> &'r str {
    let mut root = frame;
    for _ in 0..raw.frames.len() {
        match raw.frames.get(root) {
            Some(own) if matches!(own.joint, None | Some(JointKind::Fixed)) => match &own.antecedent {
                Some(antecedent) => root = antecedent,
                None => break,
            },
            _ => break,
        }
    }
    root
}

fn validate_section(diagnostics: &mut Collector, name: &str, section: &RawSection) {
    for row in &SECTION {
        positive(diagnostics, &["sections", name, row.symbol], row.symbol, (row.get)(section));
    }
    let needed = section_symbols(section.shape);
    for key in SECTION.iter().filter(|row| needed.contains(&row.symbol) && (row.get)(section).is_none()) {
        let message = format!("section `{name}` lacks `{}`", key.symbol);
        if let Some(diagnostic) = diagnostics.lacking(&["sections", name], key.symbol, message) {
            diagnostic.remedy = Some(format!("this kind of section needs: {}", needed.join(", ")));
        }
    }
    let thin = [section.width, section.height, section.diameter].into_iter().flatten().fold(f64::INFINITY, f64::min);
    if let Some(wall) = section.wall
        && section.shape != Some(SectionShape::I)
        && 2.0 * wall >= thin
    {
        diagnostics
            .error(&["sections", name, "wall"], format!("a wall of {wall} leaves no hollow in a section of {thin}"));
    }
}

fn positive(diagnostics: &mut Collector, path: &[&str], key: &str, value: Option<f64>) {
    if let Some(value) = value
        && !(value.is_finite() && value > 0.0)
    {
        let remedy = match key {
            "density" => "give it in kg/m^3; leave `density` out where own weight is not to count",
            _ => "correct it, in the unit that `units:` says",
        };
        diagnostics.reject(path, format!("`{key}` is {value}, and must be a finite number above 0"), remedy);
    }
}

/// What a stiffness may be other than a finite number above 0.
#[derive(Clone, Copy, PartialEq)]
enum Also {
    /// Rigid.
    Rigid,
    /// Rigid, or free.
    RigidOrFree,
    /// Nothing.
    Nothing,
}

fn stiffness(diagnostics: &mut Collector, path: &[&str], stiffness: Option<&RawStiffness>, also: Also) {
    let Some(given) = stiffness else { return };
    let (value, inverse) = (given.value, given.compliance);
    if given.value.is_some() != given.compliance.is_some() {
        let free = value == Some(0.0) || inverse == Some(f64::INFINITY);
        let rigid = inverse == Some(0.0) || value == Some(f64::INFINITY);
        if free && also != Also::RigidOrFree {
            let shown = value.or(inverse).unwrap_or_default();
            diagnostics.reject(
                path,
                format!("`{shown}` is no stiffness here: nothing would hold it"),
                "give a number above 0; only a joint's axis that its loop or its screw holds may be free",
            );
        } else if rigid && also == Also::Nothing {
            diagnostics.reject(
                path,
                "a spring must give: its rate is a finite number above 0",
                "leave the spring out, or give its rate",
            );
        }
    }
    match (given.value, given.compliance) {
        (Some(value), None) | (None, Some(value)) if value >= 0.0 => {}
        (Some(value), None) | (None, Some(value)) => {
            diagnostics.reject(path, format!("`{value}` must be 0 or more"), "rigid is `.inf`, free is 0");
        }
        (Some(_), Some(_)) => {
            diagnostics.reject(
                path,
                "both `value` and `compliance` are given",
                "keep one; each is the other's inverse",
            );
        }
        (None, None) => {
            diagnostics.reject(
                path,
                "neither `value` nor `compliance` is given",
                "rigid is `value: .inf`, free is `value: 0`",
            );
        }
    }
    let mut bounds_path = path.to_vec();
    bounds_path.push("bounds");
    if let Some([low, high]) = diagnostics.interval(&bounds_path, given.bounds, 1.0, true) {
        if low < 0.0 {
            diagnostics.error(&bounds_path, format!("a stiffness cannot be below 0, as {low} is"));
        }
        let value = given.value.or(given.compliance.map(f64::recip));
        if let Some(value) = value
            && !(low * (1.0 - 1e-12)..=high * (1.0 + 1e-12)).contains(&value)
        {
            diagnostics.error(&bounds_path, format!("the value {value} lies outside its bounds [{low}, {high}]"));
        }
    }
}

fn springs(raw: &RawRobot, frames: &[String], diagnostics: &mut Collector) {
    for (name, spring) in &raw.springs {
        match &spring.bodies {
            None => {
                diagnostics.lacking(&["springs", name], "bodies", format!("spring `{name}` lacks `bodies`"));
            }
            Some(bodies) => {
                for (k, body) in bodies.iter().enumerate().filter(|(_, body)| !frames.contains(body)) {
                    let path = ["springs", name, "bodies", &k.to_string()];
                    diagnostics.unknown(&path, "frame", body, frames.iter().map(String::as_str));
                }
            }
        }
        for (k, anchor) in spring.anchors.unwrap_or_default().iter().enumerate() {
            diagnostics.vector(&["springs", name, "anchors", &k.to_string()], Some(*anchor), 1.0);
        }
        if spring.anchors.is_none() {
            diagnostics.lacking(&["springs", name], "anchors", format!("spring `{name}` lacks `anchors`"));
        }
        if spring.rate.is_none() {
            diagnostics.lacking(&["springs", name], "rate", format!("spring `{name}` lacks `rate`"));
        }
        stiffness(diagnostics, &["springs", name, "rate"], spring.rate.as_ref(), Also::Nothing);
        for (key, value) in [("free_length", spring.free_length), ("preload_length", spring.preload_length)] {
            positive(diagnostics, &["springs", name, key], key, value);
        }
        diagnostics.finite(&["springs", name, "preload"], spring.preload, 1.0);
        if spring.free_length.is_some() && spring.preload.is_some() {
            diagnostics.reject(&["springs", name, "preload"], "both `free_length` and `preload` are given", "keep one");
        }
        if spring.preload.is_some() != spring.preload_length.is_some() {
            diagnostics.error(&["springs", name], "`preload` and `preload_length` go together");
        }
    }
}
