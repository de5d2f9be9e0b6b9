//! Springs as an identification reports them: groups that act as one, and springs that move no reading.
//!
//! A stiffness in N/m or N.m/rad, whatever the description says.

use serde::Serialize;

use crate::description::campaign::Campaign;
use crate::estimation::{Calibration, Equivalence, Estimate, Together};
use crate::model::Model;
use crate::parameter::{Kind, Parameter, Slot};

/// Springs that the readings see as one.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SpringGroup {
    /// Names, the kept one first.
    pub members: Vec<String>,
    /// Of groups within each other the outermost.
    pub kind: Together,
    /// The stiffness of the one spring from those of the members.
    pub formula: String,
    /// Stiffness (or compliance) of the one spring, in `unit`.
    pub equivalent: f64,
    /// Half width of its 95 % interval.
    pub ci95: f64,
    /// N/m or N.m/rad.
    pub unit: &'static str,
    /// Weights of the members in the sum; 1 of groups within each other, which `formula` has.
    pub weights: Vec<f64>,
    /// No member moves any reading noticeably.
    pub insensitive: bool,
}

/// Noise of deflections where none is stated, m: the resolution of a laser tracker.
const UNSTATED_NOISE: f64 = 3e-6;

/// Whether an elastic parameter's value moves no reading by as much as a third of the noise.
pub fn insensitive(campaign: &Campaign, estimate: &Estimate) -> bool {
    let noise = campaign.sigma.map_or(UNSTATED_NOISE, |sigma| sigma.into_iter().fold(0.0, f64::max));
    estimate.moves.is_some_and(|moves| moves < noise / 3.0)
}

/// The least stiffness that fits as well, with its unit, of a compliance that moves no reading.
pub(super) fn least_stiffness(parameter: &Parameter, estimate: &Estimate) -> Option<(f64, &'static str)> {
    matches!(parameter.kind, Kind::LinearCompliance | Kind::RotationalCompliance)
        .then(|| (1.0 / (estimate.value + estimate.ci95.unwrap_or(0.0)), parameter.kind.inverse().unit()))
}

impl SpringGroup {
    /// A group with the names of a model.
    pub fn new(model: &Model, campaign: &Campaign, found: &Calibration, group: &Equivalence) -> Self {
        let kind = group.springs.members.first().map_or(Kind::LinearCompliance, |&(slot, _)| model.registry[slot].kind);
        let is_stiffness = matches!(kind, Kind::LinearStiffness | Kind::RotationalStiffness);
        let unit = if is_stiffness { kind } else { kind.inverse() }.unit();
        let (equivalent, ci95) = match group.springs.together {
            Together::Series => (1.0 / group.value, group.ci95 / (group.value * group.value)),
            Together::Parallel => (group.value, group.ci95),
        };
        let of = |slot: Slot| found.estimates.iter().find(|estimate| estimate.slot == slot);
        Self {
            members: group.springs.members.iter().map(|&(slot, _)| model.registry[slot].name.clone()).collect(),
            kind: group.springs.together,
            formula: group.springs.formula(model),
            equivalent,
            ci95,
            unit,
            weights: group.springs.members.iter().map(|(_, weight)| *weight).collect(),
            insensitive: group
                .springs
                .members
                .iter()
                .all(|&(slot, _)| of(slot).is_some_and(|e| insensitive(campaign, e))),
        }
    }
}
