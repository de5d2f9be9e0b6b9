//! Springs that a campaign cannot tell apart: in series they act as one of compliance sum c_i, in parallel as one of
//! stiffness sum k_i (eq. (68), (69) of the IR663 calibration paper).

use crate::description::campaign::Campaign;
use crate::identifiability::Identifiability;
use crate::model::Model;
use crate::parameter::{Group, Kind, Slot};

/// How springs act together.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Together {
    /// One after the other: compliances add.
    Series,
    /// Side by side: stiffnesses add.
    Parallel,
}

/// By which rule an equivalent is split back into its members.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Split {
    /// In proportion to what the description says.
    #[default]
    Prior,
    /// The smallest sum of squared compliances that adds up to it.
    MinimumNorm,
}

/// Springs that act as one.
#[derive(Debug, Clone, PartialEq)]
pub struct Equivalence {
    /// The kept one first, then those merged into it, with their weights in the sum (1 for plain series).
    pub members: Vec<(Slot, f64)>,
    /// How they act together.
    pub together: Together,
    /// Sum of the members' values, SI: a compliance in series, a stiffness in parallel.
    pub value: f64,
    /// Half width of its 95 % interval; NaN until it is fitted.
    pub ci95: f64,
}

/// A member may differ from a multiple of the kept column by this fraction.
const LEFT_OVER: f64 = 1e-3;

/// Groups among the elastic columns: each dropped column that is a multiple of a single kept one.
pub fn groups(model: &Model, slots: &[Slot], found: &Identifiability) -> Vec<Equivalence> {
    let is_elastic = |column: usize| model.registry[slots[column]].group == Group::Elastic;
    let mut groups: Vec<Equivalence> = Vec::new();
    for &(dropped, _) in found.dropped.iter().filter(|(column, _)| is_elastic(*column)) {
        let terms: Vec<(usize, f64)> = found
            .combinations
            .iter()
            .flat_map(|(keeper, terms)| terms.iter().filter(|t| t.0 == dropped).map(|t| (*keeper, t.1)))
            .collect();
        let Some(&(keeper, factor)) = terms.iter().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs())) else { continue };
        let others = terms.iter().filter(|term| term.0 != keeper).fold(0.0_f64, |m, term| m.max(term.1.abs()));
        if !is_elastic(keeper) || factor <= 0.0 || others > LEFT_OVER * factor || found.remainder[dropped] > LEFT_OVER {
            continue;
        }
        let (slot, kept) = (slots[dropped], slots[keeper]);
        let soft = |slot: Slot| matches!(model.registry[slot].kind, Kind::LinearStiffness | Kind::RotationalStiffness);
        let springs = |slot: Slot| {
            soft(slot) || matches!(model.registry[slot].kind, Kind::LinearCompliance | Kind::RotationalCompliance)
        };
        if !springs(slot) || !springs(kept) || soft(slot) != soft(kept) {
            continue;
        }
        let together = if soft(slot) { Together::Parallel } else { Together::Series };
        match groups.iter_mut().find(|group| group.members[0].0 == kept) {
            Some(group) => group.members.push((slot, factor)),
            None => groups.push(Equivalence {
                members: vec![(kept, 1.0), (slot, factor)],
                together,
                value: 0.0,
                ci95: f64::NAN,
            }),
        }
    }
    groups
}

impl Equivalence {
    /// The equivalent of the members' values.
    pub fn of(&self, values: &[f64]) -> f64 {
        self.members.iter().map(|&(slot, weight)| weight * values[slot]).sum()
    }

    /// Puts values of the members that add up to the equivalent into `values`.
    pub fn split(&self, model: &Model, rule: Split, values: &mut [f64]) {
        let nominal: f64 = self.of(&model.registry.nominal());
        let squares: f64 = self.members.iter().map(|(_, weight)| weight * weight).sum();
        for &(slot, weight) in &self.members {
            values[slot] = match rule {
                Split::Prior if nominal > 0.0 => self.value * model.registry[slot].nominal / nominal,
                _ => self.value * weight / squares,
            };
        }
    }
}

/// Greatest displacement (m) over the readings that each column causes at its parameter's value; `jacobian` is row-major
/// and unweighted.
pub fn moves(campaign: &Campaign, jacobian: &[f64], slots: &[Slot], values: &[f64]) -> Vec<f64> {
    let (components, width) = (campaign.components(), slots.len());
    let mut greatest = vec![0.0_f64; width];
    for reading in jacobian.chunks(components * width.max(1)) {
        for (column, most) in greatest.iter_mut().enumerate() {
            let square: f64 = (0..components.min(3)).map(|k| reading[k * width + column].powi(2)).sum();
            *most = most.max(square.sqrt() * values[slots[column]].abs());
        }
    }
    greatest
}
