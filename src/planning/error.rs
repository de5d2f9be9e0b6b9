//! Why measurements cannot be planned.

use crate::estimation::CalibrationError;
use crate::kinematics::AssemblyError;
use crate::prediction::PredictionError;

/// Why nothing is planned.
#[derive(Debug, thiserror::Error)]
pub enum PlanningError {
    /// The parameters cannot be estimated from any such readings.
    #[error(transparent)]
    Calibration(#[from] CalibrationError),
    /// A configuration cannot be predicted.
    #[error(transparent)]
    Prediction(#[from] PredictionError),
    /// Nothing can be assembled in the box.
    #[error(transparent)]
    Assembly(#[from] AssemblyError),
    /// A test configuration cannot be assembled.
    #[error("test pose {row}: {source}")]
    Test {
        /// Counted from 1.
        row: usize,
        /// Why.
        source: AssemblyError,
    },
    /// Too few configurations keep the rules.
    #[error(
        "only {found} of {tried} configurations drawn keep the limits, the workspace, the line of sight and out of the boxes of `keep_out`"
    )]
    TooFewAllowed {
        /// How many were found.
        found: usize,
        /// How many were drawn.
        tried: usize,
    },
    /// The box of the test poses holds none that the robot can take.
    #[error("none of {tried} test poses drawn can be taken")]
    NoTest {
        /// How many were drawn.
        tried: usize,
    },
    /// No parameter shows in the readings.
    #[error("no parameter shows in such readings")]
    NothingSeen,
    /// The least distance excludes so many.
    #[error("only {found} of {count} configurations are {apart} m apart")]
    TooNear {
        /// How many keep the distance.
        found: usize,
        /// How many were asked for.
        count: usize,
        /// Least distance, m.
        apart: f64,
    },
    /// Too few to separate the parameters.
    #[error("{count} configurations cannot separate {parameters} parameters; at least {least} are needed")]
    TooFew {
        /// How many were asked for.
        count: usize,
        /// Number of identifiable parameters.
        parameters: usize,
        /// Least number that would do.
        least: usize,
    },
}
