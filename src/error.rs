//! One error for a program that uses the library: what each module can refuse, so that `?` works throughout.

use crate::compensation::Refusal;
use crate::description::yaml::WriteError;
use crate::diagnostic::{Code, Diagnostic, Diagnostics};
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
    #[error("{message}")]
    Impossible {
        /// Why.
        message: String,
        /// What to do.
        remedy: &'static str,
    },
}

impl Error {
    /// One fault of an input, with what to do about it.
    pub fn input(message: impl Into<String>, remedy: impl Into<String>) -> Self {
        Diagnostic::error(message).remedy(remedy).into()
    }

    /// A name that nothing has, with the nearest of those that are known.
    pub fn unknown<'a>(message: impl Into<String>, name: &str, known: impl IntoIterator<Item = &'a str>) -> Self {
        Diagnostic::error(message).suggest(name, known).into()
    }

    /// What to try where a computation failed; diagnostics of inputs have their own.
    pub fn remedy(&self) -> Option<&'static str> {
        Some(match self {
            Self::Input(_) => return None,
            Self::At { error, .. } => return error.remedy(),
            Self::Inverse(_) => "give a target within reach and limits, free a part of it, or start elsewhere",
            Self::Process(_) | Self::Refusal(Refusal::Process(_)) => {
                "move the path, or the workpiece in the process file"
            }
            Self::Refusal(_) => "choose another posture, or another place of the path",
            Self::Assembly(_) => ASSEMBLY,
            Self::Mechanism(error) => error.remedy(),
            Self::Prediction(error) => of_prediction(error),
            Self::Calibration(error) => of_calibration(error),
            Self::Compensator(_) => "measure more of what it is identified from, or give what is known of it",
            Self::Planning(error) => match error {
                PlanningError::Calibration(error) => of_calibration(error),
                PlanningError::Prediction(error) => of_prediction(error),
                PlanningError::Assembly(_) | PlanningError::Test { .. } => ASSEMBLY,
                PlanningError::TooFewAllowed { .. } | PlanningError::NoTest { .. } => {
                    "widen limits (`--range`), the workspace or the line of sight"
                }
                PlanningError::NothingSeen => "choose readings that show what is free, or free other parameters",
                PlanningError::TooNear { .. } => "ask for fewer configurations, or let them be nearer to each other",
                PlanningError::TooFew { .. } => "ask for more configurations, or hold parameters",
            },
            Self::Json(_) | Self::Yaml(_) => "look at the values: they have to be finite, and text to be valid",
            Self::Io(_) => {
                "look whether the file or folder exists, may be read or written, and whether the disk is full"
            }
            Self::Impossible { remedy, .. } => remedy,
        })
    }

    /// The same error, with what it happened at.
    #[must_use]
    pub fn at(self, at: impl Into<String>) -> Self {
        Self::At { at: at.into(), error: Box::new(self) }
    }

    /// The same as diagnostics: those of a wrong input, else one that says what failed and what to try.
    pub fn explained(&self) -> Diagnostics {
        if let Some(found) = self.diagnostics() {
            return found.clone();
        }
        let code = match self {
            Self::Calibration(CalibrationError::NotConverged { .. }) => Code::NotConverged,
            _ => Code::NotComputed,
        };
        let diagnostic = Diagnostic::error(self.to_string()).code(code);
        match self.remedy() {
            Some(remedy) => diagnostic.remedy(remedy).into(),
            None => diagnostic.into(),
        }
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

const ASSEMBLY: &str = "give joint values within limits at which the loops close on the declared branch";

fn of_prediction(error: &PredictionError) -> &'static str {
    match error {
        PredictionError::Assembly { .. } | PredictionError::Model(_) => {
            "look at joints of that row (signs, columns, units; `check` says what it holds) and at the lengths of the loop"
        }
        PredictionError::Mechanism { source, .. } => source.remedy(),
        PredictionError::TooGreat { .. } => {
            "look at the loads of that row and at `force`, `torque` and `stiffness` under `units:`"
        }
        PredictionError::Empty => "give readings under `measurements:`",
    }
}

fn of_calibration(error: &CalibrationError) -> &'static str {
    match error {
        CalibrationError::Prediction(error) => of_prediction(error),
        CalibrationError::NothingFree => {
            "write `estimate: {base: true, tool: true}` into the campaign, or free parameters (`calibration: {free: [..]}`)"
        }
        CalibrationError::NothingElastic => {
            "give springs `identifiable: true` in the description, or name parameters under `calibration: {free: [..]}`"
        }
        CalibrationError::TooMuch { .. } => "leave out configurations, or diagnose the sessions apart",
        CalibrationError::TooFew { .. } => "measure more configurations, or hold parameters (`--hold`)",
        CalibrationError::Usage(_) | CalibrationError::Malformed(_) => {
            "leave that option out, or give it a value that fits the campaign"
        }
        CalibrationError::NotConverged { .. } => "run `identify` on the same campaign: it says what to try",
        CalibrationError::Stopped(_) | CalibrationError::LeftBounds(_) => {
            "hold what the readings hardly show (`--hold`), or let tolerances pull (`--prior`)"
        }
    }
}
