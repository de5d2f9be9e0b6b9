//! What the caller implements.

use std::error::Error;
use std::fmt;
use std::sync::Arc;

use nalgebra::{DMatrix, DVector};

/// A residual vector as a function of parameters, with its derivative.
pub trait Problem {
    /// Number of parameters, n.
    fn parameters(&self) -> usize;

    /// Number of residuals, m; any number, also less than n.
    fn residuals(&self) -> usize;

    /// Factor (above 0) of the scale of the [`Loss`](super::Loss) for one residual: residuals of several kinds may have a
    /// robust scale each. Infinite for one that counts by its square whatever its size, as a prior does.
    fn tuning(&self, _residual: usize) -> f64 {
        1.0
    }

    /// Norm of the rounding error to be expected in `r(x)`, beyond that of terms as large as `J_j x_j`: where the parameters are
    /// changes, the model is made of far greater terms than they are.
    fn rounding(&self) -> f64 {
        0.0
    }

    /// Writes `r(x)`, already weighted, into `residual` (m) and, if asked, `dr/dx` into `jacobian` (m x n).
    ///
    /// Both arrive with the right shape and with whatever an earlier call left in them: write every entry. The same `x`
    /// must give the same answer. An entry that is not finite is treated like an error.
    ///
    /// # Errors
    /// [`EvaluationError`] when `x` is outside the domain of the model. The minimiser then tries a shorter step.
    fn evaluate(
        &self,
        x: &[f64],
        residual: &mut DVector<f64>,
        jacobian: Option<&mut DMatrix<f64>>,
    ) -> Result<(), EvaluationError>;
}

/// The model has no value at this point: a loop that cannot close, a logarithm of a negative number.
///
/// It carries the error of the model, which [`EvaluationError::get_ref`] gives back with its type.
#[derive(Debug, Clone)]
pub struct EvaluationError(Arc<dyn Error + Send + Sync>);

impl EvaluationError {
    /// Of the model's own error, or of a sentence for the reader of a report.
    pub fn new(error: impl Into<Box<dyn Error + Send + Sync>>) -> Self {
        Self(error.into().into())
    }

    /// The model's own error.
    pub fn get_ref(&self) -> &(dyn Error + Send + Sync + 'static) {
        &*self.0
    }
}

impl fmt::Display for EvaluationError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

impl Error for EvaluationError {
    fn source(&self) -> Option<&(dyn Error + 'static)> {
        self.0.source()
    }
}

impl PartialEq for EvaluationError {
    fn eq(&self, other: &Self) -> bool {
        self.to_string() == other.to_string()
    }
}
