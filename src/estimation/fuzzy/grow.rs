//! Structure: sets are added to the inputs of each component one at a time, until the test error stops falling.

use rayon::prelude::*;

use super::Placement;
use super::modes::place;
use super::rules::{Group, Partition, rms, rules, split};
use super::samples::Samples;
use crate::estimation::CalibrationError;
use crate::fuzzy::firing;

/// Least part by which another set must lower the test error of its displacement component.
const WORTH: f64 = 0.01;
/// Firing strength, summed over the fitted readings, below which a rule has seen no data.
const SEEN: f64 = 0.5;

/// A structure that was tried and taken.
#[derive(Debug, Clone, PartialEq)]
pub struct Step {
    /// Displacement component (0 to 2: x, y, z).
    pub axis: usize,
    /// Load components (0 to 5) that act together in some readings, and are fitted together.
    pub columns: Vec<usize>,
    /// The one of them that got a set; none at the beginning.
    pub column: Option<usize>,
    /// Sets of each input, of that one; one each at the beginning, none where there are no rules yet.
    pub sets: Vec<usize>,
    /// Root mean square error of the displacement component under these loads, m: of fitted and of test readings.
    pub errors: [f64; 2],
}

/// Rules of one component of the compliance.
#[derive(Debug, Clone, PartialEq)]
pub struct SubModel {
    /// Displacement component (x, y, z) and load component.
    pub at: [usize; 2],
    /// Modal values by offered input, rad or m; one where the input has no say.
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
    /// Readings set aside whose inputs are outside that range.
    pub beyond: usize,
    /// How the structure grew.
    pub steps: Vec<Step>,
}

impl Grown {
    /// Which of the offered inputs have a say.
    pub fn used(&self) -> Vec<usize> {
        (0..self.range.len()).filter(|&k| self.components.iter().any(|c| c.modes[k].len() > 1)).collect()
    }

    /// Partitions of a group, by load component.
    pub(super) fn partitions(&self, group: &Group) -> Vec<Partition> {
        let of = |&column: &usize| self.components.iter().find(|c| c.at == [group.axis, column]);
        group.columns.iter().filter_map(of).map(|component| component.modes.clone()).collect()
    }
}

/// Grows rules. `correction` says that none at all are allowed too: the error without is told first.
pub fn grow(
    samples: &Samples,
    placement: Placement,
    correction: bool,
    taken: &(dyn Fn(&Step) + Sync),
) -> Result<Grown, CalibrationError> {
    if samples.columns.is_empty() {
        return Err(CalibrationError::Malformed("no fitted reading is loaded".into()));
    }
    let groups = Group::all(samples);
    let grown: Vec<(Vec<Partition>, Vec<Step>)> =
        groups.par_iter().map(|group| grow_group(group, placement, correction, taken)).collect();
    let mut components = Vec::new();
    let mut steps = Vec::new();
    for (group, (parts, own)) in groups.iter().zip(grown) {
        let conclusions = split(&parts, &group.solve_bounded(&parts, &group.fitted));
        for ((modes, conclusions), &column) in parts.into_iter().zip(conclusions).zip(&group.columns) {
            let mut support = vec![0.0; conclusions.len()];
            for &k in group.fitted.iter().filter(|&&k| samples.load[k][column] != 0.0) {
                firing(&modes, &samples.x[k], &mut |rule, weight| support[rule] += weight);
            }
            let unseen = (0..support.len()).filter(|&rule| support[rule] < SEEN).collect();
            components.push(SubModel { at: [group.axis, column], modes, conclusions, support, unseen });
        }
        steps.extend(own);
    }
    components.sort_by_key(|component| component.at);
    let outside = |&&k: &&usize| samples.x[k].iter().zip(&samples.range).any(|(x, [low, high])| x < low || x > high);
    let beyond = samples.indices(true, |_| true).iter().filter(outside).count();
    Ok(Grown { components, range: samples.range.clone(), beyond, steps })
}

/// Partitions of a group by load component, and how they grew.
fn grow_group(
    group: &Group,
    placement: Placement,
    correction: bool,
    taken: &(dyn Fn(&Step) + Sync),
) -> (Vec<Partition>, Vec<Step>) {
    let (samples, fitted, test) = (group.samples, &group.fitted, &group.test);
    // Errors of fitted and of test readings, and the one foretold for others by generalised cross-validation, which
    // stands for the test error where there is no test set.
    let errors = |parts: &[Partition]| {
        let b = group.solve(parts, fitted);
        let own = rms(&group.left(parts, &b, fitted));
        let freedom = 1.0 - b.len() as f64 / fitted.len() as f64;
        let foretold = own / freedom.max(1e-3);
        let unseen = if test.is_empty() { foretold } else { rms(&group.left(parts, &b, test)) };
        ([own, unseen], foretold)
    };
    let constant: Partition = samples.range.iter().map(|[low, high]| vec![0.5 * (low + high)]).collect();
    let mut parts = vec![constant; group.columns.len()];
    let (mut best, mut foretold) = errors(&parts);
    let mut steps = Vec::new();
    let mut take = |column: Option<usize>, sets: Vec<usize>, errors: [f64; 2]| {
        let step = Step { axis: group.axis, columns: group.columns.clone(), column, sets, errors };
        taken(&step);
        steps.push(step);
    };
    if correction {
        let of = if test.is_empty() { fitted } else { test };
        let nothing: Vec<f64> = of.iter().map(|&k| samples.d[k][group.axis]).collect();
        take(None, vec![0; samples.range.len()], [f64::NAN, rms(&nothing)]);
    }
    take(None, vec![1; samples.range.len()], best);
    let changing: Vec<usize> = (0..samples.range.len())
        .filter(|&input| {
            let [low, high] = samples.range[input];
            high - low > 1e-9 * (1.0 + low.abs())
        })
        .collect();
    let inputs = || changing.iter().copied();
    let single: Vec<Vec<usize>> = inputs().map(|input| vec![input]).collect();
    let pairs: Vec<Vec<usize>> = inputs()
        .flat_map(|one| inputs().filter(move |other| *other >= one).map(move |other| vec![one, other]))
        .collect();
    loop {
        // A set in one input alone may not help where one in each of two does.
        let better = [&single, &pairs].into_iter().find_map(|more| {
            let trials: Vec<(usize, &Vec<usize>)> =
                (0..parts.len()).flat_map(|j| more.iter().map(move |inputs| (j, inputs))).collect();
            let tried = trials.into_par_iter().filter_map(|(j, inputs)| {
                let starts = [false, true].map(|evenly| {
                    inputs.iter().fold(parts[j].clone(), |mut start, &input| {
                        start[input] = widened(&start[input], samples.range[input], evenly);
                        start
                    })
                });
                if 2 * (rules(&starts[0]) + rest(&parts, j)) > fitted.len() {
                    return None;
                }
                let mut trial = parts.clone();
                trial[j] = place(group, &parts, j, &starts, placement);
                let (found, other) = errors(&trial);
                // A small test set also falls by chance.
                (found[1] < (1.0 - WORTH) * best[1] && other < foretold).then_some((j, trial, found, other))
            });
            let tried: Vec<(usize, Vec<Partition>, [f64; 2], f64)> = tried.collect();
            tried.into_iter().min_by(|a, b| a.2[1].total_cmp(&b.2[1]))
        });
        let Some((j, trial, found, other)) = better else { return (parts, steps) };
        (parts, best, foretold) = (trial, found, other);
        take(Some(group.columns[j]), parts[j].iter().map(Vec::len).collect(), best);
    }
}

/// Rules of all partitions but one.
fn rest(parts: &[Partition], but: usize) -> usize {
    parts.iter().enumerate().filter(|(j, _)| *j != but).map(|(_, modes)| rules(modes)).sum()
}

/// One set more: in the middle of the widest gap, or all spread evenly. Both ends of the range first.
fn widened(modes: &[f64], [low, high]: [f64; 2], evenly: bool) -> Vec<f64> {
    let widest = (1..modes.len()).max_by(|&a, &b| (modes[a] - modes[a - 1]).total_cmp(&(modes[b] - modes[b - 1])));
    match widest {
        Some(k) if !evenly => {
            let mut more = modes.to_vec();
            more.insert(k, 0.5 * (modes[k - 1] + modes[k]));
            more
        }
        _ => (0..=modes.len()).map(|k| low + (high - low) * k as f64 / modes.len() as f64).collect(),
    }
}
