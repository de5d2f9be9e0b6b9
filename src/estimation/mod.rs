//! Calibration: what a campaign determines is fitted by bounded least squares, and judged on readings that were held out.
//! [`covariance`] says how intervals are made.

pub mod compensator;
pub mod fuzzy;

mod against;
mod bound_springs;
mod bounds;
mod calibration;
pub mod covariance;
mod determined;
mod dropped;
mod equivalence;
mod estimated;
mod far;
mod fit;
mod least_median;
mod network;
mod placing;
mod predicted;
mod problem;
mod reduction;
mod registration;
mod result;
mod robust;
mod schemes;
mod selection;
mod settings;
mod shared;
mod since;
mod split;
mod start;
mod statistics;
mod task;
mod weighing;

pub use against::{Against, OtherSet, against};
pub use bound_springs::{calibrate_as_weighed, held_springs};
pub use bounds::bounds;
pub use determined::{far_off, predicts_as_well, run_away};
pub use equivalence::{Equivalence, Split, SpringGroup};
pub use far::describes;
pub use least_median::least_median;
pub use network::{CHANGED, Network, Together};
pub use problem::{row_kinds, row_sigmas};
pub use reduction::{Reduction, candidates, observe};
pub use registration::{registered, with_campaign_fitted};
pub use result::{Calibration, CalibrationError, Comparison, Estimate, Figures, PredictedError};
pub use settings::{RegistrationSettings, Scheme, Settings, StartSettings, Weights, What, loss_fault};
pub use shared::SharedError;
pub use since::{Change, LEVEL, changes, comparable, holm, not_stated, with_uncertainties};
pub use split::{CHECK, SEED, split};
pub use statistics::{Errors, errors_of};
pub use weighing::{calibrate, compare, weighed};
