//! Structure left in what the best explanation leaves: whether neighbours err alike, tested by permutation.
//!
//! Noise does not know its neighbours. For neighbours in configuration, load and time, and for the readings of one
//! configuration, the residuals' products are summed; how often exchanged residuals give as much is the probability of
//! chance (Good, Permutation, Parametric and Bootstrap Tests, 2005). Readings of one configuration are exchanged together,
//! as far as it is not they that are tested. Residuals of a fit are slightly opposed to each other, which makes the test
//! a little too cautious.

use std::collections::BTreeMap;

use nalgebra::DVector;
use rand::seq::SliceRandom;
use rayon::prelude::*;

use super::algebra::{orthonormal, rest};
use super::evidence::Evidence;
use super::figures::design;
use super::report::Verdict;
use crate::description::campaign::Campaign;
use crate::model::Model;
use crate::simulation::generator;

/// Exchanges that are drawn.
const EXCHANGES: usize = 999;
/// Neighbours of each.
const NEIGHBOURS: usize = 5;
/// With fewer there is nothing to exchange.
const FEWEST: usize = 8;
/// Probability of chance, over all tests, below which there is structure.
const CHANCE: f64 = 0.01;

/// One test.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Structure {
    /// Neighbours in what: `configuration`, `load`, `time`, or `within a pose`.
    pub against: &'static str,
    /// Correlation of neighbours' residuals.
    pub correlation: f64,
    /// Probability of as much by chance.
    pub p: f64,
}

/// The tests that a campaign allows, on what nuisance and members leave.
pub fn structure(
    model: &Model,
    campaign: &Campaign,
    evidence: &Evidence,
    members: &[usize],
    seed: u64,
) -> Vec<Structure> {
    let left = rest(&evidence.residual, &orthonormal(&design(evidence, members), None));
    structure_in(model, campaign, &left, seed)
}

/// The same on residuals (over their sigmas, one after the other as the readings).
pub fn structure_in(model: &Model, campaign: &Campaign, left: &DVector<f64>, seed: u64) -> Vec<Structure> {
    let tests = [in_configuration, in_load, in_time, within_a_pose];
    let found = tests.iter().filter_map(|test| test(model, campaign, left));
    found.map(|(against, case)| case.tested(against, seed)).collect()
}

/// The verdict where no noise is stated: what has structure is not explained.
pub fn judged(verdict: Verdict, found: &[Structure]) -> Verdict {
    let is_structured = found.iter().any(|test| test.p < CHANCE / found.len() as f64);
    match verdict {
        Verdict::NoGap if is_structured => Verdict::Unexplained,
        Verdict::Explained if is_structured => Verdict::PartlyExplained,
        other => other,
    }
}

/// What is exchanged and what is compared.
struct Case {
    /// Residuals of each unit, one vector a unit, all of one length; zero where a unit lacks a reading.
    units: Vec<Vec<f64>>,
    /// Neighbours.
    pairs: Vec<(usize, usize)>,
    /// Units that may be exchanged with one another.
    classes: Vec<Vec<usize>>,
}

impl Case {
    fn tested(&self, against: &'static str, seed: u64) -> Structure {
        let sum = |at: &[usize]| -> f64 {
            let dot = |(i, j): &(usize, usize)| -> f64 {
                self.units[at[*i]].iter().zip(&self.units[at[*j]]).map(|(a, b)| a * b).sum()
            };
            self.pairs.iter().map(dot).sum()
        };
        let own: Vec<usize> = (0..self.units.len()).collect();
        let observed = sum(&own);
        let as_much = (0..EXCHANGES)
            .into_par_iter()
            .filter(|&index| {
                let mut random = generator(seed.wrapping_mul(1_000_003).wrapping_add(index as u64));
                let mut at = own.clone();
                for class in &self.classes {
                    let mut mixed = class.clone();
                    mixed.shuffle(&mut random);
                    class.iter().zip(mixed).for_each(|(&unit, other)| at[unit] = other);
                }
                sum(&at) >= observed
            })
            .count();
        let square: f64 = self.units.iter().flatten().map(|v| v * v).sum::<f64>() / self.units.len() as f64;
        Structure {
            against,
            correlation: observed / self.pairs.len() as f64 / square.max(f64::MIN_POSITIVE),
            p: (1 + as_much) as f64 / (1 + EXCHANGES) as f64,
        }
    }
}

type Test = Option<(&'static str, Case)>;

fn in_configuration(model: &Model, campaign: &Campaign, left: &DVector<f64>) -> Test {
    let blocks = Blocks::new(campaign, left, |index| (campaign.readings[index].pose, 0));
    let distance = distance(model, campaign);
    let near = |i: usize, j: usize| [distance(blocks.first[i], blocks.first[j]), 0.0];
    let pairs = nearest(blocks.units.len(), near, |_, _| true)?;
    let all = (0..blocks.units.len()).collect();
    Some(("configuration", Case { units: blocks.units, pairs, classes: vec![all] }))
}

/// Neighbours in load, of these those in configuration. Where one configuration bears several loads it is these that are
/// exchanged: what the configuration alone does to the readings stays where it is.
fn in_load(model: &Model, campaign: &Campaign, left: &DVector<f64>) -> Test {
    let mut loads: Vec<[f64; 6]> = Vec::new();
    let load_of: Vec<usize> = campaign
        .readings
        .iter()
        .map(|reading| match loads.iter().position(|load| *load == reading.wrench) {
            Some(known) => known,
            None => {
                loads.push(reading.wrench);
                loads.len() - 1
            }
        })
        .collect();
    if loads.len() < 2 {
        return None;
    }
    let greatest = |from: usize| loads.iter().flat_map(|w| &w[from..from + 3]).fold(0.0_f64, |g, v| g.max(v.abs()));
    let sizes = [greatest(0), greatest(3)].map(|size| size.max(f64::MIN_POSITIVE));
    let apart = |i: usize, j: usize| -> f64 {
        let (a, b) = (&loads[load_of[i]], &loads[load_of[j]]);
        (0..6).map(|k| ((a[k] - b[k]) / sizes[k / 3]).powi(2)).sum()
    };
    let blocks = Blocks::new(campaign, left, |index| (campaign.readings[index].pose, load_of[index]));
    let distance = distance(model, campaign);
    let near = |i: usize, j: usize| {
        let (i, j) = (blocks.first[i], blocks.first[j]);
        [apart(i, j), distance(i, j)]
    };
    let pose = |unit: usize| campaign.readings[blocks.first[unit]].pose;
    let pairs = nearest(blocks.units.len(), near, |i, j| pose(i) != pose(j))?;
    let mut by_pose: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    (0..blocks.units.len()).for_each(|unit| by_pose.entry(pose(unit)).or_default().push(unit));
    let mut classes: Vec<Vec<usize>> = by_pose.into_values().filter(|units| units.len() > 1).collect();
    if classes.is_empty() {
        classes.push((0..blocks.units.len()).collect());
    } else if classes.len() < FEWEST {
        return None;
    }
    Some(("load", Case { units: blocks.units, pairs, classes }))
}

fn in_time(_model: &Model, campaign: &Campaign, left: &DVector<f64>) -> Test {
    let times = campaign.conditions.get("time")?;
    let blocks = Blocks::new(campaign, left, |index| (campaign.readings[index].pose, 0));
    let time = |unit: usize| times[blocks.first[unit]];
    let mut order: Vec<usize> = (0..blocks.units.len()).collect();
    if order.len() < FEWEST || order.iter().all(|&unit| time(unit) == time(0)) {
        return None;
    }
    order.sort_by(|&a, &b| time(a).total_cmp(&time(b)));
    let after = |apart: usize| order.iter().copied().zip(order.iter().copied().skip(apart));
    let pairs = after(1).chain(after(2)).collect();
    let all = (0..blocks.units.len()).collect();
    Some(("time", Case { units: blocks.units, pairs, classes: vec![all] }))
}

/// Readings of one configuration. Deflections of one marker share the reading without load, and are not compared.
fn within_a_pose(_model: &Model, campaign: &Campaign, left: &DVector<f64>) -> Test {
    let components = campaign.components();
    let units: Vec<Vec<f64>> = left.as_slice().chunks(components).map(<[f64]>::to_vec).collect();
    let mut by_pose: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    let mut times: BTreeMap<(usize, Option<usize>), usize> = BTreeMap::new();
    let mut classes: BTreeMap<(Option<usize>, usize), Vec<usize>> = BTreeMap::new();
    for (index, reading) in campaign.readings.iter().enumerate() {
        by_pose.entry(reading.pose).or_default().push(index);
        let time = times.entry((reading.pose, reading.marker)).or_default();
        classes.entry((reading.marker, *time)).or_default().push(index);
        *time += 1;
    }
    if by_pose.len() < FEWEST {
        return None;
    }
    let is_free = |i: usize, j: usize| {
        let [a, b] = [i, j].map(|index| &campaign.readings[index]);
        campaign.observes.is_comparable(a.marker == b.marker, a.anchor == b.anchor)
    };
    let mut pairs = Vec::new();
    for own in by_pose.values() {
        for (k, &i) in own.iter().enumerate() {
            pairs.extend(own[k + 1..].iter().filter(|&&j| is_free(i, j)).map(|&j| (i, j)));
        }
    }
    let classes: Vec<Vec<usize>> = classes.into_values().collect();
    (pairs.len() >= FEWEST).then_some(("within a pose", Case { units, pairs, classes }))
}

/// Readings in blocks that are exchanged together: each block's residuals side by side, by marker and turn.
struct Blocks {
    units: Vec<Vec<f64>>,
    /// First reading of each block.
    first: Vec<usize>,
}

impl Blocks {
    fn new(campaign: &Campaign, left: &DVector<f64>, of: impl Fn(usize) -> (usize, usize)) -> Self {
        let components = campaign.components();
        let mut block_of: BTreeMap<(usize, usize), usize> = BTreeMap::new();
        let mut places: BTreeMap<(Option<usize>, usize), usize> = BTreeMap::new();
        let mut turns: BTreeMap<(usize, Option<usize>), usize> = BTreeMap::new();
        let mut first = Vec::new();
        // Block and place in it of every reading.
        let at: Vec<(usize, usize)> = (0..campaign.readings.len())
            .map(|index| {
                let marker = campaign.readings[index].marker;
                let block = *block_of.entry(of(index)).or_insert_with(|| {
                    first.push(index);
                    first.len() - 1
                });
                let turn = turns.entry((block, marker)).or_default();
                let next = places.len();
                let place = *places.entry((marker, *turn)).or_insert(next);
                *turn += 1;
                (block, place)
            })
            .collect();
        let mut units = vec![vec![0.0; places.len() * components]; first.len()];
        for ((block, place), own) in at.into_iter().zip(left.as_slice().chunks(components)) {
            units[block][place * components..][..components].copy_from_slice(own);
        }
        Self { units, first }
    }
}

/// Squared distance of the configurations of two readings, each variable over its range in the campaign; angles by the
/// shorter way round.
fn distance<'a>(model: &'a Model, campaign: &'a Campaign) -> impl Fn(usize, usize) -> f64 + Sync + 'a {
    let ends: Vec<f64> = (0..campaign.variables)
        .map(|k| {
            let values = || (0..campaign.readings.len()).map(|i| campaign.configuration(i)[k]);
            values().fold(f64::NEG_INFINITY, f64::max) - values().fold(f64::INFINITY, f64::min)
        })
        .collect();
    move |i, j| {
        let (a, b) = (campaign.configuration(i), campaign.configuration(j));
        (0..campaign.variables)
            .filter(|&k| ends[k] > 0.0)
            .map(|k| {
                let straight = (a[k] - b[k]).abs();
                let is_angle = model.variables.get(k).is_some_and(|variable| variable.is_angle);
                let round = if is_angle { (std::f64::consts::TAU - straight).abs() } else { straight };
                (straight.min(round) / ends[k]).powi(2)
            })
            .sum()
    }
}

/// Each unit with the nearest of those that may be compared with it; none where there are too few.
fn nearest(
    count: usize,
    near: impl Fn(usize, usize) -> [f64; 2] + Sync,
    may: impl Fn(usize, usize) -> bool + Sync,
) -> Option<Vec<(usize, usize)>> {
    if count < FEWEST {
        return None;
    }
    let pairs: Vec<Vec<(usize, usize)>> = (0..count)
        .into_par_iter()
        .map(|i| {
            let others = (0..count).filter(|&j| j != i && may(i, j));
            let mut others: Vec<([f64; 2], usize)> = others.map(|j| (near(i, j), j)).collect();
            let by_distance = |a: &([f64; 2], usize), b: &([f64; 2], usize)| {
                a.0[0].total_cmp(&b.0[0]).then(a.0[1].total_cmp(&b.0[1])).then(a.1.cmp(&b.1))
            };
            if others.len() > NEIGHBOURS {
                others.select_nth_unstable_by(NEIGHBOURS, by_distance);
                others.truncate(NEIGHBOURS);
            }
            others.into_iter().map(|(_, j)| (i, j)).collect()
        })
        .collect();
    Some(pairs.concat()).filter(|pairs| !pairs.is_empty())
}
