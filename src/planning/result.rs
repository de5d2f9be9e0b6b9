//! What planning finds: stations, the errors they leave, and what other numbers of them would leave. SI.

use super::place::Station;
use crate::description::campaign::Campaign;
use crate::identifiability::Identifiability;
use crate::parameter::Slot;

/// What a number of configurations buys.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bought {
    /// Number of configurations added.
    pub count: usize,
    /// Root mean square position error at the test poses when they are planned, m.
    pub planned: f64,
    /// The same when they are drawn at random: median of [`super::Settings::random_sets`].
    pub random: f64,
}

/// A plan.
#[derive(Debug, Clone)]
pub struct Planned {
    /// Stations in the order in which they should be measured.
    pub stations: Vec<Station>,
    /// The campaign that they make.
    pub campaign: Campaign,
    /// Parameters by column.
    pub slots: Vec<Slot>,
    /// Reduction on the planned (and already made) readings alone.
    pub identifiability: Identifiability,
    /// Kept parameters and one sigma of each, SI.
    pub deviations: Vec<(Slot, f64)>,
    /// Root mean square position error at the test poses that the parameters' covariance leaves, m: with what is measured
    /// already alone (where that tells them apart), and with the plan.
    pub before: Option<f64>,
    /// With the plan.
    pub error: f64,
    /// What other numbers of configurations would buy.
    pub bought: Vec<Bought>,
    /// How many random configurations (median of [`super::Settings::random_sets`]) do as well; none if more than there are candidates.
    pub random_equal: Option<usize>,
    /// Fewest configurations that separate the parameters.
    pub least: usize,
    /// Candidates that keep the rules.
    pub candidates: usize,
}
