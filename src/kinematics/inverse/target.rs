//! What is asked of the inverse model and what it answers; m and rad, in the robot's base frame.

use nalgebra::{Point3, Rotation3, Vector6};

use super::super::assembly_error::AssemblyError;
use crate::settings::settings;

/// Where the tool centre point should be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Target {
    /// Position in the robot's base frame, m.
    pub position: Point3<f64>,
    /// Axes of the tool in the robot's base frame; free where absent.
    pub rotation: Option<Rotation3<f64>>,
    /// Which of its directions count.
    pub hold: Hold,
}

/// Which directions of a target are held: along x, y, z of the base frame, and about x, y, z of the target's own axes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Hold(pub [bool; 6]);

impl Hold {
    /// Position and orientation.
    pub const POSE: Self = Self([true; 6]);
    /// Position and the direction of the tool's z axis: a spindle may turn about it.
    pub const AXIS: Self = Self([true, true, true, true, true, false]);
    /// Position alone.
    pub const POSITION: Self = Self([true, true, true, false, false, false]);
    /// Names of the directions.
    pub const NAMES: [&str; 6] = ["x", "y", "z", "rx", "ry", "rz"];

    /// What a robot of so many variables can hold wherever its axes point.
    pub fn of(variables: usize) -> Self {
        match variables {
            6.. => Self::POSE,
            5 => Self::AXIS,
            _ => Self::POSITION,
        }
    }

    /// Number of directions held.
    pub fn count(self) -> usize {
        self.0.iter().filter(|held| **held).count()
    }

    /// Whether a rotation is held.
    pub fn turns(self) -> bool {
        self.0[3..].contains(&true)
    }

    /// Indices of the directions that are let go.
    pub fn let_go(self) -> impl Iterator<Item = usize> {
        (0..6).filter(move |&k| !self.0[k])
    }

    /// A motion without the directions let go; its rotation is in the target's axes.
    pub fn of_motion(self, mut motion: Vector6<f64>) -> Vector6<f64> {
        self.let_go().for_each(|k| motion[k] = 0.0);
        motion
    }
}

settings! {
    /// How to search.
    #[derive(Debug, Clone, PartialEq)]
    pub struct InverseSettings {
        /// Starts without a new branch after which the search ends. With 0 the only start is `from`, or the middle of the
        /// limits.
        pub restarts: usize = 192,
        /// Seed of the starts. The result depends on it and on nothing else: not on the number of threads.
        pub seed: u64 = 1,
        /// A configuration (rad and m): only the solution nearest to it is reported.
        pub from: Option<Vec<f64>> = None,
        /// Errors up to which the target counts as met, m and rad. What is found commonly meets it to 1e-12.
        pub tolerance: f64 = 1e-9,
        /// How many solutions are reported of a target that leaves motions free.
        pub samples: usize = 8,
    }
}

/// A configuration that meets the target.
#[derive(Debug, Clone, PartialEq)]
pub struct Solution {
    /// Variables, rad and m, in the model's order, within their limits; angles by the turn nearest `from`, or nearest 0.
    pub joints: Vec<f64>,
    /// Distance from the target, m.
    pub position_error: f64,
    /// Angle from the target's axes, rad; 0 where they are free.
    pub orientation_error: f64,
    /// Number of independent motions of the variables that keep the target met, to first order. 0: an isolated branch.
    /// Otherwise the robot is redundant for this target (or the configuration singular), solutions form a continuum,
    /// and those reported are samples of it.
    pub self_motions: usize,
}

/// Why there is no solution.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum InverseError {
    /// The target or the tolerance is not finite, or `from` does not suit the model.
    #[error("{0}")]
    Input(String),
    /// No start could be put together.
    #[error("the mechanism cannot be put together at any start: {0}")]
    Assembly(AssemblyError),
    /// No configuration found meets the target.
    #[error("the target is out of reach{}: the closest approach stays {:.4} mm and {:.4} deg away", by_limits(.limits), 1e3 * .position_error, .orientation_error.to_degrees())]
    OutOfReach {
        /// Distance that stays at the closest approach found, m.
        position_error: f64,
        /// Angle that stays there, rad.
        orientation_error: f64,
        /// Variables of the closest approach, rad and m.
        joints: Vec<f64>,
        /// What stops it, if without limits it could be reached: the variables (or joints) whose limits a configuration
        /// that meets the target breaks.
        limits: Vec<String>,
    },
}

fn by_limits(limits: &[String]) -> String {
    if limits.is_empty() { String::new() } else { format!(" within the limits of {}", limits.join(", ")) }
}
