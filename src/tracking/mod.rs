//! A robot over time: its campaigns compared check by check, with control of false alarms over all parameters and checks.
//!
//! [`calibrated`] estimates the same parameters from each campaign; [`monitor`] says at which check which of them changed, and
//! how; [`next_check`] how many poses the next check needs. A base put down anew or another tool are no change of the robot:
//! both are estimated with each campaign, and their motions are reported separately.

mod calibrated;
mod check;
mod contrast;
mod error;
mod monitor;
mod next_check;
mod settings;
mod stretch;
mod words;

pub use calibrated::{Calibrated, Measured, calibrated};
pub use check::{Check, Estimates, Residuals};
pub use contrast::Amount;
pub use error::TrackingError;
pub use monitor::{Event, Finding, History, Shape, monitor};
pub use next_check::{NextCheck, next_check, usual_changes};
pub use settings::Settings;
pub use words::{EventKind, likely, meaning};
