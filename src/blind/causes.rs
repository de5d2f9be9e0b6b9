//! Which causes are drawn: effects of the catalogue in shapes of their own, and what no catalogue knows. Lengths in m,
//! angles in rad, loads in N and N.m; the shapes say what their numbers are.

use nalgebra::Vector3;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::loads::lengths_of;
use super::shapes::Shape;
use crate::model::Model;

/// Effect, site, shape; none where the robot has not what the shape needs.
pub type Drawing = Option<(&'static str, String, Shape)>;

/// A turn, rad.
const TURN: f64 = std::f64::consts::TAU;

/// An effect of the catalogue at a site, in a shape of its own.
pub fn known(model: &Model, is_deflection: bool, random: &mut ChaCha8Rng) -> Drawing {
    let variable = random.random_range(0..model.variables.len());
    let frame = random.random_range(1..model.frames.len());
    let mut draw = Draw { model, random, variable, joint: model.joint_of(variable)?, frame };
    if is_deflection { draw.of_deflection() } else { draw.of_position() }
}

/// The site of a marker; that of the tool where the robot has none.
pub fn at_marker(model: &Model, marker: usize) -> String {
    model.markers.get(marker).map_or_else(|| "tool".into(), |own| format!("marker:{}", own.name))
}

/// Something that the catalogue does not know, or a marker that slips, which it has.
pub fn unknown(model: &Model, is_deflection: bool, random: &mut ChaCha8Rng) -> Drawing {
    let count = model.variables.len();
    let variable = random.random_range(0..count);
    let kind = random.random_range(0..4);
    let mut draw = Draw { model, random, variable, joint: model.joint_of(variable)?, frame: 0 };
    let by_load = is_deflection;
    let (name, shape) = match kind {
        0 => {
            let a = draw.within(0.0, count as f64) as usize % count;
            let b = (a + 1 + draw.within(0.0, count as f64 - 1.0) as usize) % count;
            ("product of two joints", Shape::Product { variable, of: [a, b], by_load })
        }
        1 => ("hoses", Shape::Hoses { variable, of: [0, 3.min(count - 1)], by_load }),
        2 => {
            let waves = (0..12)
                .map(|_| {
                    let frequencies = (0..count).map(|_| draw.within(-1.5, 1.5)).collect();
                    let along = draw.vector();
                    (frequencies, draw.within(0.0, 6.3), along)
                })
                .collect();
            ("smooth function", Shape::Smooth { waves, by_force: by_load })
        }
        _ => {
            let marker = draw.within(0.0, model.markers.len() as f64) as usize % model.markers.len();
            let by = draw.vector();
            let slip = Shape::Slip { marker, at: draw.within(0.25, 0.75), by };
            return Some(("marker-slip", at_marker(model, marker), slip));
        }
    };
    Some((name, String::new(), shape))
}

/// A draw of one cause: a variable with its joint, a frame, and what is random in the shape.
struct Draw<'a> {
    model: &'a Model,
    random: &'a mut ChaCha8Rng,
    variable: usize,
    joint: usize,
    frame: usize,
}

impl Draw<'_> {
    fn within(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.random.random::<f64>()
    }

    fn vector(&mut self) -> Vector3<f64> {
        Vector3::new(self.within(-1.0, 1.0), self.within(-1.0, 1.0), self.within(-1.0, 1.0))
    }

    fn at_joint(&self, joint: usize) -> String {
        format!("joint:{}", self.model.frames[joint].name)
    }

    fn at_link(&self) -> String {
        format!("link:{}", self.model.frames[self.frame].name)
    }

    /// Other constants of an owner, by symbol and share; none where the robot has none of them.
    fn constants(&self, owner: &str, shares: &[(&str, f64)]) -> Option<Shape> {
        let slot =
            |(symbol, share): &(&str, f64)| Some((self.model.registry.slot(&format!("{owner}.{symbol}"))?, *share));
        let slots: Vec<_> = shares.iter().filter_map(slot).collect();
        (!slots.is_empty()).then_some(Shape::Constants(slots))
    }

    fn is_serial(&self) -> bool {
        self.model.actuators.is_empty()
    }

    /// Effects that a load shows, in deflections and in positions under own weight.
    fn of_load(&mut self, kind: usize) -> Drawing {
        let (variable, joint, frame) = (self.variable, self.joint, self.frame);
        let at_joint = self.at_joint(joint);
        Some(match kind {
            0 => ("joint-stiffening", at_joint, Shape::WindUp { variable, soft: self.within(0.06, 0.5) }),
            1 if self.is_serial() => {
                ("bearing-compliance", at_joint, Shape::Tilt { frame: joint, unequal: self.within(-0.25, 0.25) })
            }
            1 => {
                let owner = format!("joint{}", self.model.frames[joint].name);
                ("bearing-compliance", at_joint, self.constants(&owner, &[("krr", 1.0)])?)
            }
            2 => {
                let shares = [self.within(0.6, 1.4), self.within(0.6, 1.4)];
                ("base-compliance", "base".into(), Shape::Rocking { shares, more: self.within(-0.2, 0.3) })
            }
            3 => {
                let [y, z, torsion] = [self.within(0.5, 1.5), self.within(0.5, 1.5), self.within(0.0, 1.0)];
                let owner = format!("link{}", self.model.frames[frame].name);
                let shares = [("bending_y", y), ("bending_z", z), ("torsion", torsion)];
                ("link-compliance", self.at_link(), self.constants(&owner, &shares)?)
            }
            _ => ("backlash", at_joint, Shape::Pressed { variable, soft: self.within(0.01, 0.03) }),
        })
    }

    fn of_deflection(&mut self) -> Drawing {
        match self.within(0.0, 9.0) as usize {
            kind @ 0..=4 => self.of_load(kind),
            5 | 6 if self.is_serial() => self.balancing_spring(),
            5 | 6 => {
                let actuator = self.model.actuators.get(usize::from(self.within(0.0, 1.0) > 0.5))?;
                let shape = self.constants(&actuator.name, &[("axial", 1.0)])?;
                Some(("actuator-compliance", format!("actuator:{}", actuator.name), shape))
            }
            7 => Some(("payload", "tool".into(), Shape::Gain)),
            _ => Some(("instrument-scale", "instrument".into(), Shape::Scale)),
        }
    }

    /// A spring that balances joint 1, 2 or 3, the stiffness of which goes with that of the joint.
    fn balancing_spring(&mut self) -> Drawing {
        let variable = usize::from(self.within(0.0, 3.0) > 1.0);
        let variable = variable + usize::from(variable == 1 && self.within(0.0, 3.0) > 2.0);
        let joint = self.model.joint_of(variable)?;
        let (a, b) = (self.within(0.3, 0.9), self.within(0.1, 0.3));
        let (angle, free) = (self.within(0.0, TURN), self.within(0.5, 0.9) * (a - b));
        let compliance = self
            .model
            .registry
            .slot(&format!("joint{}.kar", self.model.frames[joint].name))
            .map_or(1e-6, |slot| self.model.registry[slot].nominal.max(1e-8));
        let shape = Shape::Spring { variable, compliance, a, b, angle, free, rate: 1e-3 / compliance };
        Some(("gravity-compensator", self.at_joint(joint), shape))
    }

    fn of_position(&mut self) -> Drawing {
        let (model, variable, frame, count) = (self.model, self.variable, self.frame, self.model.variables.len());
        let (at_joint, at_link) = (self.at_joint(self.joint), self.at_link());
        Some(match self.within(0.0, 16.0) as usize {
            kind @ 0..=3 => return self.of_load(kind),
            4 | 5 => {
                let orders = [1.0, 2.0, 2.0, 3.0, 4.0, 5.0, 7.0];
                let order = orders[(self.within(0.0, 7.0) as usize).min(6)];
                let second = [self.within(0.05, 0.3), self.within(0.0, TURN)];
                let phase = self.within(0.0, TURN);
                ("transmission-error", at_joint, Shape::Swing { variable, order, phase, second })
            }
            6 | 7 => ("backlash", at_joint, Shape::Play { variable, by_load: self.within(-0.3, 0.3) }),
            8 => ("gear-ratio", at_joint, Shape::Ratio { variable, zero: self.within(-1.0, 1.0) }),
            9 => {
                let other = (variable + 1 + self.within(0.0, (count - 1) as f64) as usize) % count;
                (other != variable).then_some(("joint-coupling", at_joint, Shape::Follows { variable, other }))?
            }
            10 => ("joint-compliance", at_joint, Shape::Compliant { variable, less: self.within(0.0, 0.2) }),
            11 => {
                let shares = [("mass", 1.0), ("x", self.within(-5e-3, 5e-3)), ("y", self.within(-5e-3, 5e-3))];
                (frame != model.tool.0).then_some(())?;
                let owner = format!("body{}", model.frames[frame].name);
                ("link-weight", at_link, self.constants(&owner, &shares)?)
            }
            12 => {
                let shares = [("mass", 1.0), ("z", self.within(0.0, 3e-3))];
                let owner = format!("body{}", model.frames[model.tool.0].name);
                ("payload", "tool".into(), self.constants(&owner, &shares)?)
            }
            13 => {
                let lengths = lengths_of(model, frame);
                (!lengths.is_empty()).then_some(("thermal-expansion", at_link, Shape::Growth(lengths)))?
            }
            14 => ("frame-drift", "base".into(), self.drift()),
            _ => ("instrument-scale", "instrument".into(), Shape::Scale),
        })
    }

    /// A jump, or a walk that keeps on in the main, with turns.
    fn drift(&mut self) -> Shape {
        let jump = self.within(0.0, 1.0) > 0.5;
        if jump {
            return Shape::Wanders { knots: vec![[0.0; 6], self.knot()], jump };
        }
        let (trend, mut at) = (self.knot(), [0.0; 6]);
        let mut step = || {
            let step = self.knot();
            let before = at;
            (0..6).for_each(|k| at[k] += trend[k] + 0.5 * step[k]);
            before
        };
        Shape::Wanders { knots: (0..5).map(|_| step()).collect(), jump }
    }

    /// Displacement and rotation of about normal distribution, the rotations smaller.
    fn knot(&mut self) -> [f64; 6] {
        [1.0, 1.0, 1.0, 0.4, 0.4, 0.4]
            .map(|size| size * (self.within(0.0, 1.0) + self.within(0.0, 1.0) + self.within(0.0, 1.0) - 1.5))
    }
}
