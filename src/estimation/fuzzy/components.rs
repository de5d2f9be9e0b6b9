//! A compliance by trees of rules: components that loads or reciprocity tie together share a tree.

use nalgebra::DVector;
use rayon::prelude::*;

use super::grown::{Grown, Step, SubModel};
use super::normal::Normal;
use super::samples::Samples;
use super::settings::FuzzySettings;
use super::tree::{GrownTree, TreeStep, grow_tree};
use crate::description::fuzzy::{Premise, Rules};

/// Components that have one value: one, or two that reciprocity makes equal.
type Quantity = Vec<[usize; 2]>;

/// Components that are fitted together.
struct Together<'a> {
    samples: &'a Samples,
    quantities: Vec<Quantity>,
}

/// Grows a tree for each set of components that are fitted together.
pub fn grow_components(
    samples: &Samples,
    reciprocal: bool,
    settings: &FuzzySettings,
    taken: &(dyn Fn(&Step) + Sync),
) -> Grown {
    let together: Vec<Together> = grouped(samples, reciprocal);
    let grown: Vec<(Vec<SubModel>, Vec<Step>, f64)> =
        together.par_iter().map(|group| group.grow(settings, taken)).collect();
    let mut found = Grown {
        components: Vec::new(),
        axes: samples.axes,
        range: samples.range.clone(),
        beyond: 0,
        steps: Vec::new(),
        left_out: 0.0,
    };
    for (components, steps, left_out) in grown {
        found.components.extend(components);
        found.steps.extend(steps);
        found.left_out += left_out;
    }
    found.components.sort_by_key(|component| component.at);
    found
}

/// Components that occur together in the displacement of one reading, directly or by others.
fn grouped(samples: &Samples, reciprocal: bool) -> Vec<Together<'_>> {
    let mut groups: Vec<Vec<Quantity>> = Vec::new();
    for row in 0..samples.rows {
        for &column in &samples.columns {
            let mirrored = column < samples.rows && samples.columns.contains(&row);
            match reciprocal && mirrored && row != column {
                true if row < column => groups.push(vec![vec![[row, column], [column, row]]]),
                true => {}
                false => groups.push(vec![vec![[row, column]]]),
            }
        }
    }
    let fitted = samples.indices(false, |_| true);
    let act_together = |one: &[usize; 2], other: &[usize; 2]| {
        let loads = |k: &usize| samples.load[*k][one[1]] != 0.0 && samples.load[*k][other[1]] != 0.0;
        one[0] == other[0] && fitted.iter().any(loads)
    };
    let mut merged: Vec<Vec<Quantity>> = Vec::new();
    for group in groups {
        let touches = |others: &Vec<Quantity>| {
            let own = || group.iter().flatten();
            others.iter().flatten().any(|other| own().any(|one| act_together(one, other)))
        };
        let (joined, apart): (Vec<_>, Vec<_>) = merged.into_iter().partition(touches);
        merged = apart;
        merged.push(joined.into_iter().flatten().chain(group).collect());
    }
    merged.iter_mut().for_each(|group| group.sort());
    merged.sort();
    merged.into_iter().map(|quantities| Together { samples, quantities }).collect()
}

impl Together<'_> {
    /// Rules of all components, how the tree grew, and what is left in cross-validation relative to the displacements.
    fn grow(&self, settings: &FuzzySettings, taken: &(dyn Fn(&Step) + Sync)) -> (Vec<SubModel>, Vec<Step>, f64) {
        let (normal, unit) = (self.normal(), self.unit());
        let components: Vec<[usize; 2]> = self.quantities.iter().flatten().copied().collect();
        let as_step = |of: &TreeStep| Step {
            components: components.clone(),
            component: None,
            sets: Vec::new(),
            rules: of.rules,
            fitted: Some(unit * of.fitted),
            cross_validated: unit * of.cross_validated,
        };
        let mut each = |of: &TreeStep| taken(&as_step(of));
        let GrownTree { tree, conclusions, support, steps, left_out } =
            grow_tree(&normal, &self.samples.range, settings, &mut each);
        let unseen: Vec<usize> = (0..support.len()).filter(|&rule| support[rule] < settings.seen).collect();
        let components = self.quantities.iter().zip(conclusions).flat_map(|(quantity, conclusions)| {
            let rules = Rules { premise: Premise::Tree(tree.clone()), conclusions };
            let (support, unseen) = (support.clone(), unseen.clone());
            quantity.iter().map(move |&at| SubModel {
                at,
                rules: rules.clone(),
                support: support.clone(),
                unseen: unseen.clone(),
            })
        });
        let components = components.collect();
        (components, steps.iter().map(as_step).collect(), left_out)
    }

    /// Size of the displacements in which errors are reported: of rotations where there is nothing else, rad, else m.
    fn unit(&self) -> f64 {
        let moves = self.quantities.iter().flatten().any(|[row, _]| *row < 3);
        self.samples.sizes[usize::from(!moves)]
    }

    /// Normal equations of the fitted readings that these components load. Displacements and rotations count relative to
    /// the size of their own kind over all fitted readings, so that what is left adds up over components whatever their axes.
    fn normal(&self) -> Normal {
        let samples = self.samples;
        let is_direct = |quantity: &Quantity| quantity.iter().all(|[row, column]| row == column);
        let least = self.quantities.iter().map(|own| if is_direct(own) { 0.0 } else { f64::NEG_INFINITY }).collect();
        let mut normal = Normal::new(least);
        for k in samples.indices(false, |_| true) {
            for row in 0..samples.rows {
                let own = |quantity: &Quantity| -> f64 {
                    let here = quantity.iter().filter(|[of, _]| *of == row);
                    here.map(|[_, column]| samples.load[k][*column]).sum()
                };
                let coefficients = DVector::from_iterator(self.quantities.len(), self.quantities.iter().map(own));
                if coefficients.iter().any(|v| *v != 0.0) {
                    let weight = samples.sizes[row / 3].max(f64::MIN_POSITIVE).powi(-2);
                    normal.add(samples.pose[k], &samples.x[k], &coefficients, samples.d[k][row], weight);
                }
            }
        }
        let constant = normal.constant();
        let within = DVector::from_fn(constant.len(), |k, _| constant[k].max(normal.least[k]));
        normal.subtract(within);
        normal
    }
}
