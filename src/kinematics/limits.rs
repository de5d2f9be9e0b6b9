//! Limits of joints that no variable moves directly, and of sums of joints, at a placed configuration.

use super::geometry::Placements;
use crate::description::fuzzy::Input;
use crate::description::raw::JointKind;
use crate::description::robot::{FrameIndex, Motion, Variable};
use crate::model::Model;

/// Beyond a limit by less than this (rad or m) is at it.
const ROUNDED: f64 = 1e-9;

/// A joint, or a sum of joints, and its limits.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limited<'m> {
    /// Name of the joint's frame, or the sum as written.
    pub name: &'m str,
    /// Value, rad or m; of what a loop moves, by the turn nearest to the middle of the limits.
    pub value: f64,
    /// Least and greatest value, rad or m.
    pub limits: [f64; 2],
    /// An angle, or a length.
    pub is_angle: bool,
}

impl Limited<'_> {
    /// Whether the limits are kept.
    pub fn is_within(&self) -> bool {
        let [low, high] = self.limits;
        (low - ROUNDED..=high + ROUNDED).contains(&self.value)
    }

    /// As a variable of this name.
    pub fn variable(&self) -> Variable {
        Variable { name: self.name.to_owned(), is_angle: self.is_angle, limits: Some(self.limits), gear_ratio: None }
    }
}

/// Joints without a variable of their own that have limits, then sums of joints, at the placed configuration `q` (rad and m).
pub fn limited<'p>(
    model: &'p Model,
    q: &'p [f64],
    placements: &'p Placements,
) -> impl Iterator<Item = Limited<'p>> + 'p {
    let joints = model.frames.iter().zip(&placements.joints).filter_map(|(frame, &joint)| {
        let limits = frame.limits.filter(|_| !matches!(frame.motion, Motion::Variable { .. } | Motion::Fixed))?;
        let turns = frame.motion == Motion::Passive && frame.joint == JointKind::Revolute;
        let value = if turns { nearest_turn(joint, limits) } else { joint };
        Some(Limited { name: &frame.name, value, limits, is_angle: frame.joint == JointKind::Revolute })
    });
    let sums = model.limits.iter().map(|sum| {
        let term = |(factor, of): &(f64, Input)| {
            let value = match *of {
                Input::Variable(variable) => q.get(variable),
                Input::Joint(joint) => placements.joints.get(joint),
            };
            factor * value.copied().unwrap_or(f64::NAN)
        };
        let value: f64 = sum.terms.iter().map(term).sum();
        // A joint that a loop moves is known up to whole turns.
        let mut passive = sum.terms.iter().filter(|(_, of)| matches!(of, Input::Joint(j) if is_passive(model, *j)));
        let turns =
            sum.is_angle && passive.clone().next().is_some() && passive.all(|(factor, _)| factor.fract() == 0.0);
        let value = if turns { nearest_turn(value, sum.limits) } else { value };
        Limited { name: &sum.name, value, limits: sum.limits, is_angle: sum.is_angle }
    });
    joints.chain(sums)
}

/// Those of [`limited`] that are beyond their limits.
pub fn beyond_limits<'p>(
    model: &'p Model,
    q: &'p [f64],
    placements: &'p Placements,
) -> impl Iterator<Item = Limited<'p>> + 'p {
    limited(model, q, placements).filter(|limited| !limited.is_within())
}

fn is_passive(model: &Model, joint: FrameIndex) -> bool {
    model.frames[joint].motion == Motion::Passive
}

/// An angle by the turn nearest to the middle of its limits.
fn nearest_turn(value: f64, [low, high]: [f64; 2]) -> f64 {
    let (middle, turn) = (0.5 * (low + high), std::f64::consts::TAU);
    if middle.is_finite() { value - turn * ((value - middle) / turn).round() } else { value }
}
