//! Takagi-Sugeno rules of order zero: what their weights are at a configuration, and the value that they give.
//!
//! A rule is "if x1 is about c1 and .. then the compliance is b". On a grid, how near the inputs are is read from strong
//! triangular partitions (memberships sum to one, neighbours cross at one half) that hold their outermost value outside,
//! and rules are joined by products. In a tree each split along one input hands the weight on, linearly between two
//! values of it; a grid of two sets is a split. Either way weights sum to one and the answer is the plain weighted sum.
//!
//! Source: IR663 calibration paper, eq. (33) to (38); trees with splits along the axes: Nelles and Isermann 1996 (LOLIMOT).

use crate::description::fuzzy::{Branch, Input, Premise, Rules, Tree};
use crate::kinematics::Placements;

/// Membership of `x` in a strong triangular partition: the lower of the two sets that share it, and the weight of the
/// upper one.
///
/// ```
/// // Between the sets about 10 and 20, a quarter of the way up.
/// assert_eq!(elastogeo::fuzzy::membership(&[0.0, 10.0, 20.0], 12.5), (1, 0.25));
/// ```
pub fn membership(modes: &[f64], x: f64) -> (usize, f64) {
    let above = modes.partition_point(|mode| *mode <= x);
    match above {
        0 => (0, 0.0),
        _ if above >= modes.len() => (modes.len().saturating_sub(1), 0.0),
        _ => (above - 1, (x - modes[above - 1]) / (modes[above] - modes[above - 1])),
    }
}

/// Hands the rules that fire at `x` with their weights, which sum to one, to `each`.
pub fn firing(modes: &[Vec<f64>], x: &[f64], each: &mut dyn FnMut(usize, f64)) {
    fn descend(modes: &[Vec<f64>], x: &[f64], rule: usize, weight: f64, each: &mut dyn FnMut(usize, f64)) {
        let (Some((own, modes)), Some((at, x))) = (modes.split_first(), x.split_first()) else {
            return each(rule, weight);
        };
        let (lower, upper) = membership(own, *at);
        let first = rule * own.len() + lower;
        if upper < 1.0 {
            descend(modes, x, first, weight * (1.0 - upper), each);
        }
        if upper > 0.0 {
            descend(modes, x, first + 1, weight * upper, each);
        }
    }
    descend(modes, x, 0, 1.0, each);
}

/// Hands the rules of a tree that fire at `x` with their weights, which sum to one, to `each`.
pub fn firing_of_tree(tree: &Tree, x: &[f64], each: &mut dyn FnMut(usize, f64)) {
    fn descend(tree: &Tree, branch: Branch, x: &[f64], weight: f64, each: &mut dyn FnMut(usize, f64)) {
        let split = match branch {
            Branch::Rule(rule) => return each(rule, weight),
            Branch::Split(index) => &tree.splits[index],
        };
        let [from, to] = split.between;
        let above = ((x[split.input] - from) / (to - from)).clamp(0.0, 1.0);
        if above < 1.0 {
            descend(tree, split.branches[0], x, weight * (1.0 - above), each);
        }
        if above > 0.0 {
            descend(tree, split.branches[1], x, weight * above, each);
        }
    }
    let root = if tree.splits.is_empty() { Branch::Rule(0) } else { Branch::Split(0) };
    descend(tree, root, x, 1.0, each);
}

/// What rules give at inputs in rad or m.
///
/// ```
/// use elastogeo::description::fuzzy::{Branch, Premise, Rules, Split, Tree};
///
/// // 1 um/N up to 0 rad, 3 um/N from 1 rad on, linear between: as a grid of one input, and as a tree.
/// let conclusions = vec![1e-6, 3e-6];
/// let split = Split { input: 0, between: [0.0, 1.0], branches: [Branch::Rule(0), Branch::Rule(1)] };
/// for premise in [Premise::Grid(vec![vec![0.0, 1.0]]), Premise::Tree(Tree { splits: vec![split] })] {
///     let rules = Rules { premise, conclusions: conclusions.clone() };
///     assert!((elastogeo::fuzzy::value(&rules, &[0.25]) - 1.5e-6).abs() < 1e-18);
/// }
/// ```
pub fn value(rules: &Rules, x: &[f64]) -> f64 {
    let mut sum = 0.0;
    let mut add = |rule: usize, weight: f64| sum += weight * rules.conclusions[rule];
    match &rules.premise {
        Premise::Grid(modes) => firing(modes, x, &mut add),
        Premise::Tree(tree) => firing_of_tree(tree, x, &mut add),
    }
    sum
}

/// Inputs at a placed configuration, rad and m.
pub fn inputs(of: &[Input], placements: &Placements, out: &mut Vec<f64>) {
    out.clear();
    out.extend(of.iter().map(|input| match *input {
        Input::Joint(frame) => placements.joints[frame],
        Input::Variable(index) => placements.variables[index],
    }));
}
