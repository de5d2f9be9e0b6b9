//! The answer, and the ways a question can be malformed.

use nalgebra::{DMatrix, DVector};
use thiserror::Error;

use super::{BoundsError, EvaluationError, Side};
use crate::settings::named;

/// The question makes no sense, or not at its start; nothing was computed.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum UsageError {
    /// A list has not one entry per parameter.
    #[error("{what} has {found} entries, the problem has {expected} parameters")]
    Length {
        /// Which list.
        what: &'static str,
        /// Number of parameters.
        expected: usize,
        /// Number of entries found.
        found: usize,
    },
    /// A starting value is NaN or infinite.
    #[error("starting value of parameter {index} is {value}")]
    Start {
        /// Position of the parameter, from 0.
        index: usize,
        /// The value found.
        value: f64,
    },
    /// The model has no value at the start, moved inside the bounds.
    #[error("there is no value at the start: {0}")]
    NoStart(EvaluationError),
    /// The limits leave no value.
    #[error(transparent)]
    Bounds(#[from] BoundsError),
    /// A setting breaks its rule.
    #[error("{name} is {value}; it must be {rule}")]
    Setting {
        /// Name of the field.
        name: &'static str,
        /// The value found.
        value: f64,
        /// The rule it breaks.
        rule: &'static str,
    },
    /// The problem handed back an array of another shape than it announced.
    #[error("the problem returned a {what} of {found:?}, expected {expected:?}")]
    Shape {
        /// Which array.
        what: &'static str,
        /// Rows and columns announced.
        expected: (usize, usize),
        /// Rows and columns found.
        found: (usize, usize),
    },
}

named! {
    /// How the iteration ended.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum Status {
        /// Converged: the residual is perpendicular to everything that may still move, or nothing may move.
        Gradient "gradient",
        /// Converged: the cost cannot be lowered noticeably.
        Cost "cost",
        /// Converged: the step is negligible.
        Step "step",
        /// Converged: the cost fell below the floor.
        PerfectFit "perfectfit",
        /// `max_iterations` steps were tried.
        IterationLimit "iterationlimit",
        /// The trust region shrank to nothing though the model promises progress: the derivative is wrong, the model jumps,
        /// or a wall of the domain is in the way. Also after a step lost in rounding noise.
        Stalled "stalled",
    }
}

impl Status {
    /// Whether the answer is a local minimum within the tolerances.
    pub fn converged(&self) -> bool {
        matches!(self, Self::Gradient | Self::Cost | Self::Step | Self::PerfectFit)
    }
}

/// The best point found and what is known there. Always within the bounds.
#[derive(Debug, Clone, PartialEq)]
pub struct Solution {
    /// Parameters (n).
    pub x: Vec<f64>,
    /// `r(x)` (m), without the robust weights.
    pub residual: DVector<f64>,
    /// `dr/dx` (m x n), without the robust weights.
    pub jacobian: DMatrix<f64>,
    /// Robust weight of each residual (m), between 0 and 1; all 1 for [`Loss::Squares`](super::Loss::Squares).
    pub weights: DVector<f64>,
    /// Gradient of the cost (n), `J' W r`; positive on an active lower bound, negative on an active upper one.
    pub gradient: DVector<f64>,
    /// `1/2 sum rho(r^2)`; for plain least squares half the residual sum of squares.
    pub cost: f64,
    /// The cost at the start, after it was moved inside the bounds.
    pub initial_cost: f64,
    /// Steps tried.
    pub iterations: usize,
    /// Evaluations of the residual alone.
    pub evaluations: usize,
    /// Evaluations of residual and Jacobian.
    pub jacobian_evaluations: usize,
    /// How the iteration ended.
    pub status: Status,
    /// The limit each parameter is on (n).
    pub at_bound: Vec<Option<Side>>,
}
