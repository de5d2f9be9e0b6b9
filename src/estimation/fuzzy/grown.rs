//! What a fit of rules finds.

use super::samples::Samples;
use crate::description::fuzzy::Rules;
use crate::description::robot::FrameIndex;
use crate::fuzzy::value;

/// A structure that was tried and taken.
#[derive(Debug, Clone, PartialEq)]
pub struct Step {
    /// Components (displacement, load) that are fitted together: by loads that act together in some readings, or by
    /// reciprocity.
    pub components: Vec<[usize; 2]>,
    /// The one of them that got a set; `None` at the beginning, and where all got it.
    pub component: Option<[usize; 2]>,
    /// Sets of each input, of that one; one each at the beginning, zero where there are no rules yet; empty for a tree.
    pub sets: Vec<usize>,
    /// Number of rules.
    pub rules: usize,
    /// Root mean square error of the displacements over the fitted readings under these loads, m (rad of rotations alone);
    /// `None` where there are no rules yet.
    pub fitted: Option<f64>,
    /// The same when parts of the configurations are left out in turns.
    pub cross_validated: f64,
}

/// Rules of one component of the compliance.
#[derive(Debug, Clone, PartialEq)]
pub struct SubModel {
    /// Displacement component (x, .., rz) and load component.
    pub at: [usize; 2],
    /// Rules over the offered inputs.
    pub rules: Rules,
    /// Weight of each rule, summed over what it is fitted to: readings that load it, or of a tree configurations.
    pub support: Vec<f64>,
    /// Rules that have seen no data: their conclusions are their neighbours'.
    pub unseen: Vec<usize>,
}

/// Rules of all components, and how they came about.
#[derive(Debug, Clone, PartialEq)]
pub struct Grown {
    /// By displacement component, then load component.
    pub components: Vec<SubModel>,
    /// Frame whose axes they have; `None` is the base.
    pub axes: Option<FrameIndex>,
    /// Least and greatest of each offered input among the fitted readings; outside, the model holds its last value.
    pub range: Vec<[f64; 2]>,
    /// Held-out readings whose inputs are outside that range.
    pub beyond: usize,
    /// How the structure grew.
    pub steps: Vec<Step>,
    /// Error left in cross-validation relative to the size of the displacements, squared and summed: by which axes are
    /// compared.
    pub(super) left_out: f64,
}

impl Grown {
    /// Which of the offered inputs have an influence.
    pub fn used(&self) -> Vec<usize> {
        let has = |k: &usize| self.components.iter().any(|own| own.rules.premise.marks(*k).len() > 1);
        (0..self.range.len()).filter(has).collect()
    }

    /// What the rules leave of a sample's displacement, m and rad.
    pub(super) fn residual(&self, samples: &Samples, sample: usize) -> [f64; 6] {
        let mut left = samples.d[sample];
        for own in &self.components {
            let [row, column] = own.at;
            left[row] -= value(&own.rules, &samples.x[sample]) * samples.load[sample][column];
        }
        left
    }
}
