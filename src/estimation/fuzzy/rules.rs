//! Conclusions in closed form.

use nalgebra::{DMatrix, DVector};

use super::grow::Grown;
use super::samples::Samples;
use crate::description::fuzzy::{Component, Fuzzy, Input};
use crate::estimation::least_squares::{Bounds, minimize_in_box};
use crate::surrogate::firing;

/// Weight of the difference between neighbouring conclusions beside one reading a rule: settles those no reading reaches.
const SMOOTH: f64 = 1e-3;
/// Folds of the cross-validation.
const FOLDS: usize = 5;

/// Number of rules of a partition.
pub fn rules(modes: &[Vec<f64>]) -> usize {
    modes.iter().map(Vec::len).product()
}

/// Pairs of rules that differ by one set of one input.
fn neighbours(modes: &[Vec<f64>]) -> Vec<[usize; 2]> {
    let mut pairs = Vec::new();
    let mut stride = 1;
    for own in modes.iter().rev() {
        let last = (own.len() - 1) * stride;
        pairs.extend(
            (0..rules(modes)).filter(|rule| rule % (own.len() * stride) < last).map(|rule| [rule, rule + stride]),
        );
        stride *= own.len();
    }
    pairs
}

/// Rows of the linear problem: readings, then smoothing, by rule and load component (the latter fastest).
fn design(samples: &Samples, modes: &[Vec<f64>], of: &[usize]) -> DMatrix<f64> {
    let width = samples.columns.len();
    let pairs = neighbours(modes);
    let mut a = DMatrix::zeros(of.len() + pairs.len() * width, rules(modes) * width);
    for (row, &k) in of.iter().enumerate() {
        firing(modes, &samples.x[k], &mut |rule, weight| {
            for (j, &column) in samples.columns.iter().enumerate() {
                a[(row, rule * width + j)] = weight * samples.load[k][column];
            }
        });
    }
    let size = |column: usize| {
        let squares: f64 = of.iter().map(|&k| samples.load[k][column].powi(2)).sum();
        SMOOTH * (squares / rules(modes) as f64).sqrt()
    };
    for (p, [one, other]) in pairs.into_iter().enumerate() {
        for (j, &column) in samples.columns.iter().enumerate() {
            let row = of.len() + p * width + j;
            a[(row, one * width + j)] = size(column);
            a[(row, other * width + j)] = -size(column);
        }
    }
    a
}

/// The conclusions that leave least of the samples `of`: rules and load components by displacement (x, y, z).
pub fn solve(samples: &Samples, modes: &[Vec<f64>], of: &[usize]) -> DMatrix<f64> {
    let a = design(samples, modes, of);
    let d = DMatrix::from_fn(a.nrows(), 3, |i, k| if i < of.len() { samples.d[of[i]][k] } else { 0.0 });
    let mut normal = a.tr_mul(&a);
    let ridge = 1e-12 * normal.trace().max(f64::MIN_POSITIVE) / normal.nrows() as f64;
    (0..normal.nrows()).for_each(|k| normal[(k, k)] += ridge);
    let n = normal.nrows();
    normal.cholesky().map_or_else(|| DMatrix::zeros(n, 3), |factor| factor.solve(&a.tr_mul(&d)))
}

/// The same with direct compliances (displacement along the load) not negative.
pub fn solve_bounded(samples: &Samples, modes: &[Vec<f64>], of: &[usize]) -> DMatrix<f64> {
    let mut b = solve(samples, modes, of);
    let width = samples.columns.len();
    let a = design(samples, modes, of);
    for k in 0..3 {
        let direct = |row: usize| samples.columns[row % width] == k;
        if (0..b.nrows()).any(|row| direct(row) && b[(row, k)] < 0.0) {
            let lower = (0..b.nrows()).map(|row| if direct(row) { 0.0 } else { f64::NEG_INFINITY }).collect();
            let bounds = Bounds { lower, upper: vec![f64::INFINITY; b.nrows()] };
            let right = DVector::from_fn(a.nrows(), |i, _| if i < of.len() { -samples.d[of[i]][k] } else { 0.0 });
            if let Ok(within) = minimize_in_box(&a, &right, &bounds) {
                b.set_column(k, &within);
            }
        }
    }
    b
}

/// Displacements left of samples, three each, m.
pub fn left(samples: &Samples, modes: &[Vec<f64>], b: &DMatrix<f64>, of: &[usize]) -> Vec<f64> {
    let width = samples.columns.len();
    let mut all = Vec::with_capacity(3 * of.len());
    for &k in of {
        let mut d = samples.d[k];
        firing(modes, &samples.x[k], &mut |rule, weight| {
            for (j, &column) in samples.columns.iter().enumerate() {
                d -= weight * samples.load[k][column] * b.row(rule * width + j).transpose().fixed_rows::<3>(0);
            }
        });
        all.extend(d.iter());
    }
    all
}

/// Root mean square distance, from displacements three each.
pub fn rms(left: &[f64]) -> f64 {
    (left.iter().map(|v| v * v).sum::<f64>() / (left.len() / 3).max(1) as f64).sqrt()
}

/// Root mean square error of the fitted samples when parts of the configurations are left out in turns, m: with no rules,
/// and with these.
pub fn cross_validated(samples: &Samples, modes: &[Vec<f64>]) -> [f64; 2] {
    let mut poses: Vec<usize> = samples.indices(false, |_| true).iter().map(|&k| samples.pose[k]).collect();
    poses.sort_unstable();
    poses.dedup();
    let fold = |k: usize| poses.binary_search(&samples.pose[k]).unwrap_or(0) % FOLDS;
    let mut all = Vec::new();
    for part in 0..FOLDS {
        let b = solve_bounded(samples, modes, &samples.indices(false, |k| fold(k) != part));
        all.extend(left(samples, modes, &b, &samples.indices(false, |k| fold(k) == part)));
    }
    let nothing: Vec<f64> = samples
        .indices(false, |_| true)
        .iter()
        .flat_map(|&k| samples.d[k].iter().copied().collect::<Vec<_>>())
        .collect();
    [rms(&nothing), rms(&all)]
}

/// The model that rules make.
pub fn model_of(samples: &Samples, grown: &Grown, inputs: &[Input], adds: bool) -> Fuzzy {
    let width = samples.columns.len();
    // An input with one set has no say.
    let used: Vec<usize> = (0..inputs.len()).filter(|&k| grown.modes[k].len() > 1).collect();
    let mut components = Vec::new();
    for row in 0..3 {
        for (j, &column) in samples.columns.iter().enumerate() {
            let conclusions = (0..rules(&grown.modes)).map(|rule| grown.conclusions[(rule * width + j, row)]).collect();
            let modes = used.iter().map(|&k| grown.modes[k].clone()).collect();
            components.push(Component { at: [row, column], modes, conclusions });
        }
    }
    Fuzzy { inputs: used.iter().map(|&k| inputs[k]).collect(), at: samples.marker, adds, components }
}
