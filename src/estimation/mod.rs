//! Estimation of parameters from measurements.
pub mod least_squares;
