//! Random robots as descriptions, put together so that their loops close at a known configuration.

use std::fmt::Write;

use elastogeo::kinematics::Transform;
use nalgebra::{Rotation3, Translation3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// A frame to be written, and the joint value (declared zero included) at the known configuration.
#[derive(Clone, Default)]
pub struct Part {
    pub name: String,
    pub antecedent: String,
    /// `revolute`, `prismatic` or empty.
    pub joint: &'static str,
    /// What moves it, as YAML (`variable: q1`, `passive: true` or nothing).
    pub drive: String,
    pub coaxial: Option<String>,
    /// beta, gamma, b, alpha, d, theta, r.
    pub constants: [f64; 7],
    pub offset: f64,
    pub direction: f64,
    pub value: f64,
}

const SYMBOLS: [&str; 7] = ["beta", "gamma", "b", "alpha", "d", "theta", "r"];

/// The placement by its definition, written anew: Ry(beta) Rz(gamma) Tz(b) Rx(alpha) Tx(d) Rz(theta) Tz(r).
pub fn placed(c: &[f64; 7], joint: &str, value: f64) -> Transform {
    let turn = |axis, angle| Transform::from_parts(Translation3::identity(), Rotation3::from_axis_angle(&axis, angle));
    let slide = |v: Vector3<f64>| Transform::from_parts(v.into(), Rotation3::identity());
    let theta = c[5] + if joint == "revolute" { value } else { 0.0 };
    let r = c[6] + if joint == "prismatic" { value } else { 0.0 };
    turn(Vector3::y_axis(), c[0])
        * turn(Vector3::z_axis(), c[1])
        * slide(Vector3::z() * c[2])
        * turn(Vector3::x_axis(), c[3])
        * slide(Vector3::x() * c[4])
        * turn(Vector3::z_axis(), theta)
        * slide(Vector3::z() * r)
}

/// Constants (beta 0) of a fixed frame whose placement is given.
pub fn constants_of(placement: &Transform) -> [f64; 7] {
    let m = placement.rotation.matrix();
    let p = placement.translation.vector;
    let (sine, cosine) = (m[(0, 2)].hypot(m[(1, 2)]), m[(2, 2)]);
    if sine < 1e-9 {
        let gamma = p.y.atan2(p.x);
        let alpha = if cosine > 0.0 { 0.0 } else { std::f64::consts::PI };
        let heading = m[(1, 0)].atan2(m[(0, 0)]);
        let theta = if cosine > 0.0 { heading - gamma } else { gamma - heading };
        return [0.0, gamma, p.z, alpha, p.x.hypot(p.y), theta, 0.0];
    }
    let gamma = m[(0, 2)].atan2(-m[(1, 2)]);
    let alpha = sine.atan2(cosine);
    let theta = m[(2, 0)].atan2(m[(2, 1)]);
    let turned = Rotation3::from_axis_angle(&Vector3::z_axis(), -gamma) * p;
    let r = -turned.y / sine;
    [0.0, gamma, turned.z - r * cosine, alpha, turned.x, theta, r]
}

pub struct Draw(ChaCha8Rng);

impl Draw {
    pub fn new(seed: u64) -> Self {
        Self(ChaCha8Rng::seed_from_u64(seed))
    }
    pub fn within(&mut self, low: f64, high: f64) -> f64 {
        self.0.random_range(low..high)
    }
    pub fn below(&mut self, n: usize) -> usize {
        self.0.random_range(0..n)
    }
    pub fn chance(&mut self, p: f64) -> bool {
        self.0.random::<f64>() < p
    }
    pub fn constants(&mut self) -> [f64; 7] {
        let angle = |draw: &mut Self| if draw.chance(0.3) { 0.0 } else { draw.within(-1.5, 1.5) };
        let length = |draw: &mut Self| if draw.chance(0.3) { 0.0 } else { draw.within(-0.8, 0.8) };
        let beta = if self.chance(0.3) { self.within(-0.3, 0.3) } else { 0.0 };
        [beta, angle(self), length(self), angle(self), length(self), angle(self), length(self)]
    }
    pub fn constants_in_plane(&mut self) -> [f64; 7] {
        [0.0, self.within(-1.5, 1.5), 0.0, 0.0, self.within(0.4, 1.2), self.within(-1.0, 1.0), 0.0]
    }
    pub fn part(&mut self, name: &str, antecedent: &str, joint: &'static str, drive: &str) -> Part {
        Part {
            name: name.into(),
            antecedent: antecedent.into(),
            joint,
            drive: drive.into(),
            constants: self.constants(),
            offset: if self.chance(0.5) { self.within(-0.2, 0.2) } else { 0.0 },
            direction: if self.chance(0.3) { -1.0 } else { 1.0 },
            value: self.within(-0.8, 0.8),
            ..Part::default()
        }
    }
}

/// A robot to be written.
#[derive(Default)]
pub struct Sketch {
    pub parts: Vec<Part>,
    pub couplings: Vec<String>,
    /// Name, frames, kind, what meets.
    pub loops: Vec<(String, [String; 2], &'static str, &'static str)>,
    /// Name, joint, variable, l1, l3, kappa, lambda, stroke zero.
    pub actuators: Vec<(String, String, String, [f64; 5])>,
    pub tool: String,
}

impl Sketch {
    pub fn part(&self, name: &str) -> &Part {
        self.parts.iter().find(|part| part.name == name).expect("a part")
    }

    /// Placement of a part at the known configuration.
    pub fn pose(&self, name: &str) -> Transform {
        if name == "0" {
            return Transform::identity();
        }
        let part = self.part(name);
        let mut constants = part.constants;
        if let Some(other) = &part.coaxial {
            constants[..5].copy_from_slice(&self.part(other).constants[..5]);
        }
        self.pose(&part.antecedent) * placed(&constants, part.joint, part.value)
    }

    /// Adds a fixed frame after `antecedent` where `other` is at the known configuration, and the loop between them.
    pub fn close(&mut self, antecedent: &str, other: &str, kind: &'static str, meet: &'static str) {
        let there = self.pose(antecedent).inv_mul(&self.pose(other));
        let name = format!("cut{}", self.loops.len());
        let constants = constants_of(&there);
        self.parts.push(Part {
            name: name.clone(),
            antecedent: antecedent.into(),
            constants,
            direction: 1.0,
            ..Part::default()
        });
        self.loops.push((format!("loop{}", self.loops.len()), [other.into(), name], kind, meet));
    }

    /// Value of a variable at the known configuration.
    fn variable_at(part: &Part) -> f64 {
        part.direction * (part.value - part.offset)
    }

    pub fn yaml(&self) -> String {
        let mut text = String::from("frames:\n");
        for part in &self.parts {
            write!(text, "  {}: {{antecedent: {}", part.name, part.antecedent).expect("text");
            if !part.joint.is_empty() {
                write!(text, ", joint: {}", part.joint).expect("text");
            }
            if !part.drive.is_empty() {
                write!(text, ", {}", part.drive).expect("text");
            }
            if part.drive.starts_with("variable") && part.direction < 0.0 {
                text.push_str(", direction: -1");
            }
            if part.offset != 0.0 && !part.joint.is_empty() && !part.drive.starts_with("passive") {
                write!(text, ", offset: {:?}", part.offset).expect("text");
            }
            if let Some(other) = &part.coaxial {
                write!(text, ", coaxial: {other}").expect("text");
            }
            let first = if part.coaxial.is_some() { 5 } else { 0 };
            for (symbol, value) in SYMBOLS.into_iter().zip(part.constants).skip(first) {
                if value != 0.0 {
                    write!(text, ", {symbol}: {value:?}").expect("text");
                }
            }
            text.push_str("}\n");
        }
        if !self.couplings.is_empty() {
            writeln!(text, "couplings: {:?}", self.couplings).expect("text");
        }
        if !self.actuators.is_empty() {
            text.push_str("actuators:\n");
            for (name, joint, variable, [zero, kappa, lambda, l1, l3]) in &self.actuators {
                writeln!(
                    text,
                    "  {name}: {{kind: slider-crank, joint: {joint}, variable: {variable}, stroke: {zero:?}, kappa: {kappa:?}, lambda: {lambda:?}, l1: {l1:?}, l3: {l3:?}}}"
                )
                .expect("text");
            }
        }
        if !self.loops.is_empty() {
            let joined = |list: Vec<String>| list.join(", ");
            let passive = self.parts.iter().filter(|part| part.drive.starts_with("passive"));
            let all: Vec<(&str, f64)> = passive.map(|part| (part.name.as_str(), part.value)).collect();
            let at = joined(self.at().iter().map(|(name, value)| format!("{name}: {value:?}")).collect());
            text.push_str("loops:\n");
            for (name, [a, b], kind, meet) in &self.loops {
                let own = [self.ancestors(a), self.ancestors(b)].concat();
                let branch = all.iter().filter(|(name, _)| own.iter().any(|other| other == name));
                let branch = joined(branch.map(|(name, value)| format!("{name}: {value:?}")).collect());
                writeln!(
                    text,
                    "  {name}: {{frames: [{a}, {b}], kind: {kind}, meet: {meet}, branch: {{{branch}}}, at: {{{at}}}}}"
                )
                .expect("text");
            }
        }
        writeln!(text, "tool: {{frame: {}}}", self.tool).expect("text");
        text
    }

    fn ancestors(&self, name: &str) -> Vec<String> {
        if name == "0" {
            return Vec::new();
        }
        let mut list = self.ancestors(&self.part(name).antecedent);
        list.push(name.into());
        list
    }

    /// Variables at the known configuration, by name.
    pub fn at(&self) -> Vec<(String, f64)> {
        let mut at = Vec::new();
        for part in &self.parts {
            if let Some(variable) = part.drive.strip_prefix("variable: ") {
                at.push((variable.to_string(), Self::variable_at(part)));
            }
        }
        for (_, joint, variable, [zero, kappa, lambda, l1, l3]) in &self.actuators {
            let part = self.part(joint);
            let angle = kappa + lambda - (part.value - part.offset);
            at.push((variable.clone(), (l1 * l1 + l3 * l3 + 2.0 * l1 * l3 * angle.cos()).sqrt() - zero));
        }
        at
    }

    /// Lets a slider-crank turn a joint that has had a variable.
    pub fn drive_by_crank(&mut self, joint: &str, draw: &mut Draw) {
        let part = self.parts.iter_mut().find(|part| part.name == joint).expect("a part");
        let variable = part.drive.trim_start_matches("variable: ").to_string();
        part.drive = String::new();
        part.direction = 1.0;
        let open = draw.within(0.8, 2.2);
        let kappa = draw.within(0.2, 1.0);
        let lambda = open - kappa + part.value - part.offset;
        let constants = [draw.within(-0.1, 0.1), kappa, lambda, draw.within(0.3, 0.5), draw.within(0.6, 0.9)];
        self.actuators.push((format!("screw-{joint}"), joint.into(), variable, constants));
    }
}

/// An open chain: joints of both kinds, fixed frames, followers (of followers too), coaxial frames, slider-cranks.
pub fn serial(seed: u64) -> Sketch {
    let draw = &mut Draw::new(seed);
    let mut sketch = Sketch::default();
    let mut last = "0".to_string();
    let mut joints: Vec<(String, &'static str)> = Vec::new();
    for k in 0..2 + draw.below(7) {
        let joint = if draw.chance(0.25) { "prismatic" } else { "revolute" };
        let name = format!("j{k}");
        let follow = joints.len() >= 2 && draw.chance(0.3);
        let drive = if follow { String::new() } else { format!("variable: q{k}") };
        let mut part = draw.part(&name, &last, joint, &drive);
        if follow {
            let mut text = format!("{name} =");
            let first = draw.below(joints.len() - 1);
            for (n, (other, _)) in [&joints[first], &joints[joints.len() - 1]].into_iter().enumerate() {
                let factor = draw.within(-1.5, 1.5);
                let sign = if n == 0 { " " } else { " + " };
                write!(text, "{sign}{factor:?} * {other}").expect("text");
            }
            sketch.couplings.push(text);
            part.direction = 1.0;
        }
        sketch.parts.push(part);
        last = name.clone();
        if joint == "revolute" && !follow && draw.chance(0.2) {
            sketch.drive_by_crank(&name, draw);
        } else if joint == "revolute" && draw.chance(0.2) {
            let antecedent = sketch.part(&name).antecedent.clone();
            let coaxial = format!("c{k}");
            let mut part = draw.part(&coaxial, &antecedent, "revolute", &format!("variable: p{k}"));
            part.coaxial = Some(name.clone());
            sketch.parts.push(part);
            if draw.chance(0.5) {
                last = coaxial;
            }
        }
        joints.push((name, joint));
        if draw.chance(0.2) {
            let fixed = format!("f{k}");
            let part = draw.part(&fixed, &last, "", "");
            sketch.parts.push(part);
            last = fixed;
        }
    }
    sketch.tool = last;
    sketch
}

/// Two legs in a plane from one body: a four-bar, or a five-bar with two variables; pinned or with a cut joint.
pub fn planar(seed: u64) -> Sketch {
    let draw = &mut Draw::new(seed);
    let mut sketch = Sketch::default();
    let part = draw.part("g", "0", "revolute", "variable: q0");
    sketch.parts.push(part);
    let mut a1 = draw.part("a1", "g", "revolute", "variable: q1");
    let two = draw.chance(0.5);
    let mut b1 = draw.part("b1", "g", "revolute", if two { "variable: q2" } else { "passive: true" });
    if two && draw.chance(0.5) {
        b1.coaxial = Some("a1".into());
        b1.value = a1.value + draw.within(0.5, 1.5);
    } else {
        a1.constants = draw.constants_in_plane();
        b1.constants = draw.constants_in_plane();
        (a1.constants[2], b1.constants[2]) = (draw.within(-0.3, 0.3), draw.within(-0.3, 0.3));
        if draw.chance(0.3) {
            b1.constants[3] = std::f64::consts::PI;
        }
    }
    sketch.parts.push(a1);
    sketch.parts.push(b1);
    let crank = draw.chance(0.4);
    if crank {
        sketch.drive_by_crank("a1", draw);
    }
    let mut link = |sketch: &mut Sketch, name: &str, antecedent: &str| {
        let mut part = draw.part(name, antecedent, "revolute", "passive: true");
        part.constants = draw.constants_in_plane();
        part.constants[6] = draw.within(-0.2, 0.2);
        sketch.parts.push(part);
    };
    link(&mut sketch, "a2", "a1");
    let pinned = draw_pinned(seed);
    let last = if two {
        link(&mut sketch, "b2", "b1");
        "b2"
    } else {
        "b1"
    };
    link(&mut sketch, "a3", "a2");
    if pinned {
        // The pin needs no joint of its own.
        let part = sketch.parts.last_mut().expect("a part");
        (part.joint, part.drive, part.offset) = ("", String::new(), 0.0);
        part.value = 0.0;
    }
    sketch.close(last, "a3", "planar", if pinned { "origin" } else { "frame" });
    let draw = &mut Draw::new(seed ^ 5);
    let mut hand = draw.part("h", "a2", "revolute", "variable: q3");
    hand.constants[3] = 0.7;
    sketch.parts.push(hand);
    sketch.tool = "h".into();
    sketch
}

fn draw_pinned(seed: u64) -> bool {
    Draw::new(seed ^ 9).chance(0.5)
}

/// A six-bar: two pinned loops that share a passive joint and are closed together.
pub fn two_loops(seed: u64) -> Sketch {
    let draw = &mut Draw::new(seed);
    let mut sketch = Sketch::default();
    let drives = ["variable: q1", "passive: true", "passive: true", "passive: true", "passive: true"];
    let names = [("a1", "0"), ("a2", "a1"), ("b1", "0"), ("c1", "a2"), ("d1", "0")];
    for ((name, antecedent), drive) in names.into_iter().zip(drives) {
        let mut part = draw.part(name, antecedent, "revolute", drive);
        part.constants = draw.constants_in_plane();
        sketch.parts.push(part);
    }
    for (name, antecedent) in [("a3", "a2"), ("c2", "c1")] {
        let mut part = draw.part(name, antecedent, "", "");
        part.constants = draw.constants_in_plane();
        part.value = 0.0;
        sketch.parts.push(part);
    }
    sketch.close("b1", "a3", "planar", "origin");
    sketch.close("d1", "c2", "planar", "origin");
    sketch.tool = "c2".into();
    sketch
}

/// A loop in space: one variable and six passive joints of both kinds, or three passive ones and a ball joint.
pub fn spatial(seed: u64) -> Sketch {
    let draw = &mut Draw::new(seed);
    let mut sketch = Sketch::default();
    let ball = draw.chance(0.5);
    let passive = if ball { 3 } else { 6 };
    let driver = draw.part("g", "0", "revolute", "variable: q0");
    let first = draw.part("a0", "g", "revolute", "variable: q1");
    sketch.parts.push(driver);
    sketch.parts.push(first);
    if draw.chance(0.4) {
        sketch.drive_by_crank("a0", draw);
    }
    let mut ends = ["a0".to_string(), "g".to_string()];
    for k in 0..passive {
        let side = usize::from(draw.chance(0.6) || k == 0);
        let name = format!("{}{}", ["a", "b"][side], k + 1);
        let joint = if draw.chance(0.2) { "prismatic" } else { "revolute" };
        let mut part = draw.part(&name, &ends[side], joint, "passive: true");
        part.constants[3] = draw.within(0.4, 1.5);
        part.constants[4] = draw.within(0.2, 0.8);
        sketch.parts.push(part);
        ends[side] = name;
    }
    let tip = draw.part("t", &ends[0], "", "");
    sketch.parts.push(Part { value: 0.0, ..tip });
    sketch.close(&ends[1].clone(), "t", "spatial", if ball { "origin" } else { "frame" });
    let follower = draw.part("h", "t", "revolute", "");
    sketch.parts.push(follower);
    let factor = draw.within(-1.0, 1.0);
    // A joint that follows one that the loop moves.
    let passive = sketch.parts.iter().find(|p| p.drive.starts_with("passive") && p.joint == "revolute");
    let leader = passive.map_or("a0".to_string(), |p| p.name.clone());
    sketch.couplings.push(format!("h = {factor:?} * {leader} + 0.5 * g"));
    sketch.tool = "h".into();
    sketch
}
