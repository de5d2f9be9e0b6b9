//! The reduction itself.

use faer::{Mat, Par};

use super::{Criterion, Identifiability, Scaling, Why};
use crate::parameter::{Group, Parameter};

/// Relative remainder below which a column counts as exactly dependent: rounding leaves about 1e-15 times the
/// conditioning of the kept columns; the smallest genuine remainders of real robots are above 1e-6.
const EXACT: f64 = 1e-9;
/// Columns whose remainders agree this well are tied; the later one is taken.
const TIE: f64 = 1e-6;

/// One column of an observation matrix.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Column {
    /// Belongs to the measuring arrangement (base, tool, markers), which is kept before all others.
    pub first: bool,
    /// One sigma of its parameter, in its unit.
    pub tolerance: f64,
    /// Readiness to keep it when it and others are nearly dependent: 1, or less for what is given up first.
    pub preference: f64,
    /// Dropped because it was asked for.
    pub held: bool,
}

impl Column {
    /// How the column of `parameter` is to be treated; `held` if it is to be dropped.
    pub fn about(parameter: &Parameter, held: bool) -> Self {
        Self {
            first: parameter.group != Group::Geometry,
            tolerance: parameter.tolerance,
            preference: if parameter.closing { 0.1 } else { 1.0 },
            held,
        }
    }
}

/// Reduces an observation matrix.
///
/// `matrix` is row-major, as wide as there are `columns`, its rows divided by the noise of their reading where that is
/// known. Ties are broken by column order (the later is kept), so that the order of rows, the number of threads and the
/// processor do not change the kept set.
pub fn reduce(matrix: &[f64], about: &[Column], scaling: Scaling, criterion: Criterion) -> Identifiability {
    faer::set_global_parallelism(Par::Seq);
    let columns = about.len();
    let rows = matrix.len().checked_div(columns).unwrap_or(0);
    // All that follows needs only the triangle.
    let tall = Mat::from_fn(rows.max(columns), columns, |i, j| if i < rows { matrix[i * columns + j] } else { 0.0 });
    let r = tall.qr().thin_R().to_owned();
    let norms: Vec<f64> = (0..columns).map(|j| r.col(j).norm_l2()).collect();
    // What a common error of each shows: stiffnesses in N/m and angles are not of one size.
    let shown: Vec<f64> = norms
        .iter()
        .zip(about)
        .map(|(&norm, of)| if of.tolerance > 0.0 && of.tolerance.is_finite() { norm * of.tolerance } else { norm })
        .collect();
    let largest = shown.iter().copied().fold(0.0, f64::max);
    let effective: Vec<bool> = shown.iter().map(|&shown| shown > 1e-12 * largest && shown.is_finite()).collect();
    let scale: Vec<f64> = (0..columns)
        .map(|j| match scaling {
            _ if !effective[j] => 0.0,
            Scaling::Norm => 1.0 / norms[j],
            Scaling::Tolerance => about[j].tolerance,
        })
        .collect();
    let scaled = Mat::from_fn(columns, columns, |i, j| r[(i, j)] * scale[j]);

    let mut chosen: Vec<usize> = Vec::new();
    let mut remainder = vec![0.0; columns];
    let mut basis = Mat::<f64>::zeros(columns, 0);
    // The arrangement first, then the robot, then what is held (to know whether it is exactly dependent).
    for class in 0..3 {
        let class_of = |column: &Column| if column.held { 2 } else { usize::from(!column.first) };
        let candidates: Vec<usize> = (0..columns).filter(|&j| class_of(&about[j]) == class && effective[j]).collect();
        if candidates.is_empty() {
            continue;
        }
        let mut left = Mat::from_fn(columns, candidates.len(), |i, k| scaled[(i, candidates[k])]);
        for _ in 0..2 {
            let shadow = basis.transpose() * &left;
            left -= &basis * shadow;
        }
        let bias = |column: usize| about[column].preference * (1.0 + TIE * column as f64);
        let biased = Mat::from_fn(columns, candidates.len(), |i, k| left[(i, k)] * bias(candidates[k]));
        let qr = biased.col_piv_qr();
        let (order, triangle, q) = (qr.P().arrays().0.to_vec(), qr.thin_R(), qr.compute_thin_Q());
        let mut added = 0;
        for (k, &position) in order.iter().enumerate() {
            let column = candidates[position];
            remainder[column] = triangle[(k, k)].abs() / (bias(column) * scale[column] * norms[column]);
            if remainder[column] > EXACT {
                chosen.push(column);
                added = k + 1;
            }
        }
        basis = Mat::from_fn(columns, basis.ncols() + added, |i, k| {
            if k < basis.ncols() { basis[(i, k)] } else { q[(i, k - basis.ncols())] }
        });
    }
    let rank = chosen.len();
    let eligible: Vec<usize> = chosen.iter().copied().filter(|&column| !about[column].held).collect();
    let mut kept: Vec<usize> = match criterion {
        Criterion::Relative(tolerance) => {
            let all = Mat::from_fn(columns, eligible.len(), |i, k| scaled[(i, eligible[k])]);
            let singular_values = all.singular_values().unwrap_or_default();
            let least = tolerance * singular_values.first().copied().unwrap_or(0.0);
            let count = singular_values.iter().filter(|&&s| s >= least).count();
            eligible
                .iter()
                .enumerate()
                .filter(|&(k, &column)| k < count || about[column].first)
                .map(|(_, &column)| column)
                .collect()
        }
        Criterion::Noise => {
            let seen = |column: usize| remainder[column] * norms[column] * about[column].tolerance >= 1.0;
            eligible.iter().copied().filter(|&column| about[column].first || seen(column)).collect()
        }
    };
    kept.sort_unstable();
    let dropped: Vec<(usize, Why)> = (0..columns)
        .filter(|column| !kept.contains(column))
        .map(|column| {
            let why = match chosen.contains(&column) {
                false => Why::Exact,
                true if about[column].held => Why::Held,
                true => Why::Weak,
            };
            (column, why)
        })
        .collect();

    let kept_scaled = Mat::from_fn(columns, kept.len(), |i, k| scaled[(i, kept[k])]);
    let combinations = combine(&kept_scaled, &scaled, &scale, &kept, &dropped, &effective);
    let singular_values = kept_scaled.singular_values().unwrap_or_default();
    let (condition, observability) = indices(&singular_values, rows);
    let tolerance = match criterion {
        Criterion::Relative(tolerance) => Some(tolerance),
        Criterion::Noise => None,
    };
    Identifiability {
        columns,
        rank,
        kept,
        dropped,
        combinations,
        remainder,
        singular_values,
        condition,
        observability,
        tolerance,
    }
}

/// What each kept parameter took over, by least squares of the dropped columns on the kept ones.
fn combine(
    kept_scaled: &Mat<f64>,
    scaled: &Mat<f64>,
    scale: &[f64],
    kept: &[usize],
    dropped: &[(usize, Why)],
    effective: &[bool],
) -> Vec<(usize, Vec<(usize, f64)>)> {
    use faer::linalg::solvers::SolveLstsq;
    let explained: Vec<usize> = dropped.iter().map(|(column, _)| *column).filter(|&column| effective[column]).collect();
    if kept.is_empty() || explained.is_empty() {
        return Vec::new();
    }
    let right = Mat::from_fn(scaled.nrows(), explained.len(), |i, k| scaled[(i, explained[k])]);
    let factors = kept_scaled.qr().solve_lstsq(&right);
    let mut combinations = Vec::new();
    for (i, &keeper) in kept.iter().enumerate() {
        let terms: Vec<(usize, f64)> = explained
            .iter()
            .enumerate()
            .filter(|&(k, _)| factors[(i, k)].abs() > 1e-6 * right.col(k).norm_l2())
            .map(|(k, &column)| (column, factors[(i, k)] * scale[keeper] / scale[column]))
            .collect();
        if !terms.is_empty() {
            combinations.push((keeper, terms));
        }
    }
    combinations
}

/// Condition number and O1..O5: (product)^(1/n) / sqrt(rows), last / first, last, last^2 / first, 1 / sum of inverses.
fn indices(singular_values: &[f64], rows: usize) -> (f64, [f64; 5]) {
    let (Some(&first), Some(&last)) = (singular_values.first(), singular_values.last()) else {
        return (f64::NAN, [f64::NAN; 5]);
    };
    let n = singular_values.len() as f64;
    let mean_log = singular_values.iter().map(|s| s.ln()).sum::<f64>() / n;
    let inverse: f64 = singular_values.iter().map(|s| 1.0 / s).sum();
    (first / last, [mean_log.exp() / (rows as f64).sqrt(), last / first, last, last * last / first, 1.0 / inverse])
}
