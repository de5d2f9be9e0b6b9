//! Lower and upper limits of the parameters.

use nalgebra::DVector;
use thiserror::Error;

/// Limits of each parameter, in its own unit; `f64::NEG_INFINITY` and `f64::INFINITY` mean "none".
///
/// Equal limits hold a parameter fixed. The fields are open, so [`minimize`](super::minimize) checks them again.
#[derive(Debug, Clone, PartialEq)]
pub struct Bounds {
    /// Smallest value allowed of each parameter.
    pub lower: Vec<f64>,
    /// Largest value allowed of each parameter.
    pub upper: Vec<f64>,
}

/// Which limit a parameter is on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// The lower limit; also of a parameter whose limits are equal.
    Lower,
    /// The upper limit.
    Upper,
}

/// Limits between which there is no number.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum BoundsError {
    /// The two lists differ in length.
    #[error("{lower} lower bounds but {upper} upper bounds")]
    Lengths {
        /// Number of lower limits.
        lower: usize,
        /// Number of upper limits.
        upper: usize,
    },
    /// The interval of one parameter is empty, or a limit is NaN.
    #[error("bounds of parameter {index} leave no value: lower {lower}, upper {upper}")]
    Empty {
        /// Position of the parameter, from 0.
        index: usize,
        /// Its lower limit.
        lower: f64,
        /// Its upper limit.
        upper: f64,
    },
}

impl Bounds {
    /// Checked limits.
    ///
    /// # Errors
    /// [`BoundsError`] when the lengths differ, or for the first parameter whose limits are reversed, are NaN, or admit
    /// only an infinite value.
    pub fn new(lower: Vec<f64>, upper: Vec<f64>) -> Result<Self, BoundsError> {
        let bounds = Self { lower, upper };
        bounds.check()?;
        Ok(bounds)
    }

    /// No limits on `parameters` parameters.
    pub fn none(parameters: usize) -> Self {
        Self { lower: vec![f64::NEG_INFINITY; parameters], upper: vec![f64::INFINITY; parameters] }
    }

    pub(super) fn check(&self) -> Result<(), BoundsError> {
        if self.lower.len() != self.upper.len() {
            return Err(BoundsError::Lengths { lower: self.lower.len(), upper: self.upper.len() });
        }
        for (index, (&lower, &upper)) in self.lower.iter().zip(&self.upper).enumerate() {
            // NaN fails every comparison, so it is refused here too.
            let some_number_fits = lower <= upper && lower < f64::INFINITY && upper > f64::NEG_INFINITY;
            if !some_number_fits {
                return Err(BoundsError::Empty { index, lower, upper });
            }
        }
        Ok(())
    }

    /// The nearest point that respects the limits.
    pub(super) fn clamp(&self, x: &mut [f64]) {
        for ((x, &lower), &upper) in x.iter_mut().zip(&self.lower).zip(&self.upper) {
            *x = x.max(lower).min(upper);
        }
    }

    /// The limit that holds each parameter at `x` against the way downhill, given a gradient up to positive factors.
    pub(super) fn blocked(&self, x: &[f64], gradient: &DVector<f64>) -> Vec<Option<Side>> {
        let limits = self.lower.iter().zip(&self.upper);
        let holds = |(side, ((lower, upper), &gradient))| match side {
            Some(_) if lower == upper => side,
            Some(Side::Lower) if gradient >= 0.0 => side,
            Some(Side::Upper) if gradient <= 0.0 => side,
            _ => None,
        };
        self.touched(x).into_iter().zip(limits.zip(gradient)).map(holds).collect()
    }

    /// The limit each parameter is on.
    pub(super) fn touched(&self, x: &[f64]) -> Vec<Option<Side>> {
        let side = |((&x, &lower), &upper)| {
            if x <= lower {
                Some(Side::Lower)
            } else if x >= upper {
                Some(Side::Upper)
            } else {
                None
            }
        };
        x.iter().zip(&self.lower).zip(&self.upper).map(side).collect()
    }
}
