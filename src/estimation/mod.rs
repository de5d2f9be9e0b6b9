//! Calibration: what a campaign determines is fitted by bounded least squares, and judged on readings that were held out.
//! [`covariance`] says how intervals are made.

pub mod compensator;
pub mod fuzzy;

mod calibration;
pub mod covariance;
mod equivalence;
mod fit;
mod problem;
mod reduction;
mod registration;
mod result;
mod schemes;
mod selection;
mod settings;
mod split;
mod start;
mod statistics;

pub use calibration::{calibrate, compare};
pub use equivalence::{Equivalence, Split, SpringGroup, Together};
pub use problem::row_sigmas;
pub use reduction::{Reduction, candidates, observe};
pub use result::{Calibration, CalibrationError, Comparison, Estimate, Figures, PredictedError};
pub use settings::{RegistrationSettings, Scheme, Settings, StartSettings, Weights, What};
pub use split::split;
pub use statistics::{Errors, errors_of};
