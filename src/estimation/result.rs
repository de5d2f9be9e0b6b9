//! What a calibration finds, or why it cannot be done.

use nalgebra::DMatrix;

use super::equivalence::Equivalence;
use super::shared::SharedError;
use super::statistics::Errors;
use crate::description::campaign::Campaign;
use crate::description::raw::RawFit;
use crate::identifiability::Identifiability;
use crate::least_squares::{EvaluationError, Loss, Status, UsageError};
use crate::math::quantiles::t95;
use crate::parameter::Slot;
use crate::prediction::{ConfigurationError, PredictionError};

/// Why a calibration cannot be done.
#[derive(Debug, thiserror::Error)]
pub enum CalibrationError {
    /// Readings cannot be predicted.
    #[error(transparent)]
    Prediction(#[from] PredictionError),
    /// There is nothing to estimate.
    #[error("nothing is free: the campaign estimates neither base nor tool, and the description frees no parameter")]
    NothingFree,
    /// Nothing elastic to estimate.
    #[error("nothing elastic is identifiable")]
    NothingElastic,
    /// Too few readings.
    #[error("{rows} residuals cannot determine {parameters} parameters")]
    TooFew {
        /// Residuals.
        rows: usize,
        /// Parameters.
        parameters: usize,
    },
    /// More readings and hypotheses than fit into the memory meant for them.
    #[error("the hypotheses need about {megabytes} MB of memory, and {most} MB are meant for them")]
    TooMuch {
        /// What they would need.
        megabytes: usize,
        /// What is allowed.
        most: usize,
    },
    /// The question is malformed.
    #[error(transparent)]
    Usage(#[from] UsageError),
    /// The settings do not go together, or not with the campaign.
    #[error("{0}")]
    Malformed(String),
    /// A fit on which everything else would rest stopped before a minimum.
    #[error(
        "the calibration did not converge ({ending}, {iterations} iterations), and nothing can be built on it: `identify` says what to try"
    )]
    NotConverged {
        /// How it ended.
        ending: Status,
        /// After so many iterations.
        iterations: usize,
    },
    /// The fit broke down.
    #[error("the fit stopped: {0}")]
    Stopped(#[from] EvaluationError),
    /// A parameter that pose by pose left its bounds, which that scheme does not heed.
    #[error("the fit stopped: pose by pose, `{0}` left its bounds; use the batch scheme")]
    LeftBounds(String),
}

/// One parameter's result, in the unit of its kind (SI).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// The parameter.
    pub slot: Slot,
    /// Description's value.
    pub nominal: f64,
    /// Estimated value (nominal where dropped).
    pub value: f64,
    /// Half width of the 95 % interval; `None` where the reduction dropped it.
    pub ci95: Option<f64>,
    /// Ends of the 95 % interval of a spring whose logarithm was fitted.
    pub interval: Option<[f64; 2]>,
    /// Standard uncertainty within it that is not of the readings: what dropped parameters, as uncertain as their
    /// tolerances, do to the value in second order. `None` where they do nothing.
    pub of_dropped: Option<f64>,
    /// Degrees of freedom of its variance, with which the interval is that of Student's t; see
    /// [`super::covariance::Covariance`]; `None` where it was dropped.
    pub degrees_of_freedom: Option<f64>,
    /// Whether it stopped at a bound.
    pub at_bound: bool,
    /// Greatest displacement of a fitted reading that an elastic parameter causes at its value, m; `None` for others.
    pub moves: Option<f64>,
}

impl Estimate {
    /// Whether it was estimated, not dropped.
    pub fn identifiable(&self) -> bool {
        self.ci95.is_some()
    }

    /// Standard uncertainty; `None` where the reduction dropped it.
    pub fn sigma(&self) -> Option<f64> {
        Some(self.ci95? / t95(self.degrees_of_freedom?))
    }

    /// Standard deviation by the readings alone and its degrees of freedom, with which the value of another campaign with the
    /// same robot is to be compared: what dropped parameters do is the same in both.
    pub fn repeatability(&self) -> Option<(f64, f64)> {
        let (sigma, open) = (self.sigma()?, self.of_dropped.unwrap_or(0.0));
        let part = if open > 0.0 { (1.0 - (open / sigma).powi(2)).max(0.0) } else { 1.0 };
        Some((sigma * part.sqrt(), self.degrees_of_freedom? * part.powi(2)))
    }
}

/// Error of held-out readings that a covariance predicts, root mean square of positions, m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PredictedError {
    /// Of the uncertainty of the parameters alone.
    pub parameters: f64,
    /// With the noise of the residuals added.
    pub with_noise: f64,
}

/// Errors of the readings to fit and to check.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Figures {
    /// Readings fitted.
    pub fit: Errors,
    /// Readings held out.
    pub check: Errors,
}

/// Result of a calibration.
#[derive(Debug, Clone)]
pub struct Calibration {
    /// All values, by slot.
    pub values: Vec<f64>,
    /// Candidates in the order of columns.
    pub slots: Vec<Slot>,
    /// What could be separated.
    pub identifiability: Identifiability,
    /// Results in the order of [`Calibration::slots`].
    pub estimates: Vec<Estimate>,
    /// Springs that act as one.
    pub equivalences: Vec<Equivalence>,
    /// Correlations of the kept parameters, in the order of [`Identifiability::kept`].
    pub correlation: DMatrix<f64>,
    /// Errors with the description as it is.
    pub before: Figures,
    /// With base, tool and markers fitted and the geometry nominal.
    pub registration: Figures,
    /// Calibrated.
    pub after: Figures,
    /// Predicted error of the held-out readings, if there are any.
    pub predicted: Option<PredictedError>,
    /// Predicted and observed error of each configuration held out.
    pub configurations: Vec<ConfigurationError>,
    /// Standard deviation of the residuals, in units of the stated one (1: the noise is as stated).
    pub noise_ratio: f64,
    /// Residuals and priors that determine something, less parameters; see [`super::covariance::Covariance`].
    pub degrees_of_freedom: f64,
    /// What readings of one configuration share, where that is more than nothing.
    pub shared: Option<SharedError>,
    /// Standard deviation of the residuals of each direction over the fitted readings, m; 0 for directions that the kind of
    /// readings does not have.
    pub direction_noise: [f64; 3],
    /// Iterations of the fit.
    pub iterations: usize,
    /// How well the kept parameters of the robot were determined together, as descriptions carry it.
    pub fit: RawFit,
    /// Root mean square of the residuals over their sigmas (with a robust loss, as it counts them) after each step taken.
    pub history: Vec<f64>,
    /// The loss that it was made with.
    pub loss: Loss,
    /// Why it ended.
    pub ending: Status,
    /// Residuals of all readings after calibration, as [`crate::prediction::Linearised::residual`].
    pub residual: Vec<f64>,
    /// The same with base, tool and markers fitted alone.
    pub registered: Vec<f64>,
    /// Whether each reading was held out.
    pub held_out: Vec<bool>,
}

impl Calibration {
    /// Whether the fit ended at a minimum.
    pub fn converged(&self) -> bool {
        self.ending.converged()
    }

    /// The parameters that were fitted: those that the readings determine.
    pub fn kept_slots(&self) -> Vec<Slot> {
        self.identifiability.kept.iter().filter_map(|&column| self.slots.get(column).copied()).collect()
    }

    /// Whether a reading was held out, by its index in the campaign.
    pub fn holds_out(&self, reading: usize) -> bool {
        self.held_out.get(reading) == Some(&true)
    }

    /// The readings of its campaign that were fitted.
    pub fn fitted(&self, campaign: &Campaign) -> Campaign {
        campaign.select(|index, _| !self.holds_out(index))
    }
}

/// The same calibration with equal weights (OLS) and with weights by direction (WLS).
#[derive(Debug, Clone)]
pub struct Comparison {
    /// All coordinates alike.
    pub ols: Calibration,
    /// By the noise of each direction.
    pub wls: Calibration,
}
