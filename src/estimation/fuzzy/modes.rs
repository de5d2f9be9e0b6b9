//! Modal values placed where the best conclusions leave the smallest residual.
//!
//! Sources: Golub and Pereyra 1973 (conclusions are eliminated); Solis and Wets 1981 (random search).

use nalgebra::{DMatrix, DVector};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use super::group::Group;
use super::partition::Partition;
use super::settings::Placement;
use crate::least_squares::{self, Bounds, EvaluationError, Problem};

/// Step of the difference quotients, in gaps of size 1: the root of rounding times the size, rounded up.
const DIFFERENCE: f64 = 1e-5;
/// Residuals are put in micrometres, so that none is lost in the floor of the cost.
const MICRO: f64 = 1e6;

/// The partition of one component as gaps: below the first mode, between modes, above the last one.
struct Gaps<'a> {
    group: &'a Group<'a>,
    /// Partitions by load component, and which of them is sought.
    parts: &'a [Partition],
    own: usize,
    counts: Vec<usize>,
}

impl Gaps<'_> {
    fn of(&self, modes: &[Vec<f64>]) -> Vec<f64> {
        let mut gaps = Vec::new();
        for (own, [low, high]) in modes.iter().zip(&self.group.samples.range).filter(|(own, _)| own.len() > 1) {
            let mut last = *low;
            for end in own.iter().chain([high]) {
                gaps.push(((end - last) / (high - low)).max(self.group.settings.least_gap));
                last = *end;
            }
        }
        gaps
    }

    fn modes(&self, gaps: &[f64]) -> Vec<Vec<f64>> {
        let mut remaining = gaps;
        let place = |(&count, [low, high]): (&usize, &[f64; 2])| {
            if count < 2 {
                return vec![0.5 * (low + high)];
            }
            let (own, others) = remaining.split_at(count + 1);
            remaining = others;
            let sum: f64 = own.iter().sum();
            let mut at = 0.0;
            let each = |gap: &f64| {
                at += gap / sum;
                low + at * (high - low)
            };
            own[..count].iter().map(each).collect()
        };
        self.counts.iter().zip(&self.group.samples.range).map(place).collect()
    }

    fn residual(&self, gaps: &[f64]) -> Vec<f64> {
        let mut parts = self.parts.to_vec();
        parts[self.own] = self.modes(gaps);
        let b = self.group.solve(&parts, &self.group.fitted);
        self.group.residual(&parts, &b, &self.group.fitted)
    }

    /// Better gaps.
    fn improved(&self, gaps: &[f64]) -> Vec<f64> {
        let limits = self.group.settings;
        if gaps.is_empty() {
            return Vec::new();
        }
        match limits.placement {
            Placement::GaussNewton => {
                let bounds = Bounds { lower: vec![limits.least_gap; gaps.len()], upper: vec![1.0; gaps.len()] };
                let settings = least_squares::Settings {
                    max_iterations: limits.steps,
                    cost_tolerance: limits.cost_tolerance,
                    ..Default::default()
                };
                least_squares::minimize(self, gaps, &bounds, &settings).map_or(gaps.to_vec(), |solution| solution.x)
            }
            Placement::SolisWets(seed) => solis_wets(self, gaps, seed),
        }
    }

    fn squares(&self, gaps: &[f64]) -> f64 {
        self.residual(gaps).iter().map(|v| v * v).sum()
    }
}

impl Problem for Gaps<'_> {
    fn parameters(&self) -> usize {
        self.counts.iter().filter(|count| **count > 1).map(|count| count + 1).sum()
    }

    fn residuals(&self) -> usize {
        self.group.fitted.len()
    }

    fn evaluate(
        &self,
        x: &[f64],
        residual: &mut DVector<f64>,
        jacobian: Option<&mut DMatrix<f64>>,
    ) -> Result<(), EvaluationError> {
        let at = self.residual(x);
        residual.iter_mut().zip(&at).for_each(|(row, value)| *row = MICRO * value);
        if let Some(jacobian) = jacobian {
            let mut moved = x.to_vec();
            for k in 0..x.len() {
                moved[k] = x[k] + DIFFERENCE;
                for (row, (after, before)) in self.residual(&moved).iter().zip(&at).enumerate() {
                    jacobian[(row, k)] = MICRO * (after - before) / DIFFERENCE;
                }
                moved[k] = x[k];
            }
        }
        Ok(())
    }
}

/// The partition by load component `own` of a group with the best modal values found from several starts.
pub fn place(group: &Group, parts: &[Partition], own: usize, starts: &[Partition]) -> Partition {
    let placed = starts.iter().enumerate().filter(|(k, start)| !starts[..*k].contains(start)).map(|(_, start)| {
        let counts: Vec<usize> = start.iter().map(Vec::len).collect();
        let problem = Gaps { group, parts, own, counts };
        let gaps = problem.of(start);
        let found = problem.improved(&gaps);
        let [before, after] = [&gaps, &found].map(|gaps| problem.squares(gaps));
        if after < before { (problem.modes(&found), after) } else { (problem.modes(&gaps), before) }
    });
    placed.min_by(|a, b| a.1.total_cmp(&b.1)).map_or_else(|| parts[own].clone(), |(modes, _)| modes)
}

/// Random search with a memory of directions that helped (Solis and Wets 1981, algorithm 1).
fn solis_wets(problem: &Gaps, start: &[f64], seed: u64) -> Vec<f64> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let (mut best, mut cost) = (start.to_vec(), problem.squares(start));
    let mut bias = vec![0.0; start.len()];
    let (mut size, mut good, mut bad) = (0.1, 0, 0);
    for _ in 0..problem.group.settings.trials {
        let step: Vec<f64> = bias
            .iter()
            .map(|bias| {
                let draw: f64 = StandardNormal.sample(&mut random);
                bias + size * draw
            })
            .collect();
        let along = |sign: f64| -> Vec<f64> {
            best.iter()
                .zip(&step)
                .map(|(x, step)| (x + sign * step).clamp(problem.group.settings.least_gap, 1.0))
                .collect()
        };
        let tried = [1.0, -1.0].map(|sign| (sign, along(sign)));
        let better =
            tried.into_iter().map(|(sign, x)| (sign, problem.squares(&x), x)).find(|(_, squares, _)| *squares < cost);
        match better {
            Some((sign, squares, x)) => {
                bias.iter_mut().zip(&step).for_each(|(bias, step)| *bias = 0.2 * *bias + 0.4 * sign * step);
                (best, cost, good, bad) = (x, squares, good + 1, 0);
            }
            None => {
                bias.iter_mut().for_each(|bias| *bias *= 0.5);
                (good, bad) = (0, bad + 1);
            }
        }
        if good >= 5 {
            (size, good) = ((2.0 * size).min(0.5), 0);
        } else if bad >= 3 {
            (size, bad) = ((0.5 * size).max(1e-4), 0);
        }
    }
    best
}
