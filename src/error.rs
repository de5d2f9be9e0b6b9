//! One error for a program that uses the library: what each module can refuse, so that `?` works throughout.

use crate::compensation::Refusal;
use crate::description::yaml::WriteError;
use crate::diagnostic::{Diagnostic, Diagnostics};
use crate::elastics::Mechanism;
use crate::estimation::CalibrationError;
use crate::estimation::compensator::CompensatorError;
use crate::kinematics::{AssemblyError, InverseError};
use crate::planning::PlanningError;
use crate::prediction::PredictionError;
use crate::process::ProcessError;
use crate::state::StateError;

/// Why something cannot be read or computed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// An input (description, campaign, table, argument) is wrong: every fault, located.
    #[error(transparent)]
    Input(#[from] Diagnostics),
    /// The robot cannot be assembled at a configuration.
    #[error(transparent)]
    Assembly(#[from] AssemblyError),
    /// The elastic structure can move without any force, or has no equilibrium.
    #[error(transparent)]
    Mechanism(#[from] Mechanism),
    /// A reading cannot be predicted.
    #[error(transparent)]
    Prediction(#[from] PredictionError),
    /// The inverse model has no solution.
    #[error(transparent)]
    Inverse(#[from] InverseError),
    /// A calibration or diagnosis cannot be done.
    #[error(transparent)]
    Calibration(#[from] CalibrationError),
    /// A gravity compensator cannot be identified.
    #[error(transparent)]
    Compensator(#[from] CompensatorError),
    /// No configurations can be chosen.
    #[error(transparent)]
    Planning(#[from] PlanningError),
    /// A process cannot be carried out.
    #[error(transparent)]
    Process(#[from] ProcessError),
    /// A point of a path cannot be reached.
    #[error(transparent)]
    Refusal(#[from] Refusal),
    /// A value cannot be written as JSON or read from it.
    #[error(transparent)]
    Json(#[from] serde_json::Error),
    /// A value cannot be written as YAML.
    #[error(transparent)]
    Yaml(#[from] WriteError),
    /// A file cannot be read or written.
    #[error(transparent)]
    Io(#[from] std::io::Error),
    /// The same, with what it happened at: a row, a point, a file.
    #[error("{at}: {error}")]
    At {
        /// Where.
        at: String,
        /// What.
        #[source]
        error: Box<Error>,
    },
    /// The question has no answer for this robot or campaign.
    #[error("{0}")]
    Impossible(String),
}

impl Error {
    /// One fault of an input, with what to do about it.
    pub fn input(message: impl Into<String>, remedy: impl Into<String>) -> Self {
        Diagnostic::error(message).remedy(remedy).into()
    }

    /// What to try where a computation failed, if it is always the same; diagnostics of inputs have their own.
    pub fn remedy(&self) -> Option<&'static str> {
        Some(match self {
            Self::At { error, .. } => return error.remedy(),
            Self::Inverse(_) => "give a target within reach and limits, free a part of it, or start elsewhere",
            Self::Process(_) | Self::Refusal(Refusal::Process(_)) => {
                "move the path, or the workpiece in the process file"
            }
            Self::Refusal(_) => "choose another posture, or another place of the path",
            Self::Assembly(_) => "give joint values within limits at which the loops close on the declared branch",
            Self::Mechanism(_) => "give what moves without force a stiffness, or support it",
            Self::Prediction(_) => "look at the reading named; `check` says what the campaign holds",
            _ => return None,
        })
    }

    /// The same error, with what it happened at.
    #[must_use]
    pub fn at(self, at: impl Into<String>) -> Self {
        Self::At { at: at.into(), error: Box::new(self) }
    }

    /// The diagnostics of a wrong input; `None` where the input is sound and the computation failed.
    pub fn diagnostics(&self) -> Option<&Diagnostics> {
        match self {
            Self::Input(diagnostics) => Some(diagnostics),
            Self::At { error, .. } => error.diagnostics(),
            _ => None,
        }
    }
}

impl From<StateError> for Error {
    fn from(error: StateError) -> Self {
        match error {
            StateError::Assembly(error) => error.into(),
            StateError::Mechanism(error) => error.into(),
        }
    }
}

impl From<Diagnostic> for Error {
    fn from(diagnostic: Diagnostic) -> Self {
        Self::Input(diagnostic.into())
    }
}

impl From<Vec<Diagnostic>> for Error {
    fn from(diagnostics: Vec<Diagnostic>) -> Self {
        Self::Input(diagnostics.into())
    }
}
