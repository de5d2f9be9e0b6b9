//! The reduction itself: columns are scaled, chosen by column-pivoted QR, and cut off by the criterion.
//!
//! Source: Khalil, Gautier and Enguehard 1991 (selection by QR); Sun and Hollerbach 2008 (observability indices).

use nalgebra::DMatrix;

use super::{Criterion, DEFAULT_TOLERANCE, Identifiability, Scaling, Why};
use crate::math::linear::{PivotedQr, singular_values, triangle};
use crate::math::project_off;
use crate::parameter::{Group, Parameter};

/// Relative remainder below which a column counts as exactly dependent: rounding leaves about 1e-15 times the
/// conditioning of the kept columns; the smallest genuine remainders of real robots are above 1e-6.
const EXACT: f64 = 1e-9;
/// Columns whose remainders agree this well are tied; the later one is taken.
const TIE: f64 = 1e-6;
/// A column is zero when a common error of its parameter shows less than this part of the most that any other shows:
/// rounding of derivatives of the size of the largest.
const ZERO: f64 = 1e-12;
/// A parameter takes the place of one that would have to move by so many more of its tolerances to stand for it: a length that of an
/// angle with a lever of millimetres, which would turn by degrees. Judgement: constants a few tolerances off are common.
const MORE_TOLERANCES: f64 = 5.0;
/// Remainder from which a column counts as well determined. Exchanging a nearly dependent column brings in another one that is nearly
/// dependent, and the fit is no better conditioned. Judgement.
const PLAIN: f64 = 0.02;
/// Part of a dropped column below which a kept column's share of it is not reported.
const NEGLIGIBLE: f64 = 1e-6;

/// One column of an observation matrix.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Column {
    /// Belongs to the measuring arrangement (base, tool, markers), which is kept before all others.
    pub first: bool,
    /// Belongs to base, tool or markers: dropped like others where the readings hardly show it.
    pub placed: bool,
    /// Belongs to the base.
    pub of_base: bool,
    /// Belongs to what readings refer to: a socket, an anchor, a zero.
    pub referred_to: bool,
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
            placed: matches!(parameter.group, Group::Base | Group::Tool),
            of_base: parameter.group == Group::Base,
            referred_to: parameter.group == Group::Arrangement,
            tolerance: parameter.tolerance,
            preference: if parameter.closing { 0.1 } else { 1.0 },
            held,
        }
    }
}

/// The columns of an observation matrix, comparable.
struct Columns {
    /// Scaled, and reduced to the triangle of a QR (n x n), which is all that follows needs.
    scaled: DMatrix<f64>,
    /// Length of each column before scaling.
    norms: Vec<f64>,
    /// Factor of each column; 0 for those that are zero.
    scale: Vec<f64>,
    /// Rows of the observation matrix.
    rows: usize,
}

impl Columns {
    fn new(matrix: &[f64], about: &[Column], scaling: Scaling) -> Self {
        let n = about.len();
        let rows = matrix.len().checked_div(n).unwrap_or(0);
        let mut scaled = triangle(DMatrix::from_row_slice(rows, n, matrix).resize_vertically(rows.max(n), 0.0));
        let norms: Vec<f64> = scaled.column_iter().map(|column| column.norm()).collect();
        // What a common error of each shows: stiffnesses in N/m and angles are not of one size.
        let known = |of: &Column| of.tolerance > 0.0 && of.tolerance.is_finite();
        let shown: Vec<f64> =
            norms.iter().zip(about).map(|(norm, of)| if known(of) { norm * of.tolerance } else { *norm }).collect();
        let largest = shown.iter().copied().fold(0.0, f64::max);
        let factor = |j: usize| match scaling {
            _ if !(shown[j] > ZERO * largest && shown[j].is_finite()) => 0.0,
            Scaling::Norm => 1.0 / norms[j],
            Scaling::Tolerance => about[j].tolerance,
        };
        let scale: Vec<f64> = (0..n).map(factor).collect();
        for (mut column, factor) in scaled.column_iter_mut().zip(&scale) {
            column *= *factor;
        }
        Self { scaled, norms, scale, rows }
    }

    fn is_zero(&self, column: usize) -> bool {
        self.scale[column] == 0.0
    }

    fn choose(&self, columns: &[usize]) -> DMatrix<f64> {
        self.scaled.select_columns(columns)
    }
}

/// Reduces an observation matrix.
///
/// `matrix` is row-major, as wide as there are columns in `about`, its rows divided by the noise of their reading where
/// that is known. Ties are broken by column order (the later is kept), so that the order of rows, the number of threads
/// and the processor do not change the kept set.
pub fn reduce(matrix: &[f64], about: &[Column], scaling: Scaling, criterion: Criterion) -> Identifiability {
    let columns = Columns::new(matrix, about, scaling);
    let (chosen, remainder) = by_tolerance(&columns, about);
    let eligible: Vec<usize> = chosen.iter().copied().filter(|&column| !about[column].held).collect();
    // Base and tool are judged among themselves first: what is weak of them would else push out parameters of the robot.
    let (placed, robot): (Vec<usize>, Vec<usize>) = eligible.iter().partition(|&&column| about[column].placed);
    let relative = match criterion {
        Criterion::Relative(tolerance) => tolerance,
        Criterion::Noise | Criterion::NoiseTimes(_) => DEFAULT_TOLERANCE,
    };
    let placed = shown(&columns, placed, relative);
    let eligible = [placed, robot].concat();
    let mut kept: Vec<usize> = match criterion {
        Criterion::Relative(tolerance) => {
            let count = shown(&columns, eligible.clone(), tolerance).len();
            let position = eligible.iter().enumerate();
            position.filter(|&(k, &column)| k < count || about[column].first).map(|(_, &column)| column).collect()
        }
        Criterion::Noise | Criterion::NoiseTimes(_) => {
            let noise = if let Criterion::NoiseTimes(factor) = criterion { factor } else { 1.0 };
            let seen = |column: usize| remainder[column] * columns.norms[column] * about[column].tolerance >= noise;
            eligible.iter().copied().filter(|&column| about[column].first || seen(column)).collect()
        }
    };
    kept.sort_unstable();
    let why = |column: usize| match chosen.contains(&column) {
        false => Why::Exact,
        true if about[column].held => Why::Held,
        true => Why::Weak,
    };
    let is_dropped = |column: &usize| kept.binary_search(column).is_err();
    let dropped: Vec<(usize, Why)> = (0..about.len()).filter(is_dropped).map(|column| (column, why(column))).collect();
    let singular_values = singular_values(&columns.choose(&kept)).unwrap_or_default();
    let (condition, observability) = indices(&singular_values, columns.rows).unzip();
    let tolerance = match criterion {
        Criterion::Relative(tolerance) => Some(tolerance),
        Criterion::Noise | Criterion::NoiseTimes(_) => None,
    };
    Identifiability {
        columns: about.len(),
        rank: chosen.len(),
        combinations: combine(&columns, &kept, &dropped),
        kept,
        dropped,
        remainder,
        singular_values,
        condition,
        observability,
        tolerance,
    }
}

/// As many of some columns, in their order of choice, as their matrix has singular values of at least a fraction of the
/// first.
fn shown(columns: &Columns, mut chosen: Vec<usize>, fraction: f64) -> Vec<usize> {
    let values = singular_values(&columns.choose(&chosen)).unwrap_or_default();
    let least = fraction * values.first().copied().unwrap_or(0.0);
    chosen.truncate(values.iter().filter(|value| **value >= least).count());
    chosen
}

/// As [`independent`], where no parameter of the robot stands for another of which it would have to move by many more tolerances.
fn by_tolerance(columns: &Columns, about: &[Column]) -> (Vec<usize>, Vec<f64>) {
    let mut is_given_up = vec![false; about.len()];
    let (mut chosen, mut remainder) = independent(columns, about, &is_given_up);
    // Each exchange gives one up for good.
    while let Some(given_up) = exchanged(columns, about, (&chosen, &remainder), &is_given_up) {
        is_given_up[given_up] = true;
        (chosen, remainder) = independent(columns, about, &is_given_up);
    }
    (chosen, remainder)
}

/// The chosen parameter of the robot that would have to move by most tolerances to stand for one that is exactly dependent and
/// was not given up; `None` where none would by many.
fn exchanged(
    columns: &Columns,
    about: &[Column],
    (chosen, remainder): (&[usize], &[f64]),
    is_given_up: &[bool],
) -> Option<usize> {
    let is_robots =
        |j: usize| !about[j].first && !about[j].held && about[j].tolerance > 0.0 && about[j].tolerance.is_finite();
    let is_merged = |&j: &usize| is_robots(j) && !columns.is_zero(j) && !is_given_up[j] && !chosen.contains(&j);
    let merged: Vec<usize> = (0..about.len()).filter(is_merged).collect();
    if merged.is_empty() || chosen.is_empty() {
        return None;
    }
    let factors = PivotedQr::new(columns.choose(chosen)).solve(chosen.len(), columns.choose(&merged));
    let tolerances = |(i, &own): (usize, &usize)| {
        let of = |(k, &other): (usize, &usize)| {
            let moved = factors[(i, k)] * columns.scale[own] / columns.scale[other];
            moved.abs() * about[other].tolerance / about[own].tolerance
        };
        (own, merged.iter().enumerate().map(of).fold(0.0, f64::max))
    };
    let is_plain = |(_, own): &(usize, &usize)| is_robots(**own) && remainder[**own] > PLAIN;
    let all = chosen.iter().enumerate().filter(is_plain).map(tolerances);
    all.filter(|(_, most)| *most > MORE_TOLERANCES).max_by(|a, b| a.1.total_cmp(&b.1)).map(|(own, _)| own)
}

/// Columns that are not exactly dependent, but for those given up, in the order of choice, and of every column the part of its length
/// that those chosen before it leave.
fn independent(columns: &Columns, about: &[Column], is_given_up: &[bool]) -> (Vec<usize>, Vec<f64>) {
    let n = about.len();
    let (mut chosen, mut left) = (Vec::new(), vec![0.0; n]);
    let mut basis = DMatrix::<f64>::zeros(n, 0);
    let bias = |column: usize| about[column].preference * (1.0 + TIE * column as f64);
    // Base and tool first, then what else comes before the robot, the robot, what is held (to know whether it is exactly dependent). A base
    // that moves with unknown sockets or anchors stays where it is declared: it comes behind these.
    let has_unknown = about.iter().any(|column| column.referred_to && !column.held);
    for class in 0..5 {
        let class_of = |column: &Column| match column {
            Column { held: true, .. } => 4,
            Column { of_base: true, .. } if has_unknown => 2,
            Column { placed: true, .. } => 0,
            Column { first: true, .. } => 1,
            _ => 3,
        };
        let is_candidate = |&j: &usize| class_of(&about[j]) == class && !columns.is_zero(j) && !is_given_up[j];
        let candidates: Vec<usize> = (0..n).filter(is_candidate).collect();
        let mut biased = project_off(&columns.choose(&candidates), &basis);
        for (mut column, &candidate) in biased.column_iter_mut().zip(&candidates) {
            column *= bias(candidate);
        }
        let qr = PivotedQr::new(biased);
        let mut added = 0;
        for (k, (&position, size)) in qr.order().iter().zip(qr.added()).enumerate() {
            let column = candidates[position];
            left[column] = size / (bias(column) * columns.scale[column] * columns.norms[column]);
            if left[column] > EXACT {
                chosen.push(column);
                added = k + 1;
            }
        }
        let known = basis.ncols();
        basis = basis.resize_horizontally(known + added, 0.0);
        basis.columns_mut(known, added).copy_from(&qr.basis(added));
    }
    (chosen, left)
}

/// What each of the columns `kept` of an observation matrix takes over of those that are `dropped`, as
/// [`Identifiability::combinations`]: for a reduction that was made elsewhere, at other values of the parameters.
pub fn merged(
    matrix: &[f64],
    about: &[Column],
    kept: &[usize],
    dropped: &[(usize, Why)],
) -> Vec<(usize, Vec<(usize, f64)>)> {
    combine(&Columns::new(matrix, about, Scaling::Norm), kept, dropped)
}

/// What each kept parameter took over, by least squares of the dropped columns on the kept ones.
fn combine(columns: &Columns, kept: &[usize], dropped: &[(usize, Why)]) -> Vec<(usize, Vec<(usize, f64)>)> {
    let explained: Vec<usize> =
        dropped.iter().map(|(column, _)| *column).filter(|&column| !columns.is_zero(column)).collect();
    if kept.is_empty() || explained.is_empty() {
        return Vec::new();
    }
    let right = columns.choose(&explained);
    let lengths: Vec<f64> = right.column_iter().map(|column| column.norm()).collect();
    let factors = PivotedQr::new(columns.choose(kept)).solve(kept.len(), right);
    let terms = |(i, &keeper): (usize, &usize)| {
        let share = |(k, &column): (usize, &usize)| {
            let factor = factors[(i, k)];
            let ratio = columns.scale[keeper] / columns.scale[column];
            (factor.abs() > NEGLIGIBLE * lengths[k]).then_some((column, factor * ratio))
        };
        let terms: Vec<(usize, f64)> = explained.iter().enumerate().filter_map(share).collect();
        (!terms.is_empty()).then_some((keeper, terms))
    };
    kept.iter().enumerate().filter_map(terms).collect()
}

/// Condition number and O1..O5: (product)^(1/n) / sqrt(rows), last / first, last, last^2 / first, 1 / sum of inverses.
/// `None` where there are no columns, or where one of them is nothing.
fn indices(singular_values: &[f64], rows: usize) -> Option<(f64, [f64; 5])> {
    let (&first, &last) = (singular_values.first()?, singular_values.last()?);
    let n = singular_values.len() as f64;
    let mean_log = singular_values.iter().map(|s| s.ln()).sum::<f64>() / n;
    let inverse: f64 = singular_values.iter().map(|s| 1.0 / s).sum();
    let all = [mean_log.exp() / (rows as f64).sqrt(), last / first, last, last * last / first, 1.0 / inverse];
    let condition = first / last;
    (condition.is_finite() && all.iter().all(|index| index.is_finite())).then_some((condition, all))
}
