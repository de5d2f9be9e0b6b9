//! Why campaigns cannot be compared.

use crate::estimation::CalibrationError;
use crate::least_squares::Status;

/// Why campaigns cannot be compared.
#[derive(Debug, thiserror::Error)]
pub enum TrackingError {
    /// There is nothing to compare with.
    #[error("one check shows no changes: there is nothing to compare it with")]
    OneCheck,
    /// A calibration failed.
    #[error("{campaign}: {error}")]
    Calibration {
        /// Of this campaign.
        campaign: String,
        /// Why.
        #[source]
        error: CalibrationError,
    },
    /// A calibration did not end at a minimum.
    #[error(
        "{campaign}: the calibration did not converge ({ending}, {iterations} iterations), and its estimates say nothing of changes"
    )]
    NotConverged {
        /// Of this campaign.
        campaign: String,
        /// How it ended.
        ending: Status,
        /// After so many iterations.
        iterations: usize,
    },
    /// A campaign determines none of the robot's constants.
    #[error("{campaign}: determines none of the robot's own constants")]
    NothingKept {
        /// This campaign.
        campaign: String,
    },
    /// No constant is determined by all campaigns.
    #[error("no constant of the robot is determined by all campaigns")]
    NothingCommon,
    /// Estimates of a check depend on each other.
    #[error("{check}: the estimates have no regular covariance (readings without noise?)")]
    Singular {
        /// This check.
        check: String,
    },
}
