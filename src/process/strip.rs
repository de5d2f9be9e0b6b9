//! A cantilever strip that the tip of a tool bends and slides on.
//!
//! The tool touches the surface in one point and pushes across it; friction, if any, drags the strip along with the
//! tool. With small slopes force and depth follow Euler and Bernoulli's cantilever, F = 3 EI depth / along^3. In large
//! bending the length between clamp and tool is not known beforehand: force and length are found together, so that the
//! surface of the elastica passes through the tool. Own weight of the strip and shear are left out; as a plate is not
//! meant, EI is that of a beam.

use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};

use super::elastica::{Tip, bend};
use super::plastic::{Bent, Plastic};
use super::{ProcessError, Push};
use crate::description::process::{RawStrip, Theory};
use crate::description::units::Units;

/// Newton's steps before the depth is approached in smaller parts.
const MOST: usize = 40;

/// A strip in the base frame, SI.
#[derive(Debug, Clone, PartialEq)]
pub struct Strip {
    /// Where its touched surface leaves the clamp, m.
    pub clamp: Vector3<f64>,
    /// Unit vector from the clamp to the free end.
    pub along: Vector3<f64>,
    /// Unit vector across it, in which the tool pushes.
    pub push: Vector3<f64>,
    /// Length, m.
    pub length: f64,
    /// Bending rigidity EI, N.m2.
    pub rigidity: f64,
    /// Half the height, m: from the centre line to the surface.
    pub offset: f64,
    /// Theory of bending.
    pub theory: Theory,
    /// Coefficient of friction.
    pub friction: f64,
    /// Where it yields, and how it has been bent.
    pub plastic: Option<Plastic>,
}

/// The tool on the strip.
struct Contact {
    /// Force across over rigidity, 1/m2.
    n: f64,
    /// Force along over force across.
    f: f64,
    /// Length of strip between clamp and tool, m.
    length: f64,
    /// Force of the tool on the strip (along, push), N.
    force: Vector2<f64>,
    /// Its derivative by place.
    gradient: Matrix2<f64>,
}

impl Strip {
    /// A strip from a file without faults.
    pub fn new(raw: &RawStrip, units: &Units) -> Self {
        let length = units.length.factor();
        let along = Vector3::from(raw.along).normalize();
        let push = Vector3::from(raw.push);
        let (width, height) = (raw.width * length, raw.height * length);
        Self {
            clamp: Vector3::from(raw.clamp) * length,
            along,
            push: (push - along * along.dot(&push)).normalize(),
            length: raw.length * length,
            rigidity: raw.young * units.pressure.factor() * width * height.powi(3) / 12.0,
            offset: 0.5 * height,
            theory: raw.theory,
            friction: raw.friction,
            plastic: raw.yields.map(|yields| {
                let (strain, hardening) = (yields / raw.young, raw.hardening.unwrap_or_default() / raw.young);
                Plastic::new(strain, hardening, raw.length * length, height)
            }),
        }
    }

    /// Force on the tool at a point, and its derivative; none where the tool does not reach the surface.
    ///
    /// # Errors
    /// [`ProcessError`].
    pub fn push(&self, at: &Vector3<f64>, travel: &Vector3<f64>) -> Result<Push, ProcessError> {
        let Some(Contact { force, gradient, .. }) = self.contact(at, travel)? else {
            return Ok(Push { force: Vector3::zeros(), gradient: Matrix3::zeros() });
        };
        // What the strip does to the tool is the opposite of what the tool does to it.
        let axes = nalgebra::Matrix3x2::from_columns(&[self.along, self.push]);
        Ok(Push { force: -(axes * force), gradient: -(axes * gradient * axes.transpose()) })
    }

    /// The strip after the tool was at a point, and how far its free end was bent; none where the tool does not reach it, or
    /// the strip cannot yield.
    ///
    /// # Errors
    /// [`ProcessError`].
    pub fn after(&self, at: &Vector3<f64>, travel: &Vector3<f64>) -> Result<Option<(Self, Bent)>, ProcessError> {
        let (Some(plastic), Some(contact)) = (&self.plastic, self.contact(at, travel)?) else { return Ok(None) };
        let Contact { n, f, length, .. } = contact;
        let plastic = plastic.after(n, f, self.offset, length);
        let bent = plastic.bent(n, f, self.offset, length);
        Ok(Some((Self { plastic: Some(plastic), ..self.clone() }, bent)))
    }

    fn contact(&self, at: &Vector3<f64>, travel: &Vector3<f64>) -> Result<Option<Contact>, ProcessError> {
        let from = at - self.clamp;
        let (a, depth) = (from.dot(&self.along), from.dot(&self.push));
        if depth <= 0.0 {
            return Ok(None);
        }
        // Where it has yielded before, its surface lies deeper.
        let unloaded = match &self.plastic {
            Some(plastic) => match plastic.depth(a, self.offset) {
                Some(unloaded) if depth <= unloaded => return Ok(None),
                Some(unloaded) => unloaded,
                None => return Err(ProcessError::Off { reach: a * 1e3, length: self.length * 1e3 }),
            },
            None => 0.0,
        };
        if a <= 2.0 * self.offset {
            return Err(ProcessError::Clamp { along: a * 1e3 });
        }
        let way = travel.dot(&self.along);
        // What pushes sideways or along the push alone does not drag.
        let slides = way.abs() > 1e-9 * travel.norm().max(f64::MIN_POSITIVE);
        let f = if slides { self.friction * way.signum() } else { 0.0 };
        match self.theory {
            Theory::EulerBernoulli => self.straight(a, depth, f).map(Some),
            Theory::Large => self.bent(a, [unloaded, depth], f).map(Some),
        }
    }

    fn straight(&self, a: f64, depth: f64, f: f64) -> Result<Contact, ProcessError> {
        if a > self.length {
            return Err(ProcessError::Off { reach: a * 1e3, length: self.length * 1e3 });
        }
        let rate = 3.0 * self.rigidity / a.powi(3);
        let force = Vector2::new(f, 1.0) * (rate * depth);
        let by = Vector2::new(-3.0 * rate * depth / a, rate);
        let gradient = Vector2::new(f, 1.0) * by.transpose();
        Ok(Contact { n: rate * depth / self.rigidity, f, length: a, force, gradient })
    }

    /// From the depth of the unloaded surface to that of the tool.
    fn bent(&self, a: f64, [unloaded, depth]: [f64; 2], f: f64) -> Result<Contact, ProcessError> {
        let failed = || match &self.plastic {
            Some(plastic) if plastic.hardening == 0.0 => ProcessError::Hinge { along: a * 1e3, depth: depth * 1e3 },
            _ => ProcessError::Shape { along: a * 1e3, depth: depth * 1e3 },
        };
        // A section holds no more than half as much again as that at which it yields.
        let most = self.plastic.as_ref().map_or(f64::INFINITY, |plastic| 1.2 * plastic.yields / a);
        let start = |depth: f64| {
            let n = (3.0 * (depth - unloaded) / a.powi(3)).min(most);
            Vector2::new(n, a + 0.6 * depth * depth / a)
        };
        let found = self.shape(a, depth, f, start(depth)).or_else(|| {
            let first = (depth - unloaded) / 16.0;
            let at = |part: i32| unloaded + first * f64::from(part);
            (1..=16).try_fold(start(at(1)), |from, part| self.shape(a, at(part), f, from))
        });
        let found = found.ok_or_else(failed)?;
        let (n, length) = (found.x, found.y);
        if length > self.length {
            return Err(ProcessError::Off { reach: length * 1e3, length: self.length * 1e3 });
        }
        let (_, by, slope, by_slope) = self.surface(n, f, length);
        let (sine, cosine) = slope.sin_cos();
        // Across and along the strip where it is touched.
        let unit = Vector2::new(-sine + f * cosine, cosine + f * sine);
        let turned = Vector2::new(-cosine - f * sine, -sine + f * cosine);
        let by_unknowns = Matrix2::from_columns(&[unit + turned * (n * by_slope.x), turned * (n * by_slope.y)]);
        let inverse = by.try_inverse().ok_or_else(failed)?;
        let (force, gradient) = (unit * (n * self.rigidity), by_unknowns * inverse * self.rigidity);
        Ok(Contact { n, f, length, force, gradient })
    }

    fn tip(&self, n: f64, f: f64, length: f64) -> Tip {
        match &self.plastic {
            None => bend(n, f, self.offset, length),
            Some(plastic) => plastic.tip(n, f, self.offset, length),
        }
    }

    /// The touched point of the surface (along, push), its derivatives by n and by the length, the slope there and its
    /// derivatives.
    fn surface(&self, n: f64, f: f64, length: f64) -> (Vector2<f64>, Matrix2<f64>, f64, Vector2<f64>) {
        let tip = self.tip(n, f, length);
        let (sine, cosine) = tip.slope.sin_cos();
        let c = self.offset;
        // The centre line turned to the clamp's axes, then out to the surface.
        let turn = Matrix2::new(cosine, -sine, sine, cosine);
        let line = turn * Vector2::from(tip.at);
        let at = line + Vector2::new(c * sine, c - c * cosine);
        let by = |d: &[f64; 3]| {
            turn * Vector2::new(d[1], d[2]) + Vector2::new(-line.y + c * cosine, line.x + c * sine) * d[0]
        };
        let slopes = Vector2::new(tip.by_n[0], tip.by_length[0]);
        (at, Matrix2::from_columns(&[by(&tip.by_n), by(&tip.by_length)]), tip.slope, slopes)
    }

    /// Force over rigidity and length between clamp and tool, such that the surface passes through (a, depth).
    fn shape(&self, a: f64, depth: f64, f: f64, from: Vector2<f64>) -> Option<Vector2<f64>> {
        let wanted = Vector2::new(a, depth);
        let mut unknowns = from;
        let (mut at, mut by, ..) = self.surface(unknowns.x, f, unknowns.y);
        for _ in 0..MOST {
            let gap = wanted - at;
            if gap.norm() < 1e-13 {
                return Some(unknowns);
            }
            let step = by.try_inverse()? * gap;
            let mut share = 1.0;
            loop {
                let trial = unknowns + step * share;
                let found = self.surface(trial.x, f, trial.y);
                if trial.y > 0.0 && (wanted - found.0).norm() < gap.norm() {
                    (unknowns, at, by) = (trial, found.0, found.1);
                    break;
                }
                share *= 0.5;
                if share < 1e-3 {
                    // At the limit of what numbers resolve nothing gets better any more.
                    return (gap.norm() < 1e-11).then_some(unknowns);
                }
            }
        }
        None
    }
}
