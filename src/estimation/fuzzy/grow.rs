//! Structure of grids: sets are added to the inputs of each component one at a time, until the error of configurations
//! left out in turns stops falling. Readings held out have no part in it and remain an independent judge.
//!
//! Source: IR663 calibration paper, sec. 2.2.2 (growth by a test error); Golub, Heath and Wahba 1979 (generalised
//! cross-validation, where there are too few configurations to leave any out).

use rayon::prelude::*;

use super::group::{Group, rms, split};
use super::grown::{Grown, Step, SubModel};
use super::modes::place;
use super::partition::{Partition, rules, widened};
use super::samples::Samples;
use super::settings::FuzzySettings;
use crate::description::fuzzy::{Premise, Rules};
use crate::fuzzy::firing;

/// Range of an input, relative to its size, below which it does not change: rounding of a repeated configuration.
const CHANGING: f64 = 1e-9;
/// Least part of the readings that generalised cross-validation takes for degrees of freedom, where there are as many rules.
const LEAST_FREEDOM: f64 = 1e-3;

/// Grows rules on grids. `correction` allows none at all too: then the error without any is the first step.
pub fn grow_grids(
    samples: &Samples,
    settings: &FuzzySettings,
    correction: bool,
    taken: &(dyn Fn(&Step) + Sync),
) -> Grown {
    let groups = Group::all(samples, settings);
    let grown: Vec<(Vec<Partition>, Vec<Step>)> =
        groups.par_iter().map(|group| Growth::new(group, correction, taken).run()).collect();
    let mut components = Vec::new();
    let mut steps = Vec::new();
    for (group, (parts, own)) in groups.iter().zip(grown) {
        let conclusions = split(&parts, &group.solve_bounded(&parts, &group.fitted));
        for ((modes, conclusions), &column) in parts.into_iter().zip(conclusions).zip(&group.columns) {
            let mut support = vec![0.0; conclusions.len()];
            for &k in group.fitted.iter().filter(|&&k| samples.load[k][column] != 0.0) {
                firing(&modes, &samples.x[k], &mut |rule, weight| support[rule] += weight);
            }
            let unseen = (0..support.len()).filter(|&rule| support[rule] < settings.seen).collect();
            let rules = Rules { premise: Premise::Grid(modes), conclusions };
            components.push(SubModel { at: [group.axis, column], rules, support, unseen });
        }
        steps.extend(own);
    }
    components.sort_by_key(|component| component.at);
    Grown { components, axes: samples.axes, range: samples.range.clone(), beyond: 0, steps, left_out: 0.0 }
}

/// Errors of a structure, root mean square, m.
#[derive(Debug, Clone, Copy)]
struct Judged {
    /// Of the fitted readings.
    fitted: f64,
    /// Of readings to come, as generalised cross-validation predicts.
    predicted: f64,
}

/// A structure that might be next: which load component got sets, all partitions, and their errors.
struct Trial {
    own: usize,
    parts: Vec<Partition>,
    judged: Judged,
}

/// The growth of one group.
struct Growth<'g> {
    group: &'g Group<'g>,
    taken: &'g (dyn Fn(&Step) + Sync),
    /// Partitions by load component.
    parts: Vec<Partition>,
    best: Judged,
    /// Error of configurations left out in turns.
    left_out: f64,
    steps: Vec<Step>,
}

impl<'g> Growth<'g> {
    fn new(group: &'g Group<'g>, correction: bool, taken: &'g (dyn Fn(&Step) + Sync)) -> Self {
        let samples = group.samples;
        let constant: Partition = samples.range.iter().map(|[low, high]| vec![0.5 * (low + high)]).collect();
        let parts = vec![constant; group.columns.len()];
        let best = judge(group, &parts);
        let left_out = left_out(group, &parts, &best);
        let mut growth = Self { group, taken, parts, best, left_out, steps: Vec::new() };
        let inputs = samples.range.len();
        if correction {
            let displacements: Vec<f64> = group.fitted.iter().map(|&k| samples.d[k][group.axis]).collect();
            growth.record(None, vec![0; inputs], None, rms(&displacements));
        }
        growth.record(None, vec![1; inputs], Some(best.fitted), left_out);
        growth
    }

    fn record(&mut self, column: Option<usize>, sets: Vec<usize>, fitted: Option<f64>, cross_validated: f64) {
        let at = |column: usize| [self.group.axis, column];
        let components = self.group.columns.iter().map(|&column| at(column)).collect();
        let rules = sets.iter().product();
        let step = Step { components, component: column.map(at), sets, rules, fitted, cross_validated };
        (self.taken)(&step);
        self.steps.push(step);
    }

    /// Partitions by load component, and how they grew.
    fn run(mut self) -> (Vec<Partition>, Vec<Step>) {
        let range = &self.group.samples.range;
        let changes = |[low, high]: &[f64; 2]| high - low > CHANGING * (1.0 + low.abs());
        let changing: Vec<usize> = (0..range.len()).filter(|&input| changes(&range[input])).collect();
        let inputs = || changing.iter().copied();
        let single: Vec<Vec<usize>> = inputs().map(|input| vec![input]).collect();
        let pairs: Vec<Vec<usize>> = inputs()
            .flat_map(|one| inputs().filter(move |other| *other >= one).map(move |other| vec![one, other]))
            .collect();
        // A set in one input alone may not help where one in each of two does.
        while [&single, &pairs].into_iter().any(|more| self.take(more)) {}
        (self.parts, self.steps)
    }

    /// Takes the best structure with one more set in each of some inputs, if configurations left out gain by it: with few,
    /// or with few readings of each, the predicted error falls by chance too.
    fn take(&mut self, more: &[Vec<usize>]) -> bool {
        let Some(Trial { own, parts, judged }) = self.better(more) else { return false };
        let left_out = left_out(self.group, &parts, &judged);
        if left_out >= (1.0 - self.group.settings.worth) * self.left_out {
            return false;
        }
        (self.parts, self.best, self.left_out) = (parts, judged, left_out);
        let sets = self.parts[own].iter().map(Vec::len).collect();
        self.record(Some(self.group.columns[own]), sets, Some(judged.fitted), left_out);
        true
    }

    /// The best structure with one more set in each of some inputs of one load component, if any is worth it.
    fn better(&self, more: &[Vec<usize>]) -> Option<Trial> {
        let trials: Vec<(usize, &Vec<usize>)> =
            (0..self.parts.len()).flat_map(|own| more.iter().map(move |inputs| (own, inputs))).collect();
        let tried: Vec<Trial> = trials.into_par_iter().filter_map(|(own, inputs)| self.tried(own, inputs)).collect();
        tried.into_iter().min_by(|a, b| a.judged.predicted.total_cmp(&b.judged.predicted))
    }

    fn tried(&self, own: usize, inputs: &[usize]) -> Option<Trial> {
        let (group, settings) = (self.group, self.group.settings);
        let starts = [false, true].map(|evenly| {
            inputs.iter().fold(self.parts[own].clone(), |mut start, &input| {
                start[input] = widened(&start[input], group.samples.range[input], evenly);
                start
            })
        });
        let others: usize =
            self.parts.iter().enumerate().filter(|(j, _)| *j != own).map(|(_, modes)| rules(modes)).sum();
        if 2 * (rules(&starts[0]) + others) > group.fitted.len() {
            return None;
        }
        let mut parts = self.parts.clone();
        parts[own] = place(group, &self.parts, own, &starts);
        let judged = judge(group, &parts);
        let worth = judged.predicted < (1.0 - settings.worth) * self.best.predicted;
        worth.then_some(Trial { own, parts, judged })
    }
}

fn judge(group: &Group, parts: &[Partition]) -> Judged {
    let b = group.solve(parts, &group.fitted);
    let fitted = rms(&group.residual(parts, &b, &group.fitted));
    let freedom = 1.0 - b.len() as f64 / group.fitted.len() as f64;
    let predicted = fitted / freedom.max(LEAST_FREEDOM);
    Judged { fitted, predicted }
}

/// Error of configurations left out in turns, the sets placed anew without them; as predicted where there are too few.
fn left_out(group: &Group, parts: &[Partition], judged: &Judged) -> f64 {
    let placed = |without: &Group, mut parts: Vec<Partition>| {
        for own in 0..parts.len() {
            parts[own] = place(without, &parts, own, &[parts[own].clone()]);
        }
        parts
    };
    group.cross_validated(parts, &placed).unwrap_or(judged.predicted)
}
