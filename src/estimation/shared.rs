//! Errors that the readings of one configuration share: how rows go together, and how large the shared parts are.
//!
//! # Model
//! Weighted residuals of a fit are `r = P e`, with `P = I - U U'` off the columns of the Jacobian and
//!
//! ```text
//!   e = e_0 + sum_i Z_i u_i,      cov(e_0) = s^2 I,   cov(u_i) = t_i I
//! ```
//!
//! Parts `i`, as far as the campaign has them: each coordinate of a *point* (repeats at one configuration under one load
//! share it), each coordinate of a *configuration* (its points share a shift), and a *turn* of the configuration (its points
//! are displaced as parts of one body, by the leverage of each about their mean). A robot that stands elsewhere than its
//! joints say, and a model that misses something, leave such errors; repeats do not average them out.
//!
//! # Estimates
//! `s^2` is the mean square of what columns and parts together do not explain. The mean square of what the parts explain
//! beyond the columns is compared with it: the exact F test of variance components (Wald 1947; Seely and El-Bassiouni, *Ann.
//! Statist.* 11, 1983). Errors with heavy tails scatter its ratio more, as far as rows count unequally in the two mean squares: with
//! these as `e' A e / a` and `e' B e / b`, and excess kurtosis k of the errors, the variance of their difference is greater by the
//! factor
//!
//! ```text
//!   f = 1 + k sum_i (A_ii / a - B_ii / b)^2 / (2 / a + 2 / b)
//! ```
//!
//! (Atiqullah, *Biometrika* 49, 1962), and the test has a / f and b / f degrees of freedom (Box and Andersen, *J. R. Stat. Soc. B*
//! 17, 1955, who find them so close to the test by permutation). The `t_i` follow from the method of moments, `E |Z_i' r|^2 = sum_j t_j |Z_i' P Z_j|^2 + s^2 tr(Z_i' P
//! Z_i)` (Searle, Casella and McCulloch, *Variance Components*, 1992, chapter 5); a negative one is zero.

use std::collections::{BTreeMap, HashMap};
use std::hash::Hash;

use nalgebra::{DMatrix, DVector, Vector3};

use crate::description::campaign::{Campaign, Reading, point_of};
use crate::math::linear::PivotedQr;
use crate::math::quantiles::f_tail;
use crate::observation::MOST_ROWS;

/// A column that loses all but this part of its length to others counts as dependent.
const DEPENDENT: f64 = 1e-7;
/// Where the F test of shared parts has a greater chance than this they count as none. Of preliminary tests of whether mean
/// squares may be pooled, those at the 25 % level keep the level of what follows best (Bozivich, Bancroft and Hartley, *Ann. Math.
/// Statist.* 27, 1956).
const POOLED: f64 = 0.25;
/// A mean leverage (m) below which points are one point.
const LEAST_LEVERAGE: f64 = 1e-4;

/// A matrix Z of which every row has at most two entries: columns and values.
#[derive(Debug, Clone)]
struct Part {
    columns: usize,
    entries: Vec<[(usize, f64); 2]>,
}

/// How the rows of a campaign go together.
#[derive(Debug, Clone)]
pub struct Sharing {
    /// By row: the point that it is a coordinate of; other numbers for rows that are alone.
    points: Vec<usize>,
    /// By row: the coordinate of the configuration.
    configurations: Vec<usize>,
    /// Whether some point was read twice, and whether some configuration has several points.
    has: [bool; 2],
    /// The turn, if points of a configuration lie apart.
    turn: Option<Part>,
}

/// Shared errors of a fit, all in standard deviations of what was stated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SharedError {
    /// Standard deviation of what the readings of a configuration share, root mean square over the rows.
    pub shared: f64,
    /// Standard deviation of what each row has for itself.
    pub own: f64,
    /// Mean square of the shared part over that of the rest, with its degrees of freedom.
    pub ratio: f64,
    /// Of the numerator: configurations less parameters.
    pub between: f64,
    /// Of the denominator: readings within configurations.
    pub within: f64,
    /// Probability of such a ratio where nothing is shared.
    pub p: f64,
}

/// The variance components of a fit, and what they add to a covariance.
pub struct Components {
    /// What is to be said of them.
    pub error: SharedError,
    /// s^2.
    pub own: f64,
    /// `sum_i t_i U' Z_i Z_i' U`, of the orthonormal columns U.
    pub between: DMatrix<f64>,
}

/// Numbers different things in the order in which they appear.
fn numbered<K: Hash + Eq>(keys: impl Iterator<Item = K>) -> (Vec<usize>, usize) {
    let mut known: HashMap<K, usize> = HashMap::new();
    let numbers = keys
        .map(|key| {
            let next = known.len();
            *known.entry(key).or_insert(next)
        })
        .collect();
    (numbers, known.len())
}

impl Sharing {
    /// Of the rows of a campaign's readings, none a copy of another; `None` where no configuration has two readings.
    pub fn of(campaign: &Campaign) -> Option<Self> {
        let first = campaign.neighbourhoods();
        let of_reading = |reading: &Reading| first[reading.pose];
        let mut count = vec![0_usize; campaign.poses.len()];
        campaign.readings.iter().for_each(|reading| count[of_reading(reading)] += 1);
        if count.iter().all(|count| *count < 2) {
            return None;
        }
        let (points, known) =
            numbered(campaign.readings.iter().map(|reading| (of_reading(reading), point_of(reading))));
        // Points of one kind, with the same axes, share a configuration.
        let (groups, several) = numbered(
            campaign.readings.iter().map(|reading| (of_reading(reading), reading.observes.name(), reading.target)),
        );
        let rows = |of: &[usize]| -> Vec<usize> {
            let own = campaign.readings.iter().zip(of);
            own.flat_map(|(reading, &k)| (0..reading.observes.rows()).map(move |row| MOST_ROWS * k + row)).collect()
        };
        let is_read_twice = known < campaign.readings.len();
        let mut alone = vec![usize::MAX; several];
        let mut has_several = false;
        for (&group, &point) in groups.iter().zip(&points) {
            has_several |= alone[group] != usize::MAX && alone[group] != point;
            alone[group] = point;
        }
        Some(Self {
            points: rows(&points),
            configurations: rows(&groups),
            has: [is_read_twice, has_several],
            turn: has_several.then(|| turn(campaign, &groups, &points)).flatten(),
        })
    }

    /// Variance components of a fit: of its weighted residuals (m), of orthonormal columns (m x k) that span those of its
    /// weighted Jacobian, and the square roots of the weights (m, zero of what counts for nothing). Rows beyond those of
    /// readings are alone. `None` where no part is positive or nothing tells.
    pub fn components(&self, residual: &DVector<f64>, basis: &DMatrix<f64>, scales: &[f64]) -> Option<Components> {
        let parts = self.parts(scales);
        let rows = residual.len();
        let counted = scales.iter().filter(|scale| **scale > 0.0).count() as f64;
        // What columns and parts together leave.
        let (mut left, mut columns) = (DMatrix::from_column_slice(rows, 1, residual.as_slice()), basis.clone());
        let mut leverage = vec![0.0; rows];
        let explained = self.project_off(&parts, &mut [&mut left, &mut columns], scales, &mut leverage);
        let qr = PivotedQr::new(columns);
        let rank = qr.rank(DEPENDENT);
        let span = qr.basis(rank);
        let rest = (left.norm_squared() - span.tr_mul(&left).norm_squared()).max(0.0);
        let within = counted - explained as f64 - rank as f64;
        let between = counted - basis.ncols() as f64 - within;
        if within < 1.0 || between < 1.0 {
            return None;
        }
        let own = rest / within;
        let explained = ((residual.norm_squared() - rest) / between).max(0.0);
        let ratio = explained / own;
        let (sizes, matrices) = variances(&parts, residual, basis, own)?;
        let mut sum = DMatrix::zeros(basis.ncols(), basis.ncols());
        let mut shared = 0.0;
        for ((size, matrix), part) in sizes.iter().zip(&matrices).zip(&parts) {
            sum += matrix * *size;
            let entries = part.entries.iter().flatten().map(|(_, value)| value * value).sum::<f64>();
            shared += size * entries / counted;
        }
        // Diagonals of the two mean squares.
        let diagonals: Vec<[f64; 2]> = (0..rows)
            .filter(|&row| scales[row] > 0.0)
            .map(|row| {
                let [free, rest] = [basis.row(row).norm_squared(), leverage[row] + span.row(row).norm_squared()];
                [rest - free, 1.0 - rest]
            })
            .collect();
        let squares = residual.iter().zip(scales).filter(|(_, scale)| **scale > 0.0).map(|(r, _)| r * r);
        let heavier = heavier(&squares.collect::<Vec<_>>(), &diagonals, [between, within]);
        let p = f_tail(ratio, between / heavier, within / heavier);
        let error = SharedError { shared: shared.sqrt(), own: own.sqrt(), ratio, between, within, p };
        (shared > 0.0 && p <= POOLED).then_some(Components { error, own, between: sum })
    }

    /// The parts that the campaign has, each row times its scale.
    fn parts(&self, scales: &[f64]) -> Vec<Part> {
        let labelled = |labels: &[usize]| {
            let (numbers, columns) = numbered(labels.iter());
            let entry = |(row, scale): (usize, &f64)| match numbers.get(row) {
                Some(&number) => [(number, *scale), (0, 0.0)],
                None => [(0, 0.0); 2],
            };
            Part { columns, entries: scales.iter().enumerate().map(entry).collect() }
        };
        let mut parts = Vec::new();
        if self.has[0] {
            parts.push(labelled(&self.points));
        }
        if self.has[1] {
            parts.push(labelled(&self.configurations));
            parts.extend(self.turn.as_ref().map(|turn| {
                let known = turn.entries.iter().copied().chain(std::iter::repeat([(0, 0.0); 2]));
                let entries = known.zip(scales).map(|(entries, scale)| entries.map(|(k, value)| (k, value * scale)));
                Part { columns: turn.columns, entries: entries.collect() }
            }));
        }
        parts
    }

    /// Takes the span of all parts off the columns of some matrices; its dimension, and to each row's leverage its own.
    /// Where points are read twice, the span of the points holds the others.
    fn project_off(
        &self,
        parts: &[Part],
        matrices: &mut [&mut DMatrix<f64>],
        scales: &[f64],
        leverage: &mut [f64],
    ) -> usize {
        let Some((first, others)) = parts.split_first() else { return 0 };
        let mut lengths = vec![0.0; first.columns];
        for [(column, value), _] in &first.entries {
            lengths[*column] += value * value;
        }
        let mut explained = lengths.iter().filter(|length| **length > 0.0).count();
        let means = |matrix: &mut DMatrix<f64>| {
            let sums = first.transposed(matrix);
            for column in 0..matrix.ncols() {
                for (row, [(label, value), _]) in first.entries.iter().enumerate() {
                    matrix[(row, column)] -= value * sums[(*label, column)] / lengths[*label].max(f64::MIN_POSITIVE);
                }
            }
        };
        matrices.iter_mut().for_each(|matrix| means(matrix));
        for (own, [(label, value), _]) in leverage.iter_mut().zip(&first.entries) {
            *own += value * value / lengths[*label].max(f64::MIN_POSITIVE);
        }
        if let Some(turn) = others.last().filter(|_| self.turn.is_some() && !self.has[0]) {
            explained += project_turns_off(turn, first, &lengths, matrices, scales, leverage);
        }
        explained
    }
}

/// The same of the turns of configurations, less the means of the `first` part, whose columns have these squared lengths: three
/// columns for each configuration, on rows of its own.
fn project_turns_off(
    turn: &Part,
    first: &Part,
    lengths: &[f64],
    matrices: &mut [&mut DMatrix<f64>],
    scales: &[f64],
    leverage: &mut [f64],
) -> usize {
    let mut explained = 0;
    let mut members: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for (row, entries) in turn.entries.iter().enumerate().filter(|(row, _)| scales[*row] > 0.0) {
        if let Some((column, _)) = entries.iter().find(|(_, value)| *value != 0.0) {
            members.entry(column / 3).or_default().push(row);
        }
    }
    for (configuration, rows) in members {
        let mut own = DMatrix::zeros(rows.len(), 3);
        for (k, &row) in rows.iter().enumerate() {
            for (column, value) in turn.entries[row].iter().filter(|(_, value)| *value != 0.0) {
                own[(k, column - 3 * configuration)] += value;
            }
        }
        let size = own.norm();
        let label = |row: usize| first.entries[row][0];
        let mut sums: BTreeMap<usize, [f64; 3]> = BTreeMap::new();
        for (k, &row) in rows.iter().enumerate() {
            let sum = sums.entry(label(row).0).or_default();
            (0..3).for_each(|column| sum[column] += label(row).1 * own[(k, column)]);
        }
        for (k, &row) in rows.iter().enumerate() {
            let (number, value) = label(row);
            let Some(sum) = sums.get(&number) else { continue };
            (0..3).for_each(|column| own[(k, column)] -= value * sum[column] / lengths[number]);
        }
        let qr = PivotedQr::new(own);
        let rank = qr.rank(DEPENDENT * size);
        let basis = qr.basis(rank);
        explained += rank;
        rows.iter().enumerate().for_each(|(k, &row)| leverage[row] += basis.row(k).norm_squared());
        for matrix in matrices.iter_mut() {
            let mut part = matrix.select_rows(&rows);
            part -= &basis * basis.tr_mul(&part);
            for (k, &row) in rows.iter().enumerate() {
                matrix.set_row(row, &part.row(k));
            }
        }
    }
    explained
}

impl Part {
    /// `Z' x` (columns x any).
    fn transposed(&self, x: &DMatrix<f64>) -> DMatrix<f64> {
        let mut found = DMatrix::zeros(self.columns, x.ncols());
        for column in 0..x.ncols() {
            for (row, entries) in self.entries.iter().enumerate() {
                for (k, value) in entries {
                    found[(*k, column)] += value * x[(row, column)];
                }
            }
        }
        found
    }

    /// Entries of `Z' other`.
    fn times(&self, other: &Self) -> BTreeMap<(usize, usize), f64> {
        let mut found = BTreeMap::new();
        for (own, theirs) in self.entries.iter().zip(&other.entries) {
            for (i, a) in own.iter().filter(|(_, a)| *a != 0.0) {
                for (j, b) in theirs.iter().filter(|(_, b)| *b != 0.0) {
                    *found.entry((*i, *j)).or_insert(0.0) += a * b;
                }
            }
        }
        found
    }
}

/// By how much heavy tails widen the ratio of two mean squares, 1 or more: of the squares of residuals, of the diagonals of
/// both and of their dimensions. The kurtosis is that of the residuals by `E r_i^4 = 3 s^4 P_ii^2 + k s^4 sum_j P_ij^4`, of
/// which sum the diagonal is taken.
fn heavier(squares: &[f64], diagonals: &[[f64; 2]], [a, b]: [f64; 2]) -> f64 {
    let variance = squares.iter().sum::<f64>() / (a + b);
    let power = |k: i32| diagonals.iter().map(|[own, rest]| (own + rest).powi(k)).sum::<f64>();
    let fourth = squares.iter().map(|square| (square / variance).powi(2)).sum::<f64>();
    let kurtosis = ((fourth - 3.0 * power(2)) / power(4)).max(0.0);
    let unequal: f64 = diagonals.iter().map(|[own, rest]| (own / a - rest / b).powi(2)).sum();
    let factor = 1.0 + kurtosis * unequal / (2.0 / a + 2.0 / b);
    if factor.is_finite() { factor } else { 1.0 }
}

/// Variances `t_i` of the parts by the method of moments, none negative, and `U' Z_i Z_i' U` of each; `None` where all are
/// zero or nothing tells them.
fn variances(
    parts: &[Part],
    residual: &DVector<f64>,
    basis: &DMatrix<f64>,
    own: f64,
) -> Option<(Vec<f64>, Vec<DMatrix<f64>>)> {
    let count = parts.len();
    let residual = DMatrix::from_column_slice(residual.len(), 1, residual.as_slice());
    let on_basis: Vec<DMatrix<f64>> = parts.iter().map(|part| part.transposed(basis)).collect();
    let gram: Vec<DMatrix<f64>> = on_basis.iter().map(|own| own.tr_mul(own)).collect();
    let mut moments = DMatrix::zeros(count, count);
    let mut right = DVector::zeros(count);
    for i in 0..count {
        let entries: f64 = parts[i].entries.iter().flatten().map(|(_, value)| value * value).sum();
        right[i] = parts[i].transposed(&residual).norm_squared() - own * (entries - on_basis[i].norm_squared());
        for j in 0..=i {
            // |Z_i' (I - U U') Z_j|^2
            let mut size = gram[i].dot(&gram[j]);
            for ((a, b), value) in parts[i].times(&parts[j]) {
                size += value * value - 2.0 * value * on_basis[i].row(a).dot(&on_basis[j].row(b));
            }
            (moments[(i, j)], moments[(j, i)]) = (size, size);
        }
    }
    let mut active: Vec<usize> = (0..count).filter(|&i| moments[(i, i)] > 0.0).collect();
    let mut sizes = vec![0.0; count];
    while !active.is_empty() {
        let square = DMatrix::from_fn(active.len(), active.len(), |i, j| moments[(active[i], active[j])]);
        let scale = square.diagonal().map(|value| value.sqrt().recip());
        let scaled = DMatrix::from_fn(active.len(), active.len(), |i, j| square[(i, j)] * scale[i] * scale[j]);
        let wanted = DVector::from_fn(active.len(), |i, _| right[active[i]] * scale[i]);
        let solved = scaled.clone().cholesky().filter(|factor| factor.l_dirty().diagonal().min() > 1e-4);
        let found = solved.map(|factor| factor.solve(&wanted));
        // Parts that cannot be told apart are one: the last goes.
        let Some(found) = found else {
            active.pop();
            continue;
        };
        let (least, value) = found.argmin();
        if value < 0.0 {
            active.remove(least);
            continue;
        }
        active.iter().enumerate().for_each(|(k, &i)| sizes[i] = found[k] * scale[k]);
        return Some((sizes, gram));
    }
    None
}

/// The turn of each configuration's points about their mean, in units of the mean leverage; `None` where they coincide.
fn turn(campaign: &Campaign, groups: &[usize], points: &[usize]) -> Option<Part> {
    let is_point = |reading: &Reading| reading.observes.length_rows() == 3 && !reading.observes.is_difference();
    let place = |reading: &Reading| Vector3::from_column_slice(&reading.measured[..3]);
    // Where each point was read first, and the mean of a configuration's points.
    let mut first: HashMap<usize, Vector3<f64>> = HashMap::new();
    let mut sums: HashMap<usize, (Vector3<f64>, f64)> = HashMap::new();
    for ((reading, group), point) in campaign.readings.iter().zip(groups).zip(points) {
        if is_point(reading) && !first.contains_key(point) {
            first.insert(*point, place(reading));
            let sum = sums.entry(*group).or_insert((Vector3::zeros(), 0.0));
            *sum = (sum.0 + place(reading), sum.1 + 1.0);
        }
    }
    let leverage = |group: &usize, point: &usize| match (sums.get(group), first.get(point)) {
        (Some((sum, count)), Some(at)) => at - sum / *count,
        _ => Vector3::zeros(),
    };
    let squares: f64 = groups.iter().zip(points).map(|(group, point)| leverage(group, point).norm_squared()).sum();
    let mean = (squares / groups.len().max(1) as f64).sqrt();
    if mean < LEAST_LEVERAGE {
        return None;
    }
    let mut entries = Vec::new();
    for ((reading, group), point) in campaign.readings.iter().zip(groups).zip(points) {
        let [x, y, z] = (leverage(group, point) / mean).into();
        let [a, b, c] = [3 * group, 3 * group + 1, 3 * group + 2];
        let rows = [[(b, z), (c, -y)], [(a, -z), (c, x)], [(a, y), (b, -x)]];
        let none = [(0, 0.0); 2];
        let own = (0..reading.observes.rows())
            .map(|row| if is_point(reading) { *rows.get(row).unwrap_or(&none) } else { none });
        entries.extend(own);
    }
    let columns = 3 * (1 + groups.iter().copied().max().unwrap_or(0));
    Some(Part { columns, entries })
}
