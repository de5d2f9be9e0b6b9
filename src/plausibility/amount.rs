//! Whether there are enough readings to say anything.

use super::evidence::Limits;
use crate::description::campaign::Amount;
use crate::diagnostic::{Code, Diagnostic};

/// A warning of too few configurations, or too few readings for so many fitted parameters.
pub(super) fn too_little(amount: &Amount, fitted: usize, limits: &Limits) -> Option<Diagnostic> {
    let Amount { configurations, rows } = *amount;
    let is_few = configurations < limits.fewest_configurations;
    let per_parameter = rows as f64 / fitted.max(1) as f64;
    if !is_few && per_parameter >= limits.rows_per_parameter {
        return None;
    }
    let message = if is_few {
        let from = match configurations {
            1 => "one configuration".into(),
            several => format!("{several} different configurations"),
        };
        format!("the readings come from {from}: too few to tell a sound robot from any other")
    } else {
        format!(
            "{rows} residuals of different readings for {fitted} fitted parameters: errors of readings that were not seen can be far \
             greater than those that are left"
        )
    };
    let diagnostic = Diagnostic::warning(message)
        .code(Code::TooLittleData)
        .remedy("measure more configurations that differ (`plan` chooses them), or hold parameters (`--hold`)")
        .figure("configurations", configurations as f64)
        .figure("rows", rows as f64)
        .figure("parameters", fitted as f64);
    Some(diagnostic)
}
