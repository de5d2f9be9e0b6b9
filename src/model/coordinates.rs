//! Coordinates: the actuated variables, and after them the joints that follow these in proportion.
//!
//! A joint of a wrist that is coupled to another one has gears, play and friction of its own: effects sit at it as at a driven joint,
//! follow its own value and move it alone.

use super::{Driver, Frame, Model};
use crate::description::robot::{FrameIndex, Motion};

/// A joint that follows variables in proportion.
#[derive(Debug, Clone, PartialEq)]
pub struct Follower {
    /// Its frame.
    pub joint: FrameIndex,
    /// `joint<name>`, as parameters of the joint begin.
    pub name: String,
    /// Its value: factors of variables, by index.
    terms: Vec<(f64, usize)>,
    /// Whether the controller couples it: errors of what it follows do not pass on to it.
    is_of_controller: bool,
}

impl Follower {
    /// By how much a variable moves it that moves it when commanded, but not by an error.
    pub fn only_commanded(&self) -> impl Iterator<Item = (f64, usize)> {
        self.terms.iter().copied().filter(|_| self.is_of_controller)
    }

    /// What it is where the variables are these: a value, a move or a side of approach; NaN where one of them is.
    pub fn of(&self, variables: &[f64]) -> f64 {
        let term = |&(factor, variable): &(f64, usize)| factor * variables.get(variable).copied().unwrap_or(f64::NAN);
        self.terms.iter().map(term).sum()
    }
}

impl Model {
    /// Joints that follow variables in proportion, in the order of their frames. What follows a joint that an actuator or a loop turns
    /// is none of them.
    pub fn followers(&self) -> Vec<Follower> {
        let follower = |joint: FrameIndex| {
            let Motion::Coupling(which) = self.frames[joint].motion else { return None };
            let terms = self.in_proportion(joint)?;
            let is_of_controller = self.coupled_by_controller[which];
            Some(Follower { joint, name: format!("joint{}", self.frames[joint].name), terms, is_of_controller })
        };
        (0..self.frames.len()).filter_map(follower).collect()
    }

    /// Number of the coordinates: of the variables and their followers.
    pub fn coordinates(&self) -> usize {
        self.variables.len() + self.followers().len()
    }

    /// Names of the coordinates: those of the variables, and `joint<name>` of the followers.
    pub fn coordinate_names(&self) -> Vec<String> {
        let variables = self.variables.iter().map(|variable| variable.name.clone());
        variables.chain(self.followers().into_iter().map(|follower| follower.name)).collect()
    }

    /// Unit of what a curve follows on this robot, SI: of a sliding joint m and N.
    pub fn unit_of(&self, driver: Driver) -> &'static str {
        let slides = |own: usize| self.variables.get(own).is_some_and(|variable| !variable.is_angle);
        match driver {
            Driver::Angle(own) | Driver::LastMove(own) if slides(own) => "m",
            Driver::OwnLoad(own) | Driver::Load(own) if slides(own) => "N",
            _ => driver.unit(),
        }
    }

    /// The coordinate of a joint: the variable that drives it, itself or through an actuator, or its own as a follower.
    pub fn coordinate_of(&self, joint: FrameIndex) -> Option<usize> {
        match self.frames[joint].motion {
            Motion::Variable { index, .. } => Some(index),
            Motion::Actuator(_) => self.actuators.iter().find(|actuator| actuator.joint == joint).map(|of| of.variable),
            Motion::Coupling(_) => {
                let at = self.followers().iter().position(|follower| follower.joint == joint)?;
                Some(self.variables.len() + at)
            }
            Motion::Fixed | Motion::Passive => None,
        }
    }

    /// The joint that a variable drives, itself or through an actuator.
    pub fn joint_of(&self, variable: usize) -> Option<FrameIndex> {
        let own = |frame: &Frame| matches!(frame.motion, Motion::Variable { index, .. } if index == variable);
        let driven = || self.actuators.iter().find(|actuator| actuator.variable == variable).map(|of| of.joint);
        self.frames.iter().position(own).or_else(driven)
    }

    /// The variable that alone drives a joint.
    pub fn only_driver(&self, joint: FrameIndex) -> Option<usize> {
        match self.in_proportion(joint)?[..] {
            [(_, variable)] => Some(variable),
            _ => None,
        }
    }

    /// The value of a joint as a sum of variables, but for its zero.
    fn in_proportion(&self, joint: FrameIndex) -> Option<Vec<(f64, usize)>> {
        match self.frames[joint].motion {
            Motion::Variable { index, direction } => Some(vec![(direction, index)]),
            Motion::Coupling(which) => {
                let mut sum: Vec<(f64, usize)> = Vec::new();
                for (factor, other) in &self.couplings[which] {
                    let scaled = |(own, variable): (f64, usize)| (factor * own, variable);
                    sum.extend(self.in_proportion(*other)?.into_iter().map(scaled));
                }
                Some(sum)
            }
            Motion::Actuator(_) | Motion::Fixed | Motion::Passive => None,
        }
    }
}
