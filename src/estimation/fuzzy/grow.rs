//! Structure: sets are added to inputs one at a time, until the test error stops falling.

use nalgebra::DMatrix;

use super::Placement;
use super::modes::place;
use super::rules::{left, rms, rules, solve, solve_bounded};
use super::samples::Samples;
use crate::estimation::CalibrationError;
use crate::surrogate::firing;

/// Least part by which another set must lower the test error.
const WORTH: f64 = 0.01;
/// Firing strength, summed over the fitted readings, below which a rule has seen no data.
const SEEN: f64 = 0.5;

/// A structure that was tried and taken.
#[derive(Debug, Clone, PartialEq)]
pub struct Step {
    /// Sets of each input.
    pub sets: Vec<usize>,
    /// Root mean square error of fitted and of test readings, m.
    pub errors: [f64; 2],
}

/// Rules, shared by all components.
#[derive(Debug, Clone, PartialEq)]
pub struct Grown {
    /// Modal values by input, rad or m; one where the input has no say.
    pub modes: Vec<Vec<f64>>,
    /// Conclusions: rules and load components (the latter fastest) by displacement (x, y, z), m per N or N.m.
    pub conclusions: DMatrix<f64>,
    /// Components of the load.
    pub columns: Vec<usize>,
    /// Firing strength of each rule, summed over the fitted readings.
    pub support: Vec<f64>,
    /// Rules that have seen no data: their conclusions are their neighbours'.
    pub unseen: Vec<usize>,
    /// Least and greatest of each input among the fitted readings; outside the model holds its last value.
    pub range: Vec<[f64; 2]>,
    /// Readings set aside whose inputs are outside that range.
    pub beyond: usize,
    /// How the structure grew.
    pub steps: Vec<Step>,
}

/// Grows rules; `nothing` is the test error without any, if that is allowed.
pub fn grow(samples: &Samples, placement: Placement, nothing: Option<f64>) -> Result<Grown, CalibrationError> {
    let fitted = samples.indices(false, |_| true);
    let test = samples.indices(true, |_| true);
    if samples.columns.is_empty() {
        return Err(CalibrationError::Malformed("no fitted reading is loaded".into()));
    }
    let errors = |modes: &[Vec<f64>]| {
        let b = solve(samples, modes, &fitted);
        let own = rms(&left(samples, modes, &b, &fitted));
        // Without a test set: the error foretold by generalised cross-validation.
        let freedom = 1.0 - (rules(modes) * samples.columns.len()) as f64 / fitted.len() as f64;
        let unseen = if test.is_empty() { own / freedom.max(1e-3) } else { rms(&left(samples, modes, &b, &test)) };
        [own, unseen]
    };
    let mut modes: Vec<Vec<f64>> = samples.range.iter().map(|[low, high]| vec![0.5 * (low + high)]).collect();
    let mut best = errors(&modes);
    let counts = |modes: &[Vec<f64>]| modes.iter().map(Vec::len).collect::<Vec<usize>>();
    let mut steps = Vec::new();
    if let Some(nothing) = nothing {
        steps.push(Step { sets: vec![0; modes.len()], errors: [f64::NAN, nothing] });
    }
    steps.push(Step { sets: counts(&modes), errors: best });
    loop {
        let mut better: Option<(Vec<Vec<f64>>, [f64; 2])> = None;
        for input in 0..modes.len() {
            let [low, high] = samples.range[input];
            if high - low <= 1e-9 * (1.0 + low.abs()) {
                continue;
            }
            let mut trial = modes.clone();
            trial[input] = widened(&modes[input], low, high);
            if 2 * rules(&trial) * samples.columns.len() > fitted.len() {
                continue;
            }
            let trial = place(samples, &trial, placement);
            let found = errors(&trial);
            if found[1] < better.as_ref().map_or(best[1], |(_, known)| known[1]) {
                better = Some((trial, found));
            }
        }
        match better {
            Some((trial, found)) if found[1] < (1.0 - WORTH) * best[1] => {
                (modes, best) = (trial, found);
                steps.push(Step { sets: counts(&modes), errors: best });
            }
            _ => break,
        }
    }
    let mut support = vec![0.0; rules(&modes)];
    fitted.iter().for_each(|&k| firing(&modes, &samples.x[k], &mut |rule, weight| support[rule] += weight));
    let outside = |&&k: &&usize| samples.x[k].iter().zip(&samples.range).any(|(x, [low, high])| x < low || x > high);
    Ok(Grown {
        conclusions: solve_bounded(samples, &modes, &fitted),
        columns: samples.columns.clone(),
        unseen: (0..support.len()).filter(|&rule| support[rule] < SEEN).collect(),
        support,
        range: samples.range.clone(),
        beyond: test.iter().filter(outside).count(),
        steps,
        modes,
    })
}

/// One set more: both ends of the range first, then in the middle of the widest gap.
fn widened(modes: &[f64], low: f64, high: f64) -> Vec<f64> {
    if modes.len() < 2 {
        return vec![low, high];
    }
    let widest = (1..modes.len()).max_by(|&a, &b| (modes[a] - modes[a - 1]).total_cmp(&(modes[b] - modes[b - 1])));
    let mut more = modes.to_vec();
    if let Some(k) = widest {
        more.insert(k, 0.5 * (modes[k - 1] + modes[k]));
    }
    more
}
