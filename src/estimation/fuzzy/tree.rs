//! Trees of rules, grown split by split.
//!
//! A split of a rule hands its weight on from one half to the other, linearly across the whole cell of the rule along one
//! input, so that a tree of one split is a grid of two sets. Each step takes the split that lowers the squared residual
//! most; how far to go is decided by cross-validation over configurations. The number of rules grows with what the
//! readings show and not with the number of inputs.
//!
//! Source: Nelles and Isermann 1996 (local models by splits along the axes); for the residual after one more column,
//! Golub and Van Loan, *Matrix Computations*, 6.5.

use nalgebra::linalg::Cholesky;
use nalgebra::{DMatrix, DVector, Dyn};
use rayon::prelude::*;

use super::normal::Normal;
use super::settings::FuzzySettings;
use crate::description::fuzzy::{Branch, Split, Tree};
use crate::fuzzy::firing_of_tree;
use crate::least_squares::{Bounds, minimize_in_box};

/// A tree that was tried.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TreeStep {
    /// Number of rules.
    pub rules: usize,
    /// Root mean square residual.
    pub fitted: f64,
    /// The same when parts of the configurations are left out in turns.
    pub cross_validated: f64,
}

/// A grown tree.
#[derive(Debug, Clone)]
pub struct GrownTree {
    pub tree: Tree,
    /// Conclusions of the rules, by quantity.
    pub conclusions: Vec<Vec<f64>>,
    /// Weight of each rule, summed over the configurations.
    pub support: Vec<f64>,
    /// The steps that were kept.
    pub steps: Vec<TreeStep>,
    /// Residual as last judged, squared and summed over configurations left out in turns.
    pub left_out: f64,
}

/// A rule on its way.
#[derive(Debug, Clone)]
struct Leaf {
    /// Weight at each configuration.
    weights: Vec<f64>,
    /// Its cell.
    cell: Vec<[f64; 2]>,
    /// The split and branch that lead to it, and how many splits.
    under: Option<(usize, usize)>,
    depth: usize,
}

/// Conclusions, and what it takes to judge one more split.
struct Fitted {
    factor: Cholesky<f64, Dyn>,
    /// How far the quantities of each rule deviate from the base: rules one after the other.
    deviations: DVector<f64>,
    squares: f64,
    left_out: f64,
}

/// A split that might be next: the rule, the input, and by how much the squares fall.
struct Candidate {
    leaf: usize,
    input: usize,
    gain: f64,
}

struct Growth<'a> {
    normal: &'a Normal,
    settings: &'a FuzzySettings,
    /// Ridge by quantity.
    ridge: Vec<f64>,
    leaves: Vec<Leaf>,
    splits: Vec<Split>,
}

/// Grows a tree over inputs that were measured within `range`.
pub fn grow_tree(
    normal: &Normal,
    range: &[[f64; 2]],
    settings: &FuzzySettings,
    taken: &mut dyn FnMut(&TreeStep),
) -> GrownTree {
    let whole = Leaf { weights: vec![1.0; normal.x.len()], cell: range.to_vec(), under: None, depth: 0 };
    let ridge = ridge(normal, settings);
    let mut growth = Growth { normal, settings, ridge, leaves: vec![whole], splits: Vec::new() };
    let mut steps = Vec::new();
    let mut kept: Option<(Vec<Leaf>, Vec<Split>, Fitted)> = None;
    let mut misses = 0;
    while let Some(fitted) = growth.fitted() {
        let step = growth.step(&fitted);
        let best = kept.as_ref().map_or(f64::INFINITY, |(.., fitted)| fitted.left_out);
        let is_better = fitted.left_out < (1.0 - settings.worth).powi(2) * best;
        let next = growth.best(&fitted);
        if is_better {
            misses = 0;
            taken(&step);
            steps.push(step);
            kept = Some((growth.leaves.clone(), growth.splits.clone(), fitted));
        } else {
            misses += 1;
        }
        match next {
            Some(candidate) if misses <= settings.patience => growth.split(&candidate),
            _ => break,
        }
    }
    let Some((leaves, splits, fitted)) = kept else {
        let conclusions = normal.base.iter().map(|base| vec![*base]).collect();
        let (tree, support) = (Tree::default(), vec![normal.x.len() as f64]);
        return GrownTree { tree, conclusions, support, steps, left_out: normal.square.iter().sum() };
    };
    (growth.leaves, growth.splits) = (leaves, splits);
    growth.finished(&fitted, steps)
}

/// How far the quantities of the rules of a tree are to move for the smallest residual, by quantity. `None` where numbers
/// fail.
pub fn refitted(normal: &Normal, tree: &Tree, settings: &FuzzySettings) -> Option<Vec<Vec<f64>>> {
    let mut leaves = vec![
        Leaf { weights: vec![0.0; normal.x.len()], cell: Vec::new(), under: None, depth: 0 };
        tree.splits.len() + 1
    ];
    for (configuration, x) in normal.x.iter().enumerate() {
        firing_of_tree(tree, x, &mut |rule, weight| leaves[rule].weights[configuration] = weight);
    }
    let ridge = ridge(normal, settings);
    let growth = Growth { normal, settings, ridge, leaves, splits: Vec::new() };
    let (fitted, m) = (growth.fitted()?, normal.quantities());
    let of = |k: usize| (0..growth.leaves.len()).map(|rule| fitted.deviations[rule * m + k]).collect();
    Some((0..m).map(of).collect())
}

/// Ridge of each quantity.
fn ridge(normal: &Normal, settings: &FuzzySettings) -> Vec<f64> {
    normal.mean_diagonal().into_iter().map(|own| (settings.pull * own).max(f64::MIN_POSITIVE)).collect()
}

impl Growth<'_> {
    fn step(&self, fitted: &Fitted) -> TreeStep {
        let rms = |squares: f64| (squares.max(0.0) / self.normal.rows.max(1) as f64).sqrt();
        TreeStep { rules: self.leaves.len(), fitted: rms(fitted.squares), cross_validated: rms(fitted.left_out) }
    }

    /// Conclusions, their squared residual, and that of configurations left out in turns. None where numbers fail.
    fn fitted(&self) -> Option<Fitted> {
        let (m, width) = (self.normal.quantities(), self.leaves.len() * self.normal.quantities());
        let parts = self.settings.folds.clamp(2, self.normal.x.len().max(2));
        let mut sums = vec![(DMatrix::<f64>::zeros(width, width), DVector::<f64>::zeros(width), 0.0); parts];
        for configuration in 0..self.normal.x.len() {
            let (normal, right, square) = &mut sums[configuration % parts];
            let firing: Vec<(usize, f64)> = self.firing(configuration);
            for &(a, by) in &firing {
                right.rows_mut(a * m, m).axpy(by, &self.normal.right[configuration], 1.0);
                for &(b, weight) in &firing {
                    let mut block = normal.view_mut((a * m, b * m), (m, m));
                    block += &self.normal.gram[configuration] * (by * weight);
                }
            }
            *square += self.normal.square[configuration];
        }
        let none = (DMatrix::zeros(width, width), DVector::zeros(width), 0.0);
        let mut all = sums.iter().fold(none, |sum, own| (sum.0 + &own.0, sum.1 + &own.1, sum.2 + own.2));
        for k in 0..width {
            all.0[(k, k)] += self.ridge[k % m];
        }
        let squares = |(normal, right, square): &(DMatrix<f64>, DVector<f64>, f64), c: &DVector<f64>| {
            square - 2.0 * c.dot(right) + c.dot(&(normal * c))
        };
        let mut left_out = 0.0;
        for part in &sums {
            let others = (&all.0 - &part.0).cholesky()?;
            left_out += squares(part, &others.solve(&(&all.1 - &part.1)));
        }
        let factor = all.0.clone().cholesky()?;
        let deviations = factor.solve(&all.1);
        let squares = squares(&all, &deviations);
        Some(Fitted { factor, deviations, squares, left_out: left_out.max(0.0) })
    }

    /// Rules that have weight at a configuration.
    fn firing(&self, configuration: usize) -> Vec<(usize, f64)> {
        let weights = self.leaves.iter().map(|leaf| leaf.weights[configuration]).enumerate();
        weights.filter(|(_, weight)| *weight > 0.0).collect()
    }

    /// The share of a rule's weight that its upper half gets at a configuration.
    fn above(&self, leaf: &Leaf, input: usize, configuration: usize) -> f64 {
        let [low, high] = leaf.cell[input];
        ((self.normal.x[configuration][input] - low) / (high - low)).clamp(0.0, 1.0)
    }

    fn best(&self, fitted: &Fitted) -> Option<Candidate> {
        if 2 * (self.leaves.len() + 1) * self.normal.quantities() > self.normal.rows {
            return None;
        }
        let m = self.normal.quantities();
        let residual: Vec<DVector<f64>> = (0..self.normal.x.len())
            .map(|configuration| {
                let mut deviation = DVector::zeros(m);
                for (rule, weight) in self.firing(configuration) {
                    deviation.axpy(weight, &fitted.deviations.rows(rule * m, m), 1.0);
                }
                &self.normal.right[configuration] - &self.normal.gram[configuration] * deviation
            })
            .collect();
        let inputs = self.leaves.first().map_or(0, |leaf| leaf.cell.len());
        let all: Vec<(usize, usize)> =
            (0..self.leaves.len()).flat_map(|leaf| (0..inputs).map(move |input| (leaf, input))).collect();
        let tried: Vec<Option<Candidate>> = all
            .into_par_iter()
            .map(|(leaf, input)| {
                let gain = self.gain(leaf, input, fitted, &residual)?;
                Some(Candidate { leaf, input, gain })
            })
            .collect();
        tried.into_iter().flatten().filter(|of| of.gain > 0.0).max_by(|a, b| a.gain.total_cmp(&b.gain))
    }

    /// By how much the squares fall with a split: that of the columns it adds, less what the others hold of them.
    fn gain(&self, leaf: usize, input: usize, fitted: &Fitted, residual: &[DVector<f64>]) -> Option<f64> {
        let (m, own) = (self.normal.quantities(), &self.leaves[leaf]);
        if own.depth >= self.settings.deepest || own.cell[input][1] - own.cell[input][0] <= self.settings.least_cell {
            return None;
        }
        let above: Vec<f64> = (0..own.weights.len())
            .map(|configuration| own.weights[configuration] * self.above(own, input, configuration))
            .collect();
        let (whole, upper) = (own.weights.iter().sum::<f64>(), above.iter().sum::<f64>());
        if upper.min(whole - upper) < self.settings.least_support {
            return None;
        }
        let mut schur = DMatrix::from_diagonal(&DVector::from_column_slice(&self.ridge));
        let mut with = DMatrix::<f64>::zeros(self.leaves.len() * m, m);
        let mut right = DVector::<f64>::zeros(m);
        for (configuration, &weight) in above.iter().enumerate().filter(|(_, weight)| **weight > 0.0) {
            let gram = &self.normal.gram[configuration];
            schur += gram * (weight * weight);
            right.axpy(weight, &residual[configuration], 1.0);
            for (rule, leaf) in self.leaves.iter().enumerate() {
                let product = leaf.weights[configuration] * weight;
                if product > 0.0 {
                    let mut block = with.rows_mut(rule * m, m);
                    block += gram * product;
                }
            }
        }
        schur -= with.tr_mul(&fitted.factor.solve(&with));
        Some(right.dot(&schur.cholesky()?.solve(&right)))
    }

    fn split(&mut self, candidate: &Candidate) {
        let (index, input) = (self.splits.len(), candidate.input);
        let own = self.leaves[candidate.leaf].clone();
        let [low, high] = own.cell[input];
        let shares: Vec<f64> = (0..own.weights.len()).map(|k| self.above(&own, input, k)).collect();
        let branches = [Branch::Rule(candidate.leaf), Branch::Rule(self.leaves.len())];
        self.splits.push(Split { input, between: [low, high], branches });
        if let Some((above, branch)) = own.under {
            self.splits[above].branches[branch] = Branch::Split(index);
        }
        let half = |upper: bool| {
            let mut leaf = own.clone();
            for (weight, share) in leaf.weights.iter_mut().zip(&shares) {
                *weight *= if upper { *share } else { 1.0 - share };
            }
            leaf.cell[input][usize::from(!upper)] = 0.5 * (low + high);
            leaf.under = Some((index, usize::from(upper)));
            leaf.depth += 1;
            leaf
        };
        self.leaves[candidate.leaf] = half(false);
        self.leaves.push(half(true));
    }

    /// The tree with its rules in the order in which it names them, and conclusions within their bounds.
    fn finished(self, fitted: &Fitted, steps: Vec<TreeStep>) -> GrownTree {
        let m = self.normal.quantities();
        let deviations = self.bounded(fitted);
        let (tree, order) = ordered(&self.splits);
        let conclusion = |k: usize| {
            let of = |&rule: &usize| (self.normal.base[k] + deviations[rule * m + k]).max(self.normal.least[k]);
            order.iter().map(of).collect()
        };
        GrownTree {
            tree,
            conclusions: (0..m).map(conclusion).collect(),
            support: order.iter().map(|&rule| self.leaves[rule].weights.iter().sum()).collect(),
            steps,
            left_out: fitted.left_out,
        }
    }

    /// Deviations with no quantity below its least value.
    fn bounded(&self, fitted: &Fitted) -> DVector<f64> {
        let m = self.normal.quantities();
        let least = |k: usize| self.normal.least[k % m] - self.normal.base[k % m];
        let free = &fitted.deviations;
        if (0..free.len()).all(|k| free[k] >= least(k)) {
            return free.clone();
        }
        // In units in which columns and right-hand side are of size one.
        let upper = fitted.factor.l().transpose();
        let target = &upper * free;
        let size = target.norm().max(f64::MIN_POSITIVE);
        let units: Vec<f64> = upper.column_iter().map(|column| size / column.norm()).collect();
        let scaled = DMatrix::from_fn(upper.nrows(), upper.ncols(), |i, j| upper[(i, j)] * units[j] / size);
        let lower = (0..free.len()).map(|k| least(k) / units[k]).collect();
        let bounds = Bounds { lower, upper: vec![f64::INFINITY; free.len()] };
        let found = minimize_in_box(&scaled, &(-target / size), &bounds);
        found.map_or_else(|_| free.clone(), |z| DVector::from_fn(z.len(), |k, _| z[k] * units[k]))
    }
}

/// Splits and rules in the order of a walk from the root, below before above; and which rule stood for each.
fn ordered(splits: &[Split]) -> (Tree, Vec<usize>) {
    fn walk(splits: &[Split], branch: Branch, tree: &mut Tree, order: &mut Vec<usize>) -> Branch {
        let own = match branch {
            Branch::Rule(rule) => {
                order.push(rule);
                return Branch::Rule(order.len() - 1);
            }
            Branch::Split(index) => splits[index],
        };
        let index = tree.splits.len();
        tree.splits.push(own);
        let branches = own.branches.map(|branch| walk(splits, branch, tree, order));
        tree.splits[index].branches = branches;
        Branch::Split(index)
    }
    let (mut tree, mut order) = (Tree::default(), Vec::new());
    let root = if splits.is_empty() { Branch::Rule(0) } else { Branch::Split(0) };
    walk(splits, root, &mut tree, &mut order);
    (tree, order)
}
