//! Conclusions in closed form.

use nalgebra::{DMatrix, DVector};

use super::grow::Grown;
use super::samples::Samples;
use crate::description::fuzzy::{Component, Fuzzy, Input};
use crate::fuzzy::firing;
use crate::least_squares::{Bounds, minimize_in_box};

/// Modal values by input, rad or m; one where the input has no say.
pub type Partition = Vec<Vec<f64>>;

/// Weight of the difference between neighbouring conclusions beside the readings of a rule.
const SMOOTH: f64 = 1e-3;
/// Folds of the cross-validation.
const FOLDS: usize = 5;

/// Number of rules of a partition.
pub fn rules(modes: &[Vec<f64>]) -> usize {
    modes.iter().map(Vec::len).product()
}

/// Where the rules of each component of the load begin, and how many there are.
fn starts(parts: &[Partition]) -> (Vec<usize>, usize) {
    let mut sum = 0;
    let mut starts = Vec::with_capacity(parts.len());
    for modes in parts {
        starts.push(sum);
        sum += rules(modes);
    }
    (starts, sum)
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

/// What is fitted by itself: one displacement component under load components that act together in some readings.
pub struct Group<'a> {
    pub samples: &'a Samples,
    /// Displacement component: x, y, z.
    pub axis: usize,
    /// Components of the load.
    pub columns: Vec<usize>,
    /// Readings that these load: fitted, and set aside.
    pub fitted: Vec<usize>,
    pub test: Vec<usize>,
}

impl<'a> Group<'a> {
    /// Groups of all displacement components.
    pub fn all(samples: &'a Samples) -> Vec<Self> {
        let mut together: Vec<Vec<usize>> = Vec::new();
        for &column in &samples.columns {
            let with = |others: &Vec<usize>| {
                others.iter().any(|&other| samples.load.iter().any(|load| load[column] != 0.0 && load[other] != 0.0))
            };
            let (joined, apart): (Vec<_>, Vec<_>) = together.into_iter().partition(with);
            together = apart;
            together.push(joined.into_iter().flatten().chain([column]).collect());
        }
        together.sort();
        let of = |columns: &[usize], aside: bool| {
            samples.indices(aside, |k| columns.iter().any(|&column| samples.load[k][column] != 0.0))
        };
        let group = |axis: usize, columns: &Vec<usize>| Self {
            samples,
            axis,
            fitted: of(columns, false),
            test: of(columns, true),
            columns: columns.clone(),
        };
        (0..3).flat_map(|axis| together.iter().map(move |columns| group(axis, columns))).collect()
    }

    /// Rules that fire under a load, by column of the linear problem, with what they give for a conclusion of one.
    fn terms(&self, parts: &[Partition], starts: &[usize], k: usize, each: &mut dyn FnMut(usize, f64)) {
        for (j, (&column, modes)) in self.columns.iter().zip(parts).enumerate() {
            let load = self.samples.load[k][column];
            if load != 0.0 {
                firing(modes, &self.samples.x[k], &mut |rule, weight| each(starts[j] + rule, weight * load));
            }
        }
    }

    /// Differences of neighbouring conclusions that count as readings of zero: columns, and their weight. A rule that
    /// hardly fires is tied to its neighbours by as much as it lacks of one reading, or noise would make up its conclusion.
    fn smoothing(&self, parts: &[Partition], starts: &[usize], of: &[usize]) -> Vec<([usize; 2], f64)> {
        let one = |(j, (&column, modes)): (usize, (&usize, &Partition))| {
            let mut support = vec![0.0; rules(modes)];
            let (mut squares, mut loaded) = (0.0, 0.0);
            for &k in of.iter().filter(|&&k| self.samples.load[k][column] != 0.0) {
                firing(modes, &self.samples.x[k], &mut |rule, weight| support[rule] += weight);
                squares += self.samples.load[k][column].powi(2);
                loaded += 1.0;
            }
            let least = SMOOTH * (squares / rules(modes) as f64).sqrt();
            let reading = (squares / f64::max(loaded, 1.0)).sqrt();
            let start = starts[j];
            neighbours(modes).into_iter().map(move |[one, other]| {
                let lacking = 1.0 - support[one].min(support[other]);
                ([start + one, start + other], least.max(reading * lacking))
            })
        };
        self.columns.iter().zip(parts).enumerate().flat_map(one).collect()
    }

    /// The conclusions that leave least of the samples `of`: rules of each component of the load in turns.
    pub fn solve(&self, parts: &[Partition], of: &[usize]) -> DVector<f64> {
        // Each reading has few rules that fire: the normal equations are summed without their rows.
        let (starts, width) = starts(parts);
        let mut normal = DMatrix::<f64>::zeros(width, width);
        let mut right = DVector::zeros(width);
        let mut fired: Vec<(usize, f64)> = Vec::new();
        for &k in of {
            fired.clear();
            self.terms(parts, &starts, k, &mut |column, weight| fired.push((column, weight)));
            for &(a, by) in &fired {
                right[a] += by * self.samples.d[k][self.axis];
                fired.iter().for_each(|&(b, weight)| normal[(a, b)] += by * weight);
            }
        }
        for ([a, b], size) in self.smoothing(parts, &starts, of) {
            let square = size * size;
            normal[(a, a)] += square;
            normal[(b, b)] += square;
            normal[(a, b)] -= square;
            normal[(b, a)] -= square;
        }
        let ridge = 1e-12 * normal.trace().max(f64::MIN_POSITIVE) / width as f64;
        (0..width).for_each(|k| normal[(k, k)] += ridge);
        normal.cholesky().map_or_else(|| DVector::zeros(width), |factor| factor.solve(&right))
    }

    /// The same with direct compliances (displacement along the load) not negative.
    pub fn solve_bounded(&self, parts: &[Partition], of: &[usize]) -> DVector<f64> {
        let b = self.solve(parts, of);
        let (starts, width) = starts(parts);
        let Some(j) = self.columns.iter().position(|column| *column == self.axis) else { return b };
        let direct = starts[j]..starts[j] + rules(&parts[j]);
        if b.as_slice()[direct.clone()].iter().all(|conclusion| *conclusion >= 0.0) {
            return b;
        }
        let lower = (0..width).map(|k| if direct.contains(&k) { 0.0 } else { f64::NEG_INFINITY }).collect();
        let bounds = Bounds { lower, upper: vec![f64::INFINITY; width] };
        let smoothing = self.smoothing(parts, &starts, of);
        let mut a = DMatrix::<f64>::zeros(of.len() + smoothing.len(), width);
        for (row, &k) in of.iter().enumerate() {
            self.terms(parts, &starts, k, &mut |column, weight| a[(row, column)] = weight);
        }
        for (row, ([one, other], size)) in smoothing.into_iter().enumerate() {
            a[(of.len() + row, one)] = size;
            a[(of.len() + row, other)] = -size;
        }
        let right = DVector::from_fn(a.nrows(), |i, _| of.get(i).map_or(0.0, |&k| -self.samples.d[k][self.axis]));
        minimize_in_box(&a, &right, &bounds).unwrap_or(b)
    }

    /// What is left of samples, m.
    pub fn left(&self, parts: &[Partition], b: &DVector<f64>, of: &[usize]) -> Vec<f64> {
        let (starts, _) = starts(parts);
        let one = |&k: &usize| {
            let mut d = self.samples.d[k][self.axis];
            self.terms(parts, &starts, k, &mut |column, weight| d -= weight * b[column]);
            d
        };
        of.iter().map(one).collect()
    }
}

/// Conclusions of each component of the load.
pub fn split(parts: &[Partition], b: &DVector<f64>) -> Vec<Vec<f64>> {
    let (starts, _) = starts(parts);
    let own = |(start, modes): (&usize, &Partition)| b.as_slice()[*start..start + rules(modes)].to_vec();
    starts.iter().zip(parts).map(own).collect()
}

/// Root mean square.
pub fn rms(left: &[f64]) -> f64 {
    (left.iter().map(|v| v * v).sum::<f64>() / left.len().max(1) as f64).sqrt()
}

/// Root mean square error (distance) of the fitted samples when parts of the configurations are left out in turns, m:
/// with no rules, and with these.
pub fn cross_validated(samples: &Samples, grown: &Grown) -> [f64; 2] {
    let fitted = samples.indices(false, |_| true);
    let mut poses: Vec<usize> = fitted.iter().map(|&k| samples.pose[k]).collect();
    poses.sort_unstable();
    poses.dedup();
    let fold = |k: usize| poses.binary_search(&samples.pose[k]).unwrap_or(0) % FOLDS;
    let (mut without, mut with) = (0.0, 0.0);
    for group in Group::all(samples) {
        let parts = grown.partitions(&group);
        let of = |part: usize, within: bool| -> Vec<usize> {
            group.fitted.iter().copied().filter(|&k| (fold(k) == part) == within).collect()
        };
        for part in 0..FOLDS {
            let b = group.solve_bounded(&parts, &of(part, false));
            with += group.left(&parts, &b, &of(part, true)).iter().map(|v| v * v).sum::<f64>();
        }
        without += group.fitted.iter().map(|&k| samples.d[k][group.axis].powi(2)).sum::<f64>();
    }
    [without, with].map(|squares| (squares / fitted.len().max(1) as f64).sqrt())
}

/// The model that rules make.
pub fn model_of(samples: &Samples, grown: &Grown, inputs: &[Input], adds: bool) -> Fuzzy {
    // An input with one set everywhere has no say.
    let used = grown.used();
    let components = grown.components.iter().map(|component| Component {
        at: component.at,
        modes: used.iter().map(|&k| component.modes[k].clone()).collect(),
        conclusions: component.conclusions.clone(),
    });
    Fuzzy {
        components: components.collect(),
        inputs: used.iter().map(|&k| inputs[k]).collect(),
        at: samples.marker,
        adds,
    }
}
