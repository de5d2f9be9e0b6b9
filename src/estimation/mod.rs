//! Calibration: what the campaign can tell is fitted by bounded least squares, and judged on readings it did not see.

pub mod least_squares;

mod calibration;
mod observation;
mod problem;
mod registration;
mod schemes;
mod split;
mod statistics;

pub use calibration::{
    Calibration, CalibrationError, Comparison, Estimate, Figures, Scheme, Settings, Weights, calibrate, compare,
};
pub use observation::{Observation, observe};
pub use problem::row_sigmas;
pub use split::split;
pub use statistics::{Errors, errors_of};
