//! Calibration: what the campaign can tell is fitted by bounded least squares, and judged on readings it did not see.

pub mod compensator;
pub mod fuzzy;

mod calibration;
mod equivalence;
mod observation;
mod problem;
mod registration;
mod result;
mod schemes;
mod settings;
mod split;
mod start;
mod statistics;

pub use calibration::{calibrate, compare};
pub use equivalence::{Equivalence, Split, Together};
pub use observation::{Observation, candidates, observe};
pub use problem::row_sigmas;
pub use result::{Calibration, CalibrationError, Comparison, Estimate, Figures};
pub use settings::{Scheme, Settings, Weights, What};
pub use split::split;
pub use statistics::{Errors, errors_of};
