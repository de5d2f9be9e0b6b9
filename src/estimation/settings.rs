//! What is asked of a calibration.

use super::equivalence::Split;
use crate::description::campaign::Campaign;
use crate::identifiability::{Criterion, DEFAULT_TOLERANCE, Scaling};
use crate::least_squares::Loss;
use crate::observation::{Observes, Purpose};
use crate::parameter::Slot;

/// How the fit proceeds. All schemes end at the same parameters.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scheme {
    /// All readings and parameters at once.
    Batch,
    /// Configuration by configuration (IR663 paper, sec. 2.1.5).
    PoseByPose,
    /// Base and tool, then geometry, in turns (KR-270 paper, sec. III.A).
    Alternating,
}

/// How readings are weighted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Weights {
    /// By the campaign's stated noise (equally where none is stated).
    Stated,
    /// All coordinates alike (OLS).
    Equal,
    /// By the noise of each direction, estimated from the residuals of a first fit (WLS).
    Direction,
}

/// Which parameters are estimated beside base and tool.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct What {
    /// Geometry that the description frees.
    pub geometric: bool,
    /// What gives and is declared identifiable.
    pub elastic: bool,
}

impl What {
    /// What a campaign's readings are made for: stiffness from deflections, geometry from the rest.
    pub fn usual(campaign: &Campaign) -> Self {
        Self::of(campaign.observes)
    }

    /// What readings of a kind are made for.
    pub fn of(observes: Observes) -> Self {
        let elastic = observes.purpose() == Purpose::Stiffness;
        Self { geometric: !elastic, elastic }
    }
}

/// What is asked of a calibration.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// Which parameters are estimated; what the readings are made for where `None`.
    pub what: Option<What>,
    /// Exactly these parameters beside base and tool, whatever [`Settings::what`] and the description say.
    pub only: Option<Vec<Slot>>,
    /// How springs that act as one are split back.
    pub split: Split,
    /// Scheme of the fit.
    pub scheme: Scheme,
    /// Weights of readings.
    pub weights: Weights,
    /// Robust loss, in sigmas.
    pub loss: Loss,
    /// Whether the stated tolerances pull parameters towards their nominal values.
    pub prior: bool,
    /// Column scaling of the reduction.
    pub scaling: Scaling,
    /// When a parameter that is not exactly dependent is dropped.
    pub criterion: Criterion,
    /// Parameters to hold at their nominal values, by name.
    pub hold: Vec<String>,
    /// Most iterations.
    pub max_iterations: usize,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            what: None,
            only: None,
            split: Split::default(),
            scheme: Scheme::Batch,
            weights: Weights::Stated,
            loss: Loss::Squares,
            prior: false,
            scaling: Scaling::Norm,
            criterion: Criterion::Relative(DEFAULT_TOLERANCE),
            hold: Vec::new(),
            max_iterations: 200,
        }
    }
}
