//! Springs that a campaign cannot separate: in series they act as one of compliance sum c_i, in parallel as one of
//! stiffness sum k_i (eq. (68), (69) of the IR663 calibration paper).
//!
//! In series the columns of the members keep their ratio whatever the members' values are. In parallel they do not: a
//! stiffness k shows as 1, a compliance c as -1/c^2, so that one whose value is changed separates the two. Three or more may
//! be groups within each other ([`Network`]).

use super::bounds;
use super::network::{CHANGED, Network, Together};
use crate::description::campaign::Campaign;
use crate::identifiability::Identifiability;
use crate::model::Model;
use crate::parameter::{Group, Slot};
use crate::prediction::{PredictionError, Predictor};

/// By which rule an equivalent is split back into its members.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Split {
    /// In proportion to the values of the description.
    #[default]
    Prior,
    /// The smallest sum of squared compliances (in parallel, of stiffnesses) that adds up to it.
    MinimumNorm,
}

/// Springs that act as one.
#[derive(Debug, Clone, PartialEq)]
pub struct SpringGroup {
    /// The kept one first, then those merged into it, with their weights in the sum (1 for plain series).
    pub members: Vec<(Slot, f64)>,
    /// How they act together; of a network within which groups lie in groups, its outermost connection.
    pub together: Together,
    /// Such a network. The weights of `members` are 1 then.
    pub nested: Option<Network>,
}

/// A fitted group of springs.
#[derive(Debug, Clone, PartialEq)]
pub struct Equivalence {
    /// The springs.
    pub springs: SpringGroup,
    /// Sum of the members, SI: of compliances in series, of stiffnesses in parallel.
    pub value: f64,
    /// Half width of its 95 % interval, in the same unit.
    pub ci95: f64,
}

/// A member's column may differ from a multiple of the kept one by this fraction. Springs that act as one agree to rounding
/// (1e-9); the nearest that do not, on the bundled robots, differ by some per cent.
const LEFT_OVER: f64 = 1e-3;
/// A compliance that is to carry nothing parallel to others is this many times softer than all of them: their sum then
/// changes by a part that no campaign sees.
const SOFT: f64 = 1e6;

fn is_stiffness(model: &Model, slot: Slot) -> bool {
    model.registry[slot].kind.is_stiffness()
}

/// Groups among the elastic columns at `values`: each dropped column that is a multiple of a single kept one.
///
/// # Errors
/// Readings that cannot be predicted at changed values.
pub fn groups(
    predictor: &Predictor,
    values: &[f64],
    found: &Identifiability,
) -> Result<Vec<SpringGroup>, PredictionError> {
    let (model, slots) = (predictor.model, &predictor.slots);
    // Springs of which readings see one, whether or not these add up plainly.
    let mut alike: Vec<Vec<usize>> = Vec::new();
    let is_elastic = |column: usize| model.registry[slots[column]].group == Group::Elastic;
    let mut groups: Vec<SpringGroup> = Vec::new();
    for &(dropped, _) in found.dropped.iter().filter(|(column, _)| is_elastic(*column)) {
        let terms: Vec<(usize, f64)> = found
            .combinations
            .iter()
            .flat_map(|(keeper, terms)| terms.iter().filter(|t| t.0 == dropped).map(|t| (*keeper, t.1)))
            .collect();
        let Some(&(keeper, factor)) = terms.iter().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs())) else { continue };
        let others = terms.iter().filter(|term| term.0 != keeper).fold(0.0_f64, |m, term| m.max(term.1.abs()));
        if !is_elastic(keeper) || others > LEFT_OVER * factor.abs() || found.remainder[dropped] > LEFT_OVER {
            continue;
        }
        let (slot, kept) = (slots[dropped], slots[keeper]);
        if ![slot, kept].into_iter().all(|slot| model.registry[slot].kind.is_spring()) {
            continue;
        }
        match alike.iter_mut().find(|columns| columns[0] == keeper) {
            Some(columns) => columns.push(dropped),
            None => alike.push(vec![keeper, dropped]),
        }
        let stiffness = [kept, slot].map(|slot| is_stiffness(model, slot));
        let together = match stiffness {
            [false, false] if !ratio_follows(predictor, values, [keeper, dropped], factor)? => Together::Series,
            _ => Together::Parallel,
        };
        let adds = |slot: Slot| if is_stiffness(model, slot) { 1.0 } else { -values[slot].powi(-2) };
        let weight = match together {
            Together::Series => factor,
            // By how much each adds to the sum of stiffnesses.
            Together::Parallel => factor * adds(kept) / adds(slot),
        };
        if !(weight > 0.0 && weight.is_finite()) {
            continue;
        }
        match groups.iter_mut().find(|group| group.members[0].0 == kept) {
            // One that is in series with some and parallel to others is no plain sum.
            Some(group) if group.together != together => {}
            Some(group) => group.members.push((slot, weight)),
            None => groups.push(SpringGroup { members: vec![(kept, 1.0), (slot, weight)], together, nested: None }),
        }
    }
    for columns in alike.into_iter().filter(|columns| columns.len() > 2) {
        let Some(network) = network(predictor, values, &columns)?.filter(Network::is_nested) else { continue };
        let members: Vec<(Slot, f64)> = columns.iter().map(|column| (slots[*column], 1.0)).collect();
        groups.retain(|group| group.members[0].0 != members[0].0);
        let together = if let Network::Group(together, _) = &network { *together } else { Together::Series };
        groups.push(SpringGroup { members, together, nested: Some(network) });
    }
    Ok(groups)
}

/// The network that springs with columns in proportion make up, if it is one of series and parallel connections.
fn network(predictor: &Predictor, values: &[f64], columns: &[usize]) -> Result<Option<Network>, PredictionError> {
    let (model, slots) = (predictor.model, &predictor.slots);
    let springs: Vec<Slot> = columns.iter().map(|column| slots[*column]).collect();
    let compliance = |slot: Slot| compliance(model, slot, values[slot]);
    if !springs.iter().all(|slot| compliance(*slot) > 0.0 && compliance(*slot).is_finite()) {
        return Ok(None);
    }
    let parts = |changed: &[Slot]| -> Result<Vec<f64>, PredictionError> {
        let mut values = values.to_vec();
        changed
            .iter()
            .for_each(|&slot| values[slot] *= if is_stiffness(model, slot) { CHANGED.recip() } else { CHANGED });
        let found = predictor.linearised(&values)?;
        // In proportion to the first column, and by compliance.
        let width = slots.len();
        let along = |column: usize| -> f64 {
            found.jacobian.chunks(width).map(|row| row[columns[0]] * row[column]).sum::<f64>()
        };
        let by_compliance = |slot: Slot| if is_stiffness(model, slot) { -values[slot] * values[slot] } else { 1.0 };
        Ok(columns.iter().map(|&column| along(column) * by_compliance(slots[column])).collect())
    };
    Network::of(&springs, &compliance, parts)
}

/// A value of a spring as a compliance, and the reverse.
fn compliance(model: &Model, slot: Slot, value: f64) -> f64 {
    if is_stiffness(model, slot) { value.recip() } else { value }
}

/// Whether the ratio of two compliances' columns, `factor`, changes with the second one's value as it does in parallel.
fn ratio_follows(
    predictor: &Predictor,
    values: &[f64],
    [keeper, dropped]: [usize; 2],
    factor: f64,
) -> Result<bool, PredictionError> {
    let mut changed = values.to_vec();
    changed[predictor.slots[dropped]] *= CHANGED;
    let found = predictor.linearised(&changed)?;
    let (mut across, mut square) = (0.0, 0.0);
    for row in found.jacobian.chunks(predictor.slots.len()) {
        across += row[keeper] * row[dropped];
        square += row[keeper] * row[keeper];
    }
    // In series the ratio stays; in parallel it falls by the square of the change. The nearer of the two, by logarithm.
    Ok(square > 0.0 && across / square < factor / CHANGED)
}

impl SpringGroup {
    /// What a member adds to the sum at a value of it, without its weight; and the inverse of that map.
    fn part(&self, model: &Model, slot: Slot, value: f64) -> f64 {
        if self.together == Together::Parallel && !is_stiffness(model, slot) { 1.0 / value } else { value }
    }

    /// The equivalent of the members' values.
    pub fn of(&self, model: &Model, values: &[f64]) -> f64 {
        if let Some(network) = &self.nested {
            return self.shown(network.compliance(&|slot| compliance(model, slot, values[slot])));
        }
        self.members.iter().map(|&(slot, weight)| weight * self.part(model, slot, values[slot])).sum()
    }

    /// A compliance of the whole as its value is given.
    fn shown(&self, compliance: f64) -> f64 {
        if self.together == Together::Parallel { compliance.recip() } else { compliance }
    }

    /// As [`SpringGroup::gather`], of a network: what is in series with the kept member is made rigid.
    fn gather_network(&self, network: &Network, model: &Model, values: &mut [f64]) -> [f64; 2] {
        let kept = self.members[0].0;
        let whole = network.compliance(&|slot| compliance(model, slot, values[slot]));
        let end = |end: usize| {
            network.compliance(&|slot| {
                let ends = bounds::bounds(model, slot).map(|value| compliance(model, slot, value.max(0.0)));
                if end == 0 { ends[0].min(ends[1]) } else { ends[0].max(ends[1]) }
            })
        };
        let (rigid, loose, times) = network.alone(kept);
        let limits = [end(0) / times, end(1) / times];
        for (slots, own) in [(rigid, 0.0), (loose, whole * SOFT)] {
            for slot in slots {
                values[slot] = match is_stiffness(model, slot) {
                    true => compliance(model, slot, own.max(whole / SOFT)),
                    false => own,
                };
            }
        }
        values[kept] = compliance(model, kept, whole / times);
        let ends = limits.map(|limit| compliance(model, kept, limit));
        if ends[0] <= ends[1] { ends } else { [ends[1], ends[0]] }
    }

    /// As [`SpringGroup::fitted`], of a network: its members are split in proportion to the description.
    fn fitted_network(self, network: &Network, model: &Model, ci95: f64, values: &mut [f64]) -> Equivalence {
        let kept = self.members[0].0;
        let at = |values: &[f64]| network.compliance(&|slot| compliance(model, slot, values[slot]));
        let whole = at(values).max(0.0);
        let by = network.derivative(&|slot| compliance(model, slot, values[slot]), kept);
        let by = if is_stiffness(model, kept) { by / values[kept].powi(2) } else { by };
        let width = if self.together == Together::Parallel { ci95 * by / (whole * whole) } else { ci95 * by };
        let declared = model.registry.nominal();
        let times = whole / at(&declared);
        if times > 0.0 && times.is_finite() {
            for (slot, _) in &self.members {
                values[*slot] = compliance(model, *slot, times * compliance(model, *slot, declared[*slot]));
            }
        }
        Equivalence { value: self.shown(whole), ci95: width, springs: self }
    }

    /// Its stiffness as a formula of those of its members, by their names.
    pub fn formula(&self, model: &Model) -> String {
        let part = |&(slot, weight): &(Slot, f64)| (weight, Network::Spring(slot));
        let plain = || Network::Group(self.together, self.members.iter().map(part).collect());
        self.nested.clone().unwrap_or_else(plain).formula(&|slot| model.registry[slot].name.clone())
    }

    /// Lets the kept member alone stand for the group in a fit: in parallel the others are taken out of `values` as far
    /// as they can be. Returns the bounds of the kept one by which the sum, not it alone, is bounded.
    pub fn gather(&self, model: &Model, values: &mut [f64]) -> [f64; 2] {
        if let Some(network) = &self.nested {
            return self.gather_network(network, model, values);
        }
        let (kept, others) = (self.members[0].0, &self.members[1..]);
        let bounds = |slot: Slot| {
            let [low, high] = bounds::bounds(model, slot);
            let ends = [self.part(model, slot, low), self.part(model, slot, high)];
            if ends[0] <= ends[1] { ends } else { [ends[1], ends[0]] }
        };
        let sum = self.of(model, values);
        if self.together == Together::Parallel {
            for &(slot, weight) in others {
                let least = if is_stiffness(model, slot) { 0.0 } else { sum / weight / SOFT };
                values[slot] = self.part(model, slot, least.max(bounds(slot)[0]));
            }
        }
        let constant: f64 = others.iter().map(|&(slot, weight)| weight * self.part(model, slot, values[slot])).sum();
        let total = |end: usize| self.members.iter().map(|&(slot, weight)| weight * bounds(slot)[end]).sum::<f64>();
        let ends = [total(0) - constant, total(1) - constant];
        let own = (sum - constant).clamp(ends[0], ends[1].max(ends[0]));
        values[kept] = self.part(model, kept, own);
        if self.together == Together::Parallel && !is_stiffness(model, kept) {
            [1.0 / ends[1], if ends[0] > 0.0 { 1.0 / ends[0] } else { f64::INFINITY }]
        } else {
            ends
        }
    }

    /// The equivalent of fitted values, with the interval of the kept member (half width `ci95`), and into `values` those of
    /// the members that add up to it.
    pub fn fitted(self, model: &Model, ci95: f64, rule: Split, values: &mut [f64]) -> Equivalence {
        if let Some(network) = self.nested.clone() {
            return self.fitted_network(&network, model, ci95, values);
        }
        let kept = self.members[0].0;
        let value = self.of(model, values).max(0.0);
        let inverted = self.together == Together::Parallel && !is_stiffness(model, kept);
        let ci95 = if inverted { ci95 / values[kept].powi(2) } else { ci95 };
        let declared = model.registry.nominal();
        let nominal = self.of(model, &declared);
        let squares: f64 = self.members.iter().map(|(_, weight)| weight * weight).sum();
        for &(slot, weight) in &self.members {
            let part = match rule {
                Split::Prior if nominal > 0.0 && nominal.is_finite() => {
                    value * self.part(model, slot, declared[slot]) / nominal
                }
                _ => value * weight / squares,
            };
            values[slot] = self.part(model, slot, part);
        }
        Equivalence { springs: self, value, ci95 }
    }
}

/// Greatest displacement (m) over the readings that each column causes at its parameter's value; a rotation counts as the
/// displacement that is as many times its noise. `jacobian` is row-major and unweighted.
pub fn moves(campaign: &Campaign, jacobian: &[f64], slots: &[Slot], values: &[f64]) -> Vec<f64> {
    let width = slots.len();
    let mut greatest = vec![0.0_f64; width];
    for (of, reading) in campaign.by_reading(jacobian, width) {
        let (lengths, rows) = (of.observes.length_rows().min(3), of.observes.rows());
        let angles = if of.observes.by_variable().is_none() { lengths..rows } else { 0..0 };
        let arm = of.noise.position[0] / of.noise.orientation;
        for (column, most) in greatest.iter_mut().enumerate() {
            let norm =
                |rows: std::ops::Range<usize>| rows.map(|k| reading[k * width + column].powi(2)).sum::<f64>().sqrt();
            let moved = norm(0..lengths).max(arm * norm(angles.clone()));
            *most = most.max(moved * values[slots[column]].abs());
        }
    }
    greatest
}
