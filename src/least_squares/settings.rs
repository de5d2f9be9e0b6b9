//! What the caller may choose about the iteration.

use super::{Loss, UsageError};
use crate::settings::settings;

settings! {
    /// Limits and tolerances of [`minimize`](super::minimize); all of them dimensionless, except the scale of the loss.
    ///
    /// The defaults leave the answer a negligible part of its standard deviation from the minimum. A tolerance of 0 switches its test
    /// off.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct Settings {
        /// Steps to try, accepted or not. 500 is several times what the hardest problem of Moré, Garbow and Hillstrom (1981) takes.
        pub max_iterations: usize = 500,
        /// Stop when a step is expected to lower, and does lower, the cost by less than this fraction. The default is rounding:
        /// the certified digits of the NIST problems need it. Raise it to 1e-9 or so where a rough answer will do.
        pub cost_tolerance: f64 = 1e-16,
        /// Stop when the scaled step is below this fraction of the scaled parameters: the default leaves 12 digits of them.
        pub step_tolerance: f64 = 1e-12,
        /// Stop when the residual is perpendicular to every column of the Jacobian that may still move: the largest cosine
        /// (Moré 1978, section 8). Rounding of the gradient leaves about 1e-13.
        pub gradient_tolerance: f64 = 1e-12,
        /// Stop when the cost is below this value: a perfect fit. Without it a zero-residual problem with a singular
        /// Jacobian creeps on to the smallest positive number.
        pub cost_floor: f64 = 1e-40,
        /// First radius of the trust region, as a multiple of the scaled start: 1 lets the parameters change by about their
        /// own size in the first step. Where every parameter starts at 0, as a multiple of the residual.
        pub initial_radius: f64 = 1.0,
        /// How large residuals count.
        pub loss: Loss = Loss::Squares,
    }
}

impl Settings {
    pub(super) fn check(&self) -> Result<(), UsageError> {
        let refuse = |name, value, rule| Err(UsageError::Setting { name, value, rule });
        let tolerances = [
            ("cost_tolerance", self.cost_tolerance),
            ("step_tolerance", self.step_tolerance),
            ("gradient_tolerance", self.gradient_tolerance),
        ];
        for (name, value) in tolerances {
            if !(0.0..1.0).contains(&value) {
                return refuse(name, value, "at least 0 and less than 1");
            }
        }
        if !(self.cost_floor >= 0.0 && self.cost_floor.is_finite()) {
            return refuse("cost_floor", self.cost_floor, "finite and not negative");
        }
        if !(self.initial_radius > 0.0 && self.initial_radius.is_finite()) {
            return refuse("initial_radius", self.initial_radius, "finite and positive");
        }
        match self.loss.scale() {
            Some(scale) if !(scale > 0.0 && scale.is_finite()) => refuse("loss", scale, "a finite and positive scale"),
            _ => Ok(()),
        }
    }
}

/// One step of the iteration.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Progress {
    /// Steps tried so far.
    pub iteration: usize,
    /// Cost after this step, or as before if the step was refused.
    pub cost: f64,
    /// Scaled length of the step.
    pub step: f64,
    /// Radius of the trust region the step was made in.
    pub radius: f64,
    /// Actual over expected reduction of the cost; `None` where the model had no value.
    pub gain: Option<f64>,
    /// Whether the step was taken.
    pub accepted: bool,
}
