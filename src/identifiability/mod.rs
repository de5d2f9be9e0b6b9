//! What a campaign can determine: rank of the observation matrix, what is dropped and into what it is merged, conditioning
//! and observability.
//!
//! Columns are scaled, the measuring arrangement (base, tool, markers) is kept first, and the robot's parameters are
//! chosen by column-pivoted QR among what that leaves. Two reasons to drop a parameter are kept apart:
//!
//! * **exact**: its column is a combination of the kept ones up to rounding, whatever the instrument;
//! * **weak**: it is not, but what is left of it is below the asked tolerance, or below the noise.
//!
//! Either way its effect is not lost: it is merged into the kept parameters by the combination that is reported.
//! Sources: Khalil, Gautier and Enguehard (1991) for the QR selection; observability indices of Sun and Hollerbach (2008).

mod reduce;
mod sensitivity;

pub use reduce::{Column, merged, reduce};
pub use sensitivity::{Sensitivity, elastic_parameters, elastic_sensitivities, sensitivities};

use serde::{Deserialize, Serialize};

use crate::settings::named;

/// How columns are made comparable.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Scaling {
    /// Each column to length one.
    Norm,
    /// Each column times its parameter's stated tolerance.
    Tolerance,
}

/// When a parameter that is not exactly dependent is dropped all the same.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Criterion {
    /// As many are kept as the scaled matrix has singular values above this fraction of the first.
    Relative(f64),
    /// A parameter off by its tolerance changes the readings, beyond what the others can take up, by less than their
    /// noise: less than one sigma over the whole campaign.
    Noise,
    /// The same where the noise is so many times what the rows are divided by: of readings whose noise is not stated.
    NoiseTimes(f64),
}

/// The default of [`Criterion::Relative`].
pub const DEFAULT_TOLERANCE: f64 = 6e-5;

named! {
    /// Why a parameter is dropped.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum Why {
        /// Its column is a combination of others, or zero.
        Exact "exact",
        /// What is left of it is worthless at the tolerance or the noise.
        Weak "weak",
        /// It was asked to be held.
        Held "held",
    }
}

/// Result of the reduction. Columns are numbered as in the matrix given.
#[derive(Debug, Clone, PartialEq)]
pub struct Identifiability {
    /// Number of columns.
    pub columns: usize,
    /// Number of columns that are not exactly dependent.
    pub rank: usize,
    /// Kept columns, ascending.
    pub kept: Vec<usize>,
    /// Dropped columns, ascending, and why.
    pub dropped: Vec<(usize, Why)>,
    /// For each kept column, what it took over: dropped column and factor (its parameter's change stands for that of
    /// the dropped one times the factor; SI).
    pub combinations: Vec<(usize, Vec<(usize, f64)>)>,
    /// Part of each column's length that none of the columns chosen before it explains (1: independent).
    pub remainder: Vec<f64>,
    /// Singular values of the kept, scaled columns, descending.
    pub singular_values: Vec<f64>,
    /// Ratio of the first to the last; `None` where nothing is kept.
    pub condition: Option<f64>,
    /// Observability indices O1 to O5 of the kept, scaled columns; `None` where nothing is kept.
    pub observability: Option<[f64; 5]>,
    /// The tolerance asked for, if it was relative.
    pub tolerance: Option<f64>,
}

impl Identifiability {
    /// Dropped columns that others stand for: exactly dependent, and not zero.
    pub fn merged(&self) -> impl Iterator<Item = usize> {
        let takes = |column: usize| {
            self.combinations.iter().any(|(_, terms)| terms.iter().any(|(merged, _)| *merged == column))
        };
        let exact = self.dropped.iter().filter(|(_, why)| *why == Why::Exact).map(|(column, _)| *column);
        exact.filter(move |column| takes(*column))
    }
}
