//! Where a process deflects the arm least: the workpiece shifted and turned, and the posture chosen where the arm is redundant
//! or has several branches.

mod arm;
mod follow;
mod pattern;
mod search;

use nalgebra::{Point3, Rotation3, Translation3, Vector3};

pub use arm::Posture;
pub use search::{as_given, place};

use crate::kinematics::{AssemblyError, Hold, InverseError, Transform};
use crate::prediction::SingleError;
use crate::settings::settings;

/// A path to place, SI.
#[derive(Debug, Clone)]
pub struct Work {
    /// Where the tool centre point should be, base frame, as given.
    pub targets: Vec<Transform>,
    /// Wrench on the tool at each point, base axes: it turns with the workpiece.
    pub wrenches: Vec<[f64; 6]>,
    /// Wrench at all points that stays as it is however the workpiece is turned.
    pub carried: [f64; 6],
    /// A posture from which the first point is sought too.
    pub from: Option<Vec<f64>>,
}

/// How good a place is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Least {
    /// Root mean square of the deflections along the path.
    Rms,
    /// The greatest of them.
    Max,
}

/// What is sought.
#[derive(Debug, Clone)]
pub struct Wanted {
    /// What is held of the targets.
    pub hold: Hold,
    /// Least and greatest shift along x, y, z (m) and turn about rx, ry, rz (rad, a rotation vector) of the workpiece, base axes,
    /// about the middle of its points; the placement given, all zero, is among them.
    pub within: [[f64; 2]; 6],
    /// Directions of the deflection that count, along x, y, z of the base frame as the workpiece is given: they turn with it.
    pub directions: [bool; 3],
    /// Whether the deflection by own weight and preloads counts too.
    pub weight: bool,
    /// Mean or greatest.
    pub least: Least,
    /// Greatest condition number (m and rad on levers of 1 m).
    pub worst_condition: f64,
    /// Seed of the starts.
    pub seed: u64,
    /// How it is sought.
    pub search: Search,
}

settings! {
    /// How it is sought: more starts, samples and points find less deflection where there are many optima, in proportion of time.
    #[derive(Debug, Clone, PartialEq)]
    pub struct Search {
        /// Placements drawn to start from, for each direction in which the workpiece may move.
        pub starts: usize = 12,
        /// The best of them that are moved on.
        pub kept: usize = 3,
        /// Starts of the inverse model without a new branch, after which it ends, for the first point at a placement.
        pub restarts: usize = 48,
        /// Postures from which a redundant arm starts at the first point, at the placement given and at those drawn.
        pub samples: [usize; 2] = [16, 4],
        /// Points of the path that are tried, the others being met at the end: the deflection changes slowly along it.
        pub points: usize = 16,
        /// Moves of a redundant arm along its self-motions, rad (of lengths in parts of half their range), coarse ones first: where the
        /// posture of the first point is sought, where the next points follow it (small ones, so that postures do not leap), and while
        /// the workpiece moves.
        pub self_motions: [&'static [f64]; 3] =
            [&[0.3, 0.1, 0.03, 0.01, 3e-3, 1e-3, 3e-4], &[0.03, 0.01, 3e-3, 1e-3, 3e-4], &[0.03, 0.01]],
        /// Steps of the placement, first and last, as parts of its box.
        pub steps: [f64; 2] = [0.25, 2e-4],
        /// Directions drawn in addition to the axes.
        pub directions: usize = 4,
        /// Least gain, as a part, that is worth a move.
        pub worth: f64 = 1e-7,
    }
}

/// A rigid motion of the workpiece.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Moved {
    /// Shift along x, y, z of the base, m, and rotation vector, rad.
    pub by: [f64; 6],
    /// The point about which it turns: the middle of the path, m.
    pub about: Point3<f64>,
}

impl Moved {
    /// As one motion of the base frame's space.
    pub fn motion(&self) -> Transform {
        let [x, y, z, rx, ry, rz] = self.by;
        let turn = Rotation3::new(Vector3::new(rx, ry, rz));
        let shift = self.about.coords + Vector3::new(x, y, z) - turn * self.about.coords;
        Transform::from_parts(Translation3::from(shift), turn)
    }
}

/// A way through the path.
#[derive(Debug, Clone)]
pub struct Way {
    /// Where the workpiece is.
    pub moved: Moved,
    /// Postures by point.
    pub postures: Vec<Posture>,
}

impl Way {
    /// Root mean square and greatest deflection in the directions that count, m.
    pub fn deflection(&self) -> [f64; 2] {
        [Least::Rms, Least::Max].map(|least| least.of(self.postures.iter().map(|posture| posture.counted)))
    }
}

impl Least {
    fn of(self, all: impl Iterator<Item = f64>) -> f64 {
        let (count, sum, most) = all.fold((0.0, 0.0, 0.0_f64), |(n, sum, most), d| (n + 1.0, sum + d * d, most.max(d)));
        match self {
            Self::Rms => (sum / f64::max(count, 1.0)).sqrt(),
            Self::Max => most,
        }
    }
}

/// What is found.
#[derive(Debug, Clone)]
pub struct Placed {
    /// With the workpiece as given: the best posture.
    pub given: Option<Way>,
    /// The best place and posture.
    pub best: Way,
    /// Ways through the path that were tried.
    pub tried: usize,
}

/// Why nothing is found.
#[derive(Debug, thiserror::Error)]
pub enum StiffestError {
    /// The robot cannot be put together.
    #[error(transparent)]
    Assembly(#[from] AssemblyError),
    /// No way through the path at any placement tried.
    #[error("none of {tried} placements tried can be taken; as given, point {} of the path is the first that cannot: {why}", .point + 1)]
    Nowhere {
        /// Placements tried.
        tried: usize,
        /// The first point of the path that cannot be taken, where the workpiece is as given, from 0.
        point: usize,
        /// Why.
        why: Stop,
    },
}

/// Why a point cannot be taken.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Stop {
    /// Out of reach, or within a limit.
    #[error(transparent)]
    Reach(#[from] InverseError),
    /// Not to be loaded there.
    #[error(transparent)]
    Load(#[from] SingleError),
    /// A direction is nearly lost.
    #[error("the condition number is {condition:.0}")]
    Condition {
        /// Greatest over least singular value, m and rad on levers of 1 m.
        condition: f64,
    },
}
