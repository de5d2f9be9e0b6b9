//! What a fit of rules finds.

use super::partition::Partition;

/// A structure that was tried and taken.
#[derive(Debug, Clone, PartialEq)]
pub struct Step {
    /// Displacement component (0 to 2: x, y, z).
    pub axis: usize,
    /// Load components (0 to 5) that act together in some readings, and are fitted together.
    pub columns: Vec<usize>,
    /// The one of them that got a set; `None` at the beginning.
    pub column: Option<usize>,
    /// Sets of each input, of that one; one each at the beginning, zero where there are no rules yet.
    pub sets: Vec<usize>,
    /// Root mean square error of the displacement component over the fitted readings under these loads, m; `None` where
    /// there are no rules yet.
    pub fitted: Option<f64>,
    /// The same over the test readings.
    pub test: f64,
}

/// Rules of one component of the compliance.
#[derive(Debug, Clone, PartialEq)]
pub struct SubModel {
    /// Displacement component (x, y, z) and load component.
    pub at: [usize; 2],
    /// Modal values by offered input, rad or m; a single one where the input has no influence.
    pub modes: Partition,
    /// Conclusions, m per N or N.m; the last input's sets count fastest.
    pub conclusions: Vec<f64>,
    /// Firing strength of each rule, summed over the fitted readings that load it.
    pub support: Vec<f64>,
    /// Rules that have seen no data: their conclusions are their neighbours'.
    pub unseen: Vec<usize>,
}

/// Rules of all components, and how they came about.
#[derive(Debug, Clone, PartialEq)]
pub struct Grown {
    /// By displacement component, then load component.
    pub components: Vec<SubModel>,
    /// Least and greatest of each offered input among the fitted readings; outside, the model holds its last value.
    pub range: Vec<[f64; 2]>,
    /// Held-out readings whose inputs are outside that range.
    pub beyond: usize,
    /// How the structure grew.
    pub steps: Vec<Step>,
}

impl Grown {
    /// Which of the offered inputs have an influence.
    pub fn used(&self) -> Vec<usize> {
        (0..self.range.len()).filter(|&k| self.components.iter().any(|c| c.modes[k].len() > 1)).collect()
    }
}
