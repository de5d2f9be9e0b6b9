//! Quantiles of the distributions that intervals are made of. Every interval of the library is two-sided and holds 95 %.

use std::sync::LazyLock;

use statrs::distribution::{ContinuousCDF, Normal, StudentsT};

/// Probability below the upper end of a two-sided 95 % interval.
const UPPER: f64 = 0.975;

/// Half width of the two-sided 95 % interval of a standard normal variable, 1.959964: the standard deviation is known.
pub fn normal95() -> f64 {
    static QUANTILE: LazyLock<f64> = LazyLock::new(|| Normal::standard().inverse_cdf(UPPER));
    *QUANTILE
}

/// Half width of the two-sided 95 % interval of Student's t: the standard deviation is estimated with so many degrees of
/// freedom. Infinite where none is left (0 or fewer).
pub fn t95(degrees_of_freedom: f64) -> f64 {
    StudentsT::new(0.0, 1.0, degrees_of_freedom).map_or(f64::INFINITY, |t| t.inverse_cdf(UPPER))
}
