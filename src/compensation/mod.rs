//! Compensation: the commands under which the real robot passes where it should.
//!
//! The inverse of the calibrated elasto-geometric model: the point that is predicted with geometry errors, own weight,
//! applied wrench and effects ([`crate::prediction::SinglePredictor`]) is brought to its target by Newton's steps on
//! analytic derivatives, and the residual reported is the prediction's at the commands found. A process that pushes
//! back as the tool moves is brought to equilibrium with the arm ([`settle`]).

mod correct;
mod coupling;
mod deflected;
mod desired;
mod path;
mod pushed;
mod straight;

pub use correct::{Corrected, correct};
pub use coupling::{Balance, Start, settle};
pub use deflected::deflected;
pub use desired::{Asked, Controller, desire, six};
pub use path::{Outcome, Point, Sides, compensate, predict_path, side_after};
pub use pushed::pushed;
pub use straight::astray;

use nalgebra::Vector3;

pub use crate::kinematics::Hold;
use crate::kinematics::{AssemblyError, InverseError, Transform};
use crate::prediction::SingleError;
use crate::process::ProcessError;
use crate::settings::settings;

/// How compensation proceeds.
///
/// The first three are the user's question. The others are limits of the search, which the bundled robots do not come near.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// What of the target is held.
    pub hold: Hold,
    /// Residual up to which a point counts as met: m, and rad on a lever of 1 m.
    pub residual: f64,
    /// Greatest correction of an angle, rad; of a length, this share of half its limits (of 1 m without).
    pub largest: f64,
    /// Greatest condition number (m and rad on levers of 1 m) of a point that is not singular. At 1000 an error of the model
    /// of 0.01 mm moves a joint by half a degree.
    pub worst_condition: f64,
    /// After a step that leaves more than this share of the error, derivatives are computed anew, with those of the
    /// deflection. Until then the rigid robot's suffice: their error is about the deflection over the reach, a thousandth.
    pub slow: f64,
    /// Most steps for a point; one that needs more is refused. Met points take three to six.
    pub max_steps: usize,
    /// Most passes over the path: each derives the sides of approach from the commands of the one before. The second changes
    /// nothing unless a correction is as great as the way between two points.
    pub max_passes: usize,
    /// A variable that moves by less (rad or m) keeps its side of approach: below the resolution of encoders.
    pub standing: f64,
    /// The search for the balance of arm and process.
    pub balance: BalanceSettings,
    /// How points deflect.
    pub deflection: Deflects,
}

/// How points deflect.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Deflects {
    /// Linearly, at the commanded pose.
    Linear,
    /// The same, and how far that is off the equilibrium at the deflected pose is found for each point.
    Compared,
    /// To the equilibrium at the deflected pose.
    Equilibrium,
}

impl Settings {
    /// For a robot of so many variables: what it can hold, to 0.1 um, by corrections up to 5 deg.
    pub fn new(variables: usize) -> Self {
        Self {
            hold: Hold::of(variables),
            residual: 1e-7,
            largest: 5.0_f64.to_radians(),
            worst_condition: 1e3,
            slow: 0.05,
            max_steps: 40,
            max_passes: 5,
            standing: 1e-6,
            balance: BalanceSettings::default(),
            deflection: Deflects::Linear,
        }
    }
}

settings! {
    /// The search for the balance of arm and process ([`settle`]).
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct BalanceSettings {
        /// Most of Newton's steps; without a kink of the process fewer than ten are needed.
        pub max_steps: usize = 60,
        /// A gap below this counts as closed, m: rounding of positions of a few metres.
        pub closed: f64 = 1e-12,
    }
}

/// A point of a path.
#[derive(Debug, Clone, PartialEq)]
pub struct Desired {
    /// Commands of a robot without errors, rad and m.
    pub nominal: Vec<f64>,
    /// Where the point should be, base frame; axes of the tool.
    pub target: Transform,
}

/// Why the robot without errors cannot be at a point.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Unreachable {
    /// The loops cannot be closed there.
    #[error(transparent)]
    Assembly(#[from] AssemblyError),
    /// No joints were found.
    #[error(transparent)]
    Inverse(#[from] InverseError),
    /// No joints were found, and nothing says why.
    #[error("no solution")]
    NoSolution,
    /// The joints of such a marker are not sought.
    #[error("joints are needed for a marker that does not sit on the tool, or whose orientation is free")]
    MarkerNeedsJoints,
}

/// Why a point is refused.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Refusal {
    /// The robot without errors cannot be there.
    #[error("unreachable: {0}")]
    Unreachable(#[from] Unreachable),
    /// Limits.
    #[error("out of limits: {}", .0.join(", "))]
    Limits(Vec<String>),
    /// A direction is lost.
    #[error("singular: the tool cannot move in one direction (condition number {condition:.0})")]
    Singular {
        /// Greatest over least singular value, m and rad on levers of 1 m.
        condition: f64,
    },
    /// The correction is no correction any more.
    #[error(
        "the correction would be too large: {variable} by {by} (condition number {condition:.0}); the point is near a singularity, or the model far from the robot"
    )]
    TooFar {
        /// The variable.
        variable: String,
        /// How far, with its unit.
        by: String,
        /// Condition number at the nominal commands.
        condition: f64,
    },
    /// The steps end elsewhere.
    #[error(
        "no convergence: after {iterations} iterations {:.4} mm and {:.5} deg are left",
        position * 1e3,
        orientation.to_degrees()
    )]
    Stuck {
        /// Remaining distance, m.
        position: f64,
        /// Remaining angle, rad.
        orientation: f64,
        /// Iterations done.
        iterations: usize,
    },
    /// The robot cannot be put together or loaded there.
    #[error(transparent)]
    Model(#[from] SingleError),
    /// The process cannot be where the point is.
    #[error("process: {0}")]
    Process(#[from] ProcessError),
    /// No balance between arm and process.
    #[error("no equilibrium of arm and process: {:.4} mm stay open", gap * 1e3)]
    Unsettled {
        /// Remaining gap, m.
        gap: f64,
    },
    /// The balance tips over.
    #[error("the equilibrium of arm and process is not stable (buckling)")]
    Unstable,
}

/// Why the robot, uncorrected, misses the target: displacements from it, m, base axes. They sum to [`Deviation::all`].
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Deviation {
    /// All together.
    pub all: Vector3<f64>,
    /// Geometry: what the calibrated constants differ from the controller's.
    pub geometry: Vector3<f64>,
    /// Own weight and preloads.
    pub weight: Vector3<f64>,
    /// The wrench applied, the process's included.
    pub wrench: Vector3<f64>,
    /// Effects.
    pub effects: Vector3<f64>,
    /// Angle between the tool's axes and the target's, rad.
    pub turned: f64,
}
