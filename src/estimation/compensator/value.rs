//! Values with intervals, and why there are none. SI.

use crate::least_squares::UsageError;

/// Ratio of the least to the greatest singular value (or of their squares) below which points or angles leave a direction
/// open: rounding of measured coordinates is far above it.
pub(super) const DEGENERATE: f64 = 1e-9;

/// A value with the half width of its 95 % interval, if the data leave anything to judge it by.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Value {
    /// SI.
    pub value: f64,
    /// SI.
    pub ci95: Option<f64>,
}

/// Why a compensator cannot be found.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{0}")]
pub struct CompensatorError(pub String);

impl From<UsageError> for CompensatorError {
    fn from(error: UsageError) -> Self {
        Self(error.to_string())
    }
}

pub(super) fn refuse<T>(message: impl Into<String>) -> Result<T, CompensatorError> {
    Err(CompensatorError(message.into()))
}
