//! Autocorrelation of residuals between neighbours, tested by permutation.
//!
//! Independent noise does not correlate between neighbours. For neighbours in configuration, load and time, and for the
//! readings of one configuration, the products of residuals are summed; the share of permutations that reach as much is
//! the probability of chance. Readings of one configuration are permuted together, unless it is they that are tested.
//! Residuals of a fit are slightly negatively correlated, which makes the test a little too cautious.
//!
//! Source: Good, *Permutation, Parametric and Bootstrap Tests of Hypotheses*, 2005, ch. 3; Moran, *Notes on continuous
//! stochastic phenomena*, Biometrika 37, 1950.

use std::collections::BTreeMap;

use nalgebra::DVector;
use rand::seq::SliceRandom;
use rayon::prelude::*;

use super::result::Autocorrelation;
use super::settings::AutocorrelationSettings;
use crate::description::campaign::Campaign;
use crate::math::extremes;
use crate::model::Model;
use crate::simulation::generator;

/// Units whose neighbours are sought, evenly among all: beyond it the test has long been sharp, and its cost would grow with the square
/// of their number.
const MOST_UNITS: usize = 4000;

/// The tests that a campaign allows, on residuals over their sigmas, one after the other as the readings.
pub fn autocorrelation(
    model: &Model,
    campaign: &Campaign,
    residual: &DVector<f64>,
    settings: &AutocorrelationSettings,
    seed: u64,
) -> Vec<Autocorrelation> {
    let residuals = Residuals { model, campaign, residual, settings };
    let tests = [
        ("configuration", residuals.by_configuration()),
        ("load", residuals.by_load()),
        ("time", residuals.by_time()),
        ("within a pose", residuals.within_a_pose()),
    ];
    let found = tests.into_iter().filter_map(|(against, case)| Some((against, case?)));
    found.map(|(against, case)| case.tested(against, settings.permutations, seed)).collect()
}

/// Errors in the order of something that they might follow, all of one length.
pub struct Series(Vec<Vec<f64>>);

impl Series {
    /// `None` of fewer than [`FEWEST`].
    pub fn new(errors: Vec<Vec<f64>>) -> Option<Self> {
        (errors.len() >= FEWEST).then_some(Self(errors))
    }

    /// Sum of squares that neighbours share, and the probability of as much by chance.
    pub fn tested(self, permutations: usize, seed: u64) -> (f64, f64) {
        let count = self.0.len();
        let after = |apart: usize| (0..count).zip(apart..count);
        let pairs = after(1).chain(after(2)).collect();
        let case = Case { units: self.0, pairs, classes: vec![(0..count).collect()] };
        let found = case.tested("", permutations, seed);
        let squares: f64 = case.units.iter().flatten().map(|value| value * value).sum();
        (found.correlation.max(0.0) * squares, found.p)
    }
}

/// Values below which there is too little to permute.
const FEWEST: usize = 8;

/// What is permuted and what is compared.
struct Case {
    /// Residuals of each unit, one vector a unit, all of one length; zero where a unit lacks a reading.
    units: Vec<Vec<f64>>,
    /// Neighbours.
    pairs: Vec<(usize, usize)>,
    /// Units that may be permuted with one another.
    classes: Vec<Vec<usize>>,
}

impl Case {
    fn tested(&self, against: &'static str, permutations: usize, seed: u64) -> Autocorrelation {
        let sum = |at: &[usize]| -> f64 {
            let dot = |(i, j): &(usize, usize)| -> f64 {
                self.units[at[*i]].iter().zip(&self.units[at[*j]]).map(|(a, b)| a * b).sum()
            };
            self.pairs.iter().map(dot).sum()
        };
        let own: Vec<usize> = (0..self.units.len()).collect();
        let observed = sum(&own);
        let as_much = (0..permutations)
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
        Autocorrelation {
            against,
            correlation: observed / self.pairs.len() as f64 / square.max(f64::MIN_POSITIVE),
            p: (1 + as_much) as f64 / (1 + permutations) as f64,
        }
    }
}

/// What the tests are made from.
struct Residuals<'a> {
    model: &'a Model,
    campaign: &'a Campaign,
    residual: &'a DVector<f64>,
    settings: &'a AutocorrelationSettings,
}

impl Residuals<'_> {
    /// Readings in blocks, by configuration and a second index.
    fn blocks(&self, second: impl Fn(usize) -> usize) -> Blocks {
        Blocks::new(self.campaign, self.residual, |index| (self.campaign.readings[index].pose, second(index)))
    }

    fn by_configuration(&self) -> Option<Case> {
        let blocks = self.blocks(|_| 0);
        let distance = distance(self.model, self.campaign);
        let near = |i: usize, j: usize| [distance(blocks.first[i], blocks.first[j]), 0.0];
        let pairs = self.nearest(blocks.units.len(), near, |_, _| true)?;
        let all = (0..blocks.units.len()).collect();
        Some(Case { units: blocks.units, pairs, classes: vec![all] })
    }

    /// Neighbours in load, of these those in configuration. Where one configuration bears several loads it is these that
    /// are permuted: what the configuration alone does to the readings stays where it is.
    fn by_load(&self) -> Option<Case> {
        let readings = &self.campaign.readings;
        let mut loads: Vec<[f64; 6]> = Vec::new();
        let mut load_of = Vec::with_capacity(readings.len());
        for reading in readings {
            let known = loads.iter().position(|load| *load == reading.wrench);
            load_of.push(known.unwrap_or(loads.len()));
            if known.is_none() {
                loads.push(reading.wrench);
            }
        }
        if loads.len() < 2 {
            return None;
        }
        let greatest = |from: usize| loads.iter().flat_map(|w| &w[from..from + 3]).fold(0.0_f64, |g, v| g.max(v.abs()));
        let sizes = [greatest(0), greatest(3)].map(|size| size.max(f64::MIN_POSITIVE));
        let apart = |i: usize, j: usize| -> f64 {
            let (a, b) = (&loads[load_of[i]], &loads[load_of[j]]);
            (0..6).map(|k| ((a[k] - b[k]) / sizes[k / 3]).powi(2)).sum()
        };
        let blocks = self.blocks(|index| load_of[index]);
        let distance = distance(self.model, self.campaign);
        let near = |i: usize, j: usize| {
            let (i, j) = (blocks.first[i], blocks.first[j]);
            [apart(i, j), distance(i, j)]
        };
        let pose = |unit: usize| readings[blocks.first[unit]].pose;
        let pairs = self.nearest(blocks.units.len(), near, |i, j| pose(i) != pose(j))?;
        let mut by_pose: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        (0..blocks.units.len()).for_each(|unit| by_pose.entry(pose(unit)).or_default().push(unit));
        let mut classes: Vec<Vec<usize>> = by_pose.into_values().filter(|units| units.len() > 1).collect();
        if classes.is_empty() {
            classes.push((0..blocks.units.len()).collect());
        } else if classes.len() < self.settings.fewest {
            return None;
        }
        Some(Case { units: blocks.units, pairs, classes })
    }

    fn by_time(&self) -> Option<Case> {
        let times = self.campaign.conditions.time.as_ref()?;
        let blocks = self.blocks(|_| 0);
        let time = |unit: usize| times[blocks.first[unit]];
        let mut order: Vec<usize> = (0..blocks.units.len()).collect();
        if order.len() < self.settings.fewest || order.iter().all(|&unit| time(unit) == time(0)) {
            return None;
        }
        order.sort_by(|&a, &b| time(a).total_cmp(&time(b)));
        let after = |apart: usize| order.iter().copied().zip(order.iter().copied().skip(apart));
        let pairs = after(1).chain(after(2)).collect();
        let all = (0..blocks.units.len()).collect();
        Some(Case { units: blocks.units, pairs, classes: vec![all] })
    }

    /// Readings of one configuration. Deflections of one marker share the reading without load, and are not compared.
    fn within_a_pose(&self) -> Option<Case> {
        let campaign = self.campaign;
        let width = campaign.most_rows();
        let unit = |own: &[f64]| own.iter().copied().chain(std::iter::repeat(0.0)).take(width).collect();
        let units: Vec<Vec<f64>> = campaign.by_reading(self.residual.as_slice(), 1).map(|(_, own)| unit(own)).collect();
        let mut by_pose: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        let mut times: BTreeMap<(usize, Option<usize>), usize> = BTreeMap::new();
        let mut classes: BTreeMap<(Option<usize>, usize), Vec<usize>> = BTreeMap::new();
        for (index, reading) in campaign.readings.iter().enumerate() {
            by_pose.entry(reading.pose).or_default().push(index);
            let time = times.entry((reading.pose, reading.marker)).or_default();
            classes.entry((reading.marker, *time)).or_default().push(index);
            *time += 1;
        }
        if by_pose.len() < self.settings.fewest {
            return None;
        }
        let is_free = |i: usize, j: usize| {
            let [a, b] = [i, j].map(|index| &campaign.readings[index]);
            a.observes == b.observes && a.observes.is_comparable(a.marker == b.marker, a.target == b.target)
        };
        let mut pairs = Vec::new();
        for own in by_pose.values() {
            for (k, &i) in own.iter().enumerate() {
                pairs.extend(own[k + 1..].iter().filter(|&&j| is_free(i, j)).map(|&j| (i, j)));
            }
        }
        let classes: Vec<Vec<usize>> = classes.into_values().collect();
        (pairs.len() >= self.settings.fewest).then_some(Case { units, pairs, classes })
    }

    /// Each unit with the nearest of those that may be compared with it; `None` where there are too few.
    fn nearest(
        &self,
        count: usize,
        near: impl Fn(usize, usize) -> [f64; 2] + Sync,
        may: impl Fn(usize, usize) -> bool + Sync,
    ) -> Option<Vec<(usize, usize)>> {
        let neighbours = self.settings.neighbours;
        if count < self.settings.fewest {
            return None;
        }
        let units: Vec<usize> = (0..count).step_by(count.div_ceil(MOST_UNITS)).collect();
        let pairs: Vec<Vec<(usize, usize)>> = units
            .into_par_iter()
            .map(|i| {
                let others = (0..count).filter(|&j| j != i && may(i, j));
                let mut others: Vec<([f64; 2], usize)> = others.map(|j| (near(i, j), j)).collect();
                let by_distance = |a: &([f64; 2], usize), b: &([f64; 2], usize)| {
                    a.0[0].total_cmp(&b.0[0]).then(a.0[1].total_cmp(&b.0[1])).then(a.1.cmp(&b.1))
                };
                if others.len() > neighbours {
                    others.select_nth_unstable_by(neighbours, by_distance);
                    others.truncate(neighbours);
                }
                // Not collected in place, which would keep the room of all others.
                let mut pairs = Vec::with_capacity(others.len());
                pairs.extend(others.into_iter().map(|(_, j)| (i, j)));
                pairs
            })
            .collect();
        Some(pairs.concat()).filter(|pairs| !pairs.is_empty())
    }
}

/// Readings in blocks that are permuted together: the residuals of each block in one vector, by marker and repetition.
struct Blocks {
    units: Vec<Vec<f64>>,
    /// First reading of each block.
    first: Vec<usize>,
}

impl Blocks {
    fn new(campaign: &Campaign, residual: &DVector<f64>, of: impl Fn(usize) -> (usize, usize)) -> Self {
        let width = campaign.most_rows();
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
        let mut units = vec![vec![0.0; places.len() * width]; first.len()];
        for ((block, place), (_, own)) in at.into_iter().zip(campaign.by_reading(residual.as_slice(), 1)) {
            units[block][place * width..][..own.len()].copy_from_slice(own);
        }
        Self { units, first }
    }
}

/// Squared distance of the configurations of two readings, each variable over its range in the campaign; angles by the
/// shorter way round.
fn distance<'a>(model: &'a Model, campaign: &'a Campaign) -> impl Fn(usize, usize) -> f64 + Sync + 'a {
    let ends: Vec<f64> = (0..campaign.variables)
        .map(|k| {
            let [low, high] = extremes((0..campaign.readings.len()).map(|i| campaign.configuration(i)[k]));
            high - low
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
