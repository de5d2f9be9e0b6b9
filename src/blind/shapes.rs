//! What withheld causes do, in shapes that are not the catalogue's: joints turn (rad), the base moves (m, rad), points are
//! displaced (m), each by a unit of the shape; a size multiplies it.

use nalgebra::Vector3;

use super::odd::Odd;
use super::situation::Situation;
use crate::parameter::Slot;

/// A cause in its shape; all are multiplied by a size.
#[derive(Debug, Clone)]
pub enum Shape {
    /// A joint swings with itself: a harmonic, and some of its second.
    Swing { variable: usize, order: f64, phase: f64, second: [f64; 2] },
    /// A joint lies on the flank that it came from, the more so the more it is loaded.
    Play { variable: usize, by_load: f64 },
    /// A joint lies on the flank that the load presses it to, less near balance.
    Pressed { variable: usize, soft: f64 },
    /// A joint turns more than commanded, counted from where its encoder is zero.
    Ratio { variable: usize, zero: f64 },
    /// A joint turns with another one.
    Follows { variable: usize, other: usize },
    /// A joint winds up under load in addition to its spring: saturating.
    WindUp { variable: usize, soft: f64 },
    /// A joint deflects under load, a little less at greater loads.
    Compliant { variable: usize, less: f64 },
    /// A spring between the links of a joint, whose joint has a `compliance`, rad/(N.m): anchors at `a` from the axis on the
    /// link before, at `b` on the link behind, and the angle between them at joint zero.
    Spring { variable: usize, compliance: f64, a: f64, b: f64, angle: f64, free: f64, rate: f64 },
    /// What comes after a frame tilts by the moment across its axis, unequally about its own x and y.
    Tilt { frame: usize, unequal: f64 },
    /// The foot rocks under the moment on it, about x and y by shares, more under great moments.
    Rocking { shares: [f64; 2], more: f64 },
    /// Constants of the model are others.
    Constants(Vec<(Slot, f64)>),
    /// Lengths grow with a temperature that lags the one measured.
    Growth(Vec<Slot>),
    /// The base wanders: knots of a smooth curve, or a jump.
    Wanders { knots: Vec<[f64; 6]>, jump: bool },
    /// The wrench is greater than stated.
    Gain,
    /// All lengths are measured too long.
    Scale,
    /// Outliers: reading, displacement in multiples of the noise.
    Outliers(Vec<(usize, Vector3<f64>)>),
    /// A joint turns with the product of two others' angles; times its load where `by_load`.
    Product { variable: usize, of: [usize; 2], by_load: bool },
    /// Hoses pull at a joint as the first and fourth turn; times its load where `by_load`.
    Hoses { variable: usize, of: [usize; 2], by_load: bool },
    /// The point is displaced by a smooth random function of the configuration: frequencies, phase, direction.
    Smooth { waves: Vec<(Vec<f64>, f64, Vector3<f64>)>, by_force: bool },
    /// One marker has slipped from some time on, along its frame's axes.
    Slip { marker: usize, at: f64, by: Vector3<f64> },
    /// What only the second generator has.
    Odd(Odd),
}

impl Shape {
    /// What a unit of it turns one joint by, rad: variable and angle.
    pub fn turns(&self, s: &Situation) -> Option<(usize, f64)> {
        let share = |v: usize, soft: f64| s.share(v, soft);
        Some(match *self {
            Self::Swing { variable, order, phase, second } => {
                let turned = order * s.joints[variable] + phase;
                (variable, turned.sin() + second[0] * (2.0 * turned + second[1]).cos())
            }
            Self::Play { variable, by_load } => {
                let pressed = 1.0 + by_load * share(variable, 1.0).clamp(-1.0, 1.0) * s.side[variable];
                (variable, s.side[variable] * pressed)
            }
            Self::Pressed { variable, soft } => {
                let x = share(variable, soft);
                (variable, x / (1.0 + x * x).sqrt())
            }
            Self::Ratio { variable, zero } => (variable, s.joints[variable] - zero),
            Self::Follows { variable, other } => (variable, s.q[other]),
            Self::WindUp { variable, soft } => {
                let x = share(variable, soft);
                (variable, x / (1.0 + x.abs()))
            }
            Self::Compliant { variable, less } => {
                let x = share(variable, 1.0);
                (variable, x * (1.0 - less * x.abs()))
            }
            Self::Spring { variable, compliance, a, b, angle, free, rate } => {
                // s^2 = a^2 + b^2 + 2ab cos(q + angle); the spring stiffens the joint by the change of its moment.
                let (sine, cosine) = (s.joints[variable] + angle).sin_cos();
                let length = (a * a + b * b + 2.0 * a * b * cosine).sqrt().max(1e-3);
                let first = -a * b * sine / length;
                let second = -a * b * cosine / length - first * first / length;
                let stiffness = rate * (first * first + (length - free) * second);
                let with = compliance / (1.0 + compliance * stiffness).max(0.2);
                (variable, (with - compliance) * s.load[variable])
            }
            Self::Product { variable, of, by_load } => {
                let product = s.q[of[0]] * s.q[of[1]];
                (variable, product * if by_load { share(variable, 1.0) } else { 1.0 })
            }
            Self::Hoses { variable, of, by_load } => {
                let pull = (s.q[of[0]] + 0.4).cos() * (0.8 * s.q[of[1]]).sin() + 0.3 * (s.q[of[0]] - s.q[of[1]]).sin();
                (variable, pull * if by_load { share(variable, 1.0) } else { 1.0 })
            }
            Self::Odd(ref odd) => return odd.turns(s),
            _ => return None,
        })
    }

    /// Pose change of the base by a unit of it: displacement and rotation vector.
    pub fn wanders(&self, time: f64) -> Option<[f64; 6]> {
        let Self::Wanders { knots, jump } = self else { return None };
        let last = knots.len() - 1;
        let at = (time.clamp(0.0, 1.0) * last as f64).min(last as f64 - 1e-9);
        let (k, part) = (at as usize, at.fract());
        // A jump happens at once, half way between the knots; a walk goes smoothly.
        let part = if *jump { f64::from(u8::from(part > 0.5)) } else { part * part * (3.0 - 2.0 * part) };
        Some(std::array::from_fn(|c| knots[k][c] * (1.0 - part) + knots[k + 1][c] * part))
    }

    /// Displacement by a unit of a smooth function at a configuration, m.
    pub fn smooth(&self, q: &[f64], force: f64) -> Option<Vector3<f64>> {
        let Self::Smooth { waves, by_force } = self else { return None };
        let wave = |(w, phase, along): &(Vec<f64>, f64, Vector3<f64>)| {
            along * (w.iter().zip(q).map(|(w, q)| w * q).sum::<f64>() + phase).sin()
        };
        Some(waves.iter().map(wave).sum::<Vector3<f64>>() * if *by_force { force } else { 1.0 })
    }
}
