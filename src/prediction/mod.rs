//! What each reading should be, and how it changes with every parameter: the one place where physics meets data.
//!
//! Residuals and derivatives are SI (m, rad) in the axes of the measurement frame; mechanics come from [`crate::state`], what
//! a reading shows of them from [`crate::observation`].

mod batch;
mod columns;
mod configurations;
mod drivers;
mod effects;
mod error;
mod holding;
mod measured_loads;
mod reading;
mod single;
mod survey;
mod terms;
mod touching;
mod uncertainty;

pub use batch::{Linearised, Predictor, residuals};
pub use configurations::{ConfigurationError, ConfigurationErrors, NoiseParts};
pub use effects::effect_columns;
pub use error::PredictionError;
pub use holding::{fill_holding_loads, with_holding_loads};
pub use reading::{earlier_normal, target_values, undeflected_point};
pub use single::{Seen, SingleError, SinglePredictor, SingleWorkspace};
pub use survey::{joint_loads, survey};
pub use terms::{Declared, Term, declared};
pub use touching::{Toucher, seated};
pub use uncertainty::FittedUncertainty;
