//! Structure: sets are added to the inputs of each component one at a time, until the test error stops falling.
//!
//! Source: IR663 calibration paper, sec. 2.2.2 (growth by the test error); Golub, Heath and Wahba 1979 (generalised
//! cross-validation, where there is no test set).

use rayon::prelude::*;

use super::group::{Group, rms, split};
use super::grown::{Grown, Step, SubModel};
use super::modes::place;
use super::partition::{Partition, rules, widened};
use super::samples::Samples;
use super::settings::FuzzySettings;
use crate::estimation::result::CalibrationError;
use crate::fuzzy::firing;

/// Range of an input, relative to its size, below which it does not change: rounding of a repeated configuration.
const CHANGING: f64 = 1e-9;
/// Least part of the readings that generalised cross-validation takes for degrees of freedom, where there are as many rules.
const LEAST_FREEDOM: f64 = 1e-3;

/// Grows rules. `correction` allows none at all too: then the error without any is the first step.
pub fn grow(
    samples: &Samples,
    settings: &FuzzySettings,
    correction: bool,
    taken: &(dyn Fn(&Step) + Sync),
) -> Result<Grown, CalibrationError> {
    if samples.columns.is_empty() {
        return Err(CalibrationError::Malformed("no fitted reading is loaded".into()));
    }
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
            components.push(SubModel { at: [group.axis, column], modes, conclusions, support, unseen });
        }
        steps.extend(own);
    }
    components.sort_by_key(|component| component.at);
    let outside = |&&k: &&usize| samples.x[k].iter().zip(&samples.range).any(|(x, [low, high])| x < low || x > high);
    let beyond = samples.indices(true, |_| true).iter().filter(outside).count();
    Ok(Grown { components, range: samples.range.clone(), beyond, steps })
}

/// Errors of a structure, root mean square, m.
#[derive(Debug, Clone, Copy)]
struct Judged {
    /// Of the fitted readings.
    fitted: f64,
    /// Of the test readings; where there are none, as predicted.
    test: f64,
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
    steps: Vec<Step>,
}

impl<'g> Growth<'g> {
    fn new(group: &'g Group<'g>, correction: bool, taken: &'g (dyn Fn(&Step) + Sync)) -> Self {
        let samples = group.samples;
        let constant: Partition = samples.range.iter().map(|[low, high]| vec![0.5 * (low + high)]).collect();
        let parts = vec![constant; group.columns.len()];
        let best = judge(group, &parts);
        let mut growth = Self { group, taken, parts, best, steps: Vec::new() };
        let inputs = samples.range.len();
        if correction {
            let of = if group.test.is_empty() { &group.fitted } else { &group.test };
            let displacements: Vec<f64> = of.iter().map(|&k| samples.d[k][group.axis]).collect();
            growth.record(None, vec![0; inputs], None, rms(&displacements));
        }
        growth.record(None, vec![1; inputs], Some(best.fitted), best.test);
        growth
    }

    fn record(&mut self, column: Option<usize>, sets: Vec<usize>, fitted: Option<f64>, test: f64) {
        let (axis, columns) = (self.group.axis, self.group.columns.clone());
        let step = Step { axis, columns, column, sets, fitted, test };
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
        while let Some(Trial { own, parts, judged }) = [&single, &pairs].into_iter().find_map(|more| self.better(more))
        {
            (self.parts, self.best) = (parts, judged);
            let sets = self.parts[own].iter().map(Vec::len).collect();
            self.record(Some(self.group.columns[own]), sets, Some(judged.fitted), judged.test);
        }
        (self.parts, self.steps)
    }

    /// The best structure with one more set in each of some inputs of one load component, if any is worth it.
    fn better(&self, more: &[Vec<usize>]) -> Option<Trial> {
        let trials: Vec<(usize, &Vec<usize>)> =
            (0..self.parts.len()).flat_map(|own| more.iter().map(move |inputs| (own, inputs))).collect();
        let tried: Vec<Trial> = trials.into_par_iter().filter_map(|(own, inputs)| self.tried(own, inputs)).collect();
        tried.into_iter().min_by(|a, b| a.judged.test.total_cmp(&b.judged.test))
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
        // A small test set also falls by chance.
        let worth = judged.test < (1.0 - settings.worth) * self.best.test && judged.predicted < self.best.predicted;
        worth.then_some(Trial { own, parts, judged })
    }
}

fn judge(group: &Group, parts: &[Partition]) -> Judged {
    let b = group.solve(parts, &group.fitted);
    let fitted = rms(&group.residual(parts, &b, &group.fitted));
    let freedom = 1.0 - b.len() as f64 / group.fitted.len() as f64;
    let predicted = fitted / freedom.max(LEAST_FREEDOM);
    let test = if group.test.is_empty() { predicted } else { rms(&group.residual(parts, &b, &group.test)) };
    Judged { fitted, test, predicted }
}
