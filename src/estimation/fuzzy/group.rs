//! Conclusions in closed form: for given partitions a displacement is linear in them.

use nalgebra::{DMatrix, DVector};

use super::partition::{Partition, neighbours, rules, starts};
use super::samples::Samples;
use super::settings::FuzzySettings;
use crate::fuzzy::firing;
use crate::least_squares::{Bounds, minimize_in_box};

/// Ridge of the normal equations as a part of their mean diagonal. It gives zero to conclusions that no reading of a fold
/// loads; all others it changes by less than the readings' last digit.
const RIDGE: f64 = 1e-12;

/// What is fitted by itself: one displacement component under load components that act together in some readings.
pub struct Group<'a> {
    pub samples: &'a Samples,
    pub settings: &'a FuzzySettings,
    /// Displacement component: x, y, z, and about them.
    pub axis: usize,
    /// Components of the load.
    pub columns: Vec<usize>,
    /// Fitted readings that these load.
    pub fitted: Vec<usize>,
    /// Part of the configurations to which each belongs.
    parts: Vec<usize>,
}

impl<'a> Group<'a> {
    /// Groups of all displacement components.
    pub fn all(samples: &'a Samples, settings: &'a FuzzySettings) -> Vec<Self> {
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
        let group = |axis: usize, columns: &Vec<usize>| {
            let fitted = samples.indices(false, |k| columns.iter().any(|&column| samples.load[k][column] != 0.0));
            let parts = samples.parts(&fitted, settings.folds);
            Self { samples, settings, axis, fitted, parts, columns: columns.clone() }
        };
        (0..samples.rows).flat_map(|axis| together.iter().map(move |columns| group(axis, columns))).collect()
    }

    /// Rules that fire under a load, by column of the linear problem, with the displacement of a conclusion of one.
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
            let least = self.settings.smoothing * (squares / rules(modes) as f64).sqrt();
            let reading = (squares / f64::max(loaded, 1.0)).sqrt();
            let start = starts[j];
            neighbours(modes).into_iter().map(move |[one, other]| {
                let lacking = 1.0 - support[one].min(support[other]);
                ([start + one, start + other], least.max(reading * lacking))
            })
        };
        self.columns.iter().zip(parts).enumerate().flat_map(one).collect()
    }

    /// The least-squares conclusions of the samples `of`: rules of the first load component, then of the next.
    ///
    /// By normal equations and not by QR: each reading fires a few rules of many (2 per input), so that they are summed
    /// without forming a row. With 2000 readings and 100 rules this is some 50 times less work than a QR of the rows, and the
    /// search over partitions solves thousands of such problems. The smoothing rows bound the condition number, which normal
    /// equations square: conclusions differ from those of [`Group::solve_bounded`], which forms the rows, by rounding.
    pub fn solve(&self, parts: &[Partition], of: &[usize]) -> DVector<f64> {
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
        let ridge = RIDGE * normal.trace().max(f64::MIN_POSITIVE) / width as f64;
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

    /// Root mean square residual of the fitted samples when parts of the configurations are left out in turns; `placed` puts
    /// the sets where the others want them. `None` where there are too few to leave any out.
    pub fn cross_validated(
        &self,
        parts: &[Partition],
        placed: &dyn Fn(&Self, Vec<Partition>) -> Vec<Partition>,
    ) -> Option<f64> {
        let (_, width) = starts(parts);
        let mut squares = 0.0;
        for part in 0..self.settings.folds {
            let of = |inside: bool| {
                let own = self.fitted.iter().zip(&self.parts).filter(move |(_, own)| (**own == part) == inside);
                own.map(|(k, _)| *k).collect::<Vec<usize>>()
            };
            let (left_out, others) = (of(true), of(false));
            if left_out.is_empty() || others.len() <= width {
                return None;
            }
            let without = Self { fitted: others, columns: self.columns.clone(), parts: Vec::new(), ..*self };
            let parts = placed(&without, parts.to_vec());
            let b = without.solve(&parts, &without.fitted);
            squares += self.residual(&parts, &b, &left_out).iter().map(|v| v * v).sum::<f64>();
        }
        Some((squares / self.fitted.len().max(1) as f64).sqrt())
    }

    /// Residuals of samples, m or rad.
    pub fn residual(&self, parts: &[Partition], b: &DVector<f64>, of: &[usize]) -> Vec<f64> {
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
pub fn rms(values: &[f64]) -> f64 {
    (values.iter().map(|v| v * v).sum::<f64>() / values.len().max(1) as f64).sqrt()
}
