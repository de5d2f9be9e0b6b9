//! Straight beam in space, Euler-Bernoulli or Timoshenko, and links of unknown section.
//!
//! Local x runs from its first node to its second, z is the stated normal made orthogonal to it, y = z x x; Iz resists
//! bending in the x-y plane. Flexibility: [`PerLength`].

use nalgebra::{Matrix3, Vector3};
use num_dual::{Dual64, DualNum};

use super::element::{
    Configuration, Direction, ElasticElement, Frames, MotionRate, ParameterUse, Placed, Rate, VertexIndex, VertexMotion,
};
use super::flexibility::Flexibility;
use super::per_length::PerLength;
use super::section::{Properties, properties};
use crate::description::raw::SectionShape;
use crate::description::robot::FrameIndex;
use crate::parameter::Slot;

/// A beam from an edge's first vertex to its second.
#[derive(Debug, Clone, PartialEq)]
pub struct Beam {
    /// The local z.
    pub normal: Normal,
    /// What resists.
    pub rigidity: Rigidity,
}

/// An axis of a frame, to which the local z of a beam lies nearest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Normal {
    /// The frame.
    pub frame: FrameIndex,
    /// Which axis of it: z (2), or x (0) where z lies along the beam.
    pub axis: usize,
}

impl Normal {
    /// Its direction, base axes.
    pub fn direction(&self, frames: &Frames) -> Vector3<f64> {
        frames[self.frame].rotation.matrix().column(self.axis).into_owned()
    }
}

/// Rigidity of a beam.
#[derive(Debug, Clone, PartialEq)]
pub enum Rigidity {
    /// By sections and a material.
    Section {
        /// Sections of the whole beam's two ends; `None` where the second is as the first.
        sections: (Section, Option<Section>),
        /// Where the middle of this element lies on the beam (0 to 1).
        middle: f64,
        /// Material.
        material: Material,
        /// With shear areas.
        shear: bool,
    },
    /// By the slots of 1/(E Iy), 1/(E Iz), 1/(G J): a link whose elasticity nobody declared.
    Inverse([Slot; 3]),
}

/// Slots of a material.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Material {
    /// Young's modulus.
    pub young: Slot,
    /// Shear modulus, or Poisson's ratio.
    pub shear: Slot,
    /// Which of them.
    pub is_poisson: bool,
    /// Density.
    pub density: Slot,
}

/// Slots of a section.
#[derive(Debug, Clone, PartialEq)]
pub struct Section {
    /// Its shape.
    pub shape: Option<SectionShape>,
    /// Symbol and slot of each number.
    pub slots: Vec<(&'static str, Slot)>,
}

impl Section {
    fn value<D>(&self, symbol: &str, value: &impl Fn(Slot) -> D) -> Option<D> {
        self.slots.iter().find(|(known, _)| *known == symbol).map(|&(_, slot)| value(slot))
    }
}

impl Rigidity {
    /// Inverse rigidities and mass per length, for numbers of any kind.
    fn per_length<D: DualNum<Primitive = f64> + Copy>(&self, value: &impl Fn(Slot) -> D) -> ([D; 6], D) {
        let zero = D::from(0.0);
        match self {
            Self::Inverse([y, z, t]) => ([zero, zero, zero, value(*y), value(*z), value(*t)], zero),
            Self::Section { sections: (first, last), middle, material, shear } => {
                let symbol = |symbol: &str| {
                    let own = first.value(symbol, value)?;
                    Some(match last {
                        None => own,
                        Some(last) => own * (1.0 - middle) + last.value(symbol, value).unwrap_or(own) * *middle,
                    })
                };
                let section = properties(first.shape, symbol);
                let young = value(material.young);
                let modulus = value(material.shear);
                let g = if material.is_poisson { young / ((modulus + 1.0) * 2.0) } else { modulus };
                (inverse(&section, young, g, *shear), value(material.density) * section.area)
            }
        }
    }

    fn slots(&self) -> Vec<Slot> {
        match self {
            Self::Inverse(slots) => slots.to_vec(),
            Self::Section { sections: (first, last), material, .. } => {
                let mut slots = vec![material.young, material.shear, material.density];
                let sections = std::iter::once(first).chain(last);
                slots.extend(sections.flat_map(|section| section.slots.iter().map(|(_, slot)| *slot)));
                slots
            }
        }
    }
}

/// 1/(E A), 1/(G Asy), 1/(G Asz), 1/(E Iy), 1/(E Iz), 1/(G J) of a section in a material (moduli in Pa). Shear is left out
/// of Euler-Bernoulli beams.
fn inverse<D: DualNum<Primitive = f64> + Copy>(section: &Properties<D>, young: D, g: D, timoshenko: bool) -> [D; 6] {
    let by_shear = |area: D| if timoshenko { (g * area).recip() } else { D::from(0.0) };
    [
        (young * section.area).recip(),
        by_shear(section.shear_y),
        by_shear(section.shear_z),
        (young * section.iy).recip(),
        (young * section.iz).recip(),
        (g * section.j).recip(),
    ]
}

impl PerLength {
    /// Of a section in a material (moduli in Pa), without mass.
    pub fn of_section(section: &Properties<f64>, young: f64, shear: f64, timoshenko: bool) -> Self {
        Self { compliance: inverse(section, young, shear, timoshenko), mass: 0.0 }
    }
}

impl ElasticElement for Beam {
    fn directions(&self) -> [Direction; 6] {
        [Direction::Flexible; 6]
    }

    fn parameters(&self) -> Vec<ParameterUse> {
        let mut slots = self.rigidity.slots();
        slots.sort_unstable();
        slots.dedup();
        slots.into_iter().map(|slot| ParameterUse { slot, part: 0 }).collect()
    }

    fn is_active(&self, values: &[f64]) -> bool {
        self.per_length(values).is_some_and(|found| found.compliance.iter().any(|r| *r != 0.0))
    }

    fn per_length(&self, values: &[f64]) -> Option<PerLength> {
        let (compliance, mass) = self.rigidity.per_length(&|slot| values[slot]);
        Some(PerLength { compliance, mass })
    }

    fn per_length_by(&self, by: Slot, values: &[f64]) -> Option<PerLength> {
        let (compliance, mass) = self.rigidity.per_length(&|slot| {
            let at = Dual64::from(values[slot]);
            if slot == by { at.derivative() } else { at }
        });
        Some(PerLength { compliance: compliance.map(|r| r.eps), mass: mass.eps })
    }

    fn place(&self, at: &Configuration, ends: [VertexIndex; 2], per_length: &PerLength) -> Placed {
        let [a, b] = ends.map(|end| at.points[end]);
        let normal = at.turned(ends[0]) * self.normal.direction(at.frames);
        let (rotation, length) = axes(&a, &b, &normal);
        Placed { length, ..Placed::new(&rotation, &b, per_length.flexibility(length)) }
    }

    fn by_parameter(&self, _: usize, _: &Configuration) -> Rate {
        Rate::Flexibility(Flexibility::Rigid)
    }

    fn by_motion(&self, at: &Configuration, ends: [VertexIndex; 2], moves: &VertexMotion) -> MotionRate {
        let points = ends.map(|end| at.points[end]);
        let (turn, stretch) = turn(points, ends.map(|end| moves.vertices[end]), &self.normal, moves);
        MotionRate { stretch, ..MotionRate::of(&points[1], moves.vertices[ends[1]], turn) }
    }
}

/// Local axes (columns) of a beam from one point to another, and its length. Where the normal is along the beam, as it
/// should not be, any other serves.
///
/// ```
/// use elastogeo::elements::beam_axes;
/// use nalgebra::Vector3;
///
/// let (axes, length) = beam_axes(&Vector3::zeros(), &Vector3::new(0.0, 2.0, 0.0), &Vector3::z());
/// assert_eq!(length, 2.0);
/// assert!((axes.column(0) - Vector3::y()).norm() < 1e-15); // its own x runs along it
/// ```
pub fn axes(from: &Vector3<f64>, to: &Vector3<f64>, normal: &Vector3<f64>) -> (Matrix3<f64>, f64) {
    let along = to - from;
    let length = along.norm();
    let x = along / length.max(f64::MIN_POSITIVE);
    let mut z = normal - x * x.dot(normal);
    if z.norm() < 1e-6 {
        let other = if x.x.abs() < 0.9 { Vector3::x() } else { Vector3::y() };
        z = other - x * x.dot(&other);
    }
    z /= z.norm().max(f64::MIN_POSITIVE);
    (Matrix3::from_columns(&[x, z.cross(&x), z]), length)
}

/// How a beam's own axes turn (rad) when its ends are displaced (m), and how far it stretches (m).
pub(super) fn turn(
    [a, b]: [Vector3<f64>; 2],
    [da, db]: [Vector3<f64>; 2],
    normal: &Normal,
    moves: &VertexMotion,
) -> (Vector3<f64>, f64) {
    let length = (b - a).norm().max(f64::MIN_POSITIVE);
    let x = (b - a) / length;
    let across = x.cross(&(db - da)) / length;
    // About its own axis the beam turns so that its z stays in the plane of x and the normal.
    let turn = moves.point(normal.frame, &b).1;
    let normal = normal.direction(moves.frames);
    let moved = turn.cross(&normal) - across.cross(&normal);
    let z = normal - x * x.dot(&normal);
    let about = if z.norm() > 1e-6 { z.cross(&moved).dot(&x) / z.norm_squared() } else { turn.dot(&x) };
    (across + x * about, x.dot(&(db - da)))
}
