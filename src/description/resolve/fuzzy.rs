//! Fuzzy compliances.

use super::collector::Collector;
use super::tree::Tree;
use crate::description::fuzzy::{
    Branch, Component, DISPLACEMENTS, Fuzzy, Input, LOADS, Premise, Rules, Split, SpringRules, Tree as Splits,
};
use crate::description::raw::{JointKind, RawBranch, RawFuzzyComponent, RawRobot};

/// Most rules of a component.
const MOST_RULES: usize = 100_000;
/// Most splits on the way to a rule.
const DEEPEST: usize = 60;

/// What is wrong, and perhaps what to do.
type Wrong = (String, Option<&'static str>);

/// The fuzzy compliance of the tool, and the fuzzy springs.
pub fn resolve(raw: &RawRobot, tree: &Tree, diagnostics: &mut Collector) -> (Option<Fuzzy>, Option<SpringRules>) {
    let Some(given) = raw.fuzzy.as_ref() else { return (None, None) };
    if given.file.is_some() {
        // Files are put in where descriptions are read from disk.
        let remedy = "read the description from its file, or write the rules out";
        diagnostics.reject(&["fuzzy", "file"], "the file of the rules is not read here", remedy);
        return (None, None);
    }
    let (inputs, sizes) = inputs(raw, tree, &given.inputs, diagnostics);
    let at = given.at.as_ref().and_then(|name| {
        let found = raw.markers.keys().position(|known| known == name);
        if found.is_none() {
            diagnostics.unknown(&["fuzzy", "at"], "marker", name, raw.markers.keys().map(String::as_str));
        }
        found
    });
    let axes = given.axes.as_ref().and_then(|name| {
        let found = tree.frames.iter().position(|frame| frame.name == *name);
        if found.is_none() {
            let frames = tree.frames.iter().map(|frame| frame.name.as_str());
            diagnostics.unknown(&["fuzzy", "axes"], "frame", name, frames);
        }
        found
    });
    if given.components.is_empty() && given.springs.is_empty() {
        diagnostics.lacking(&["fuzzy"], "components", "the fuzzy model has no `components`, and no `springs`");
    }
    let known = Known { inputs: &given.inputs, sizes };
    let mut components = Vec::new();
    for (name, own) in &given.components {
        let rules = || component(name).and_then(|at| Ok((at, finite(known.rules(own)?, raw.units.compliance(at))?)));
        if let Some((at, rules)) = reported("components", name, own, rules, diagnostics) {
            components.push(Component { at, rules });
        }
    }
    let mut springs = Vec::new();
    for (name, own) in &given.springs {
        let rules = || known.rules(own).and_then(stiff);
        if let Some(rules) = reported("springs", name, own, rules, diagnostics) {
            springs.push((name.clone(), rules));
        }
    }
    let units = [raw.units.stiffness.factor(), raw.units.rotational_stiffness.factor()];
    (
        (!given.components.is_empty()).then(|| Fuzzy {
            inputs: inputs.clone(),
            at,
            axes,
            adds: given.adds,
            components,
        }),
        (!given.springs.is_empty()).then_some(SpringRules { inputs, springs, units }),
    )
}

/// Rules that were read; what is wrong with them is reported.
fn reported<T>(
    section: &str,
    name: &str,
    own: &RawFuzzyComponent,
    read: impl Fn() -> Result<T, Wrong>,
    diagnostics: &mut Collector,
) -> Option<T> {
    let path = ["fuzzy", section, name];
    if *own == RawFuzzyComponent::default() {
        let message = format!("`{name}` has no rules: give a `tree`, or `modes` and `conclusions`");
        diagnostics.lacking(&path, "tree", message);
        return None;
    }
    match read() {
        Ok(found) => return Some(found),
        Err((message, Some(remedy))) => diagnostics.reject(&path, message, remedy),
        Err((message, None)) => {
            diagnostics.error(&path, message);
        }
    }
    None
}

/// Joints and variables by name, and the file's unit of each, SI.
fn inputs(raw: &RawRobot, tree: &Tree, given: &[String], diagnostics: &mut Collector) -> (Vec<Input>, Vec<f64>) {
    let size = |angle: bool| if angle { raw.units.angle.factor() } else { raw.units.length.factor() };
    let (mut inputs, mut sizes) = (Vec::new(), Vec::new());
    for (k, name) in given.iter().enumerate() {
        let position = k.to_string();
        let path = ["fuzzy", "inputs", &position];
        if given[..k].contains(name) {
            diagnostics.error(&path, format!("input `{name}` is given twice"));
        }
        if let Some(index) = tree.variables.iter().position(|variable| variable.name == *name) {
            inputs.push(Input::Variable(index));
            sizes.push(size(tree.variables[index].is_angle));
        } else if let Some(index) = tree.frames.iter().position(|frame| frame.name == *name) {
            if tree.frames[index].joint == JointKind::Fixed {
                diagnostics.reject(&path, format!("frame `{name}` does not move"), "name a joint or a variable");
            }
            inputs.push(Input::Joint(index));
            sizes.push(size(tree.frames[index].joint == JointKind::Revolute));
        } else {
            let variables = tree.variables.iter().map(|variable| variable.name.as_str());
            let valid: Vec<&str> = variables.chain(tree.frames.iter().map(|frame| frame.name.as_str())).collect();
            diagnostics.unknown(&path, "joint", name, valid);
        }
    }
    (inputs, sizes)
}

/// Row and column of a component.
fn component(name: &str) -> Result<[usize; 2], Wrong> {
    let parts = name.split_once('.').and_then(|(row, column)| {
        let row = DISPLACEMENTS.iter().position(|known| *known == row)?;
        Some([row, LOADS.iter().position(|known| *known == column)?])
    });
    let remedy = "write displacement.load: x, y, z, rx, ry or rz, then fx, .., mz (`x.fz`)";
    parts.ok_or((format!("`{name}` is no component"), Some(remedy)))
}

/// Rules of a component, their conclusions in SI.
fn finite(mut rules: Rules, factor: f64) -> Result<Rules, Wrong> {
    rules.conclusions.iter_mut().for_each(|value| *value *= factor);
    match rules.conclusions.iter().all(|value| value.is_finite()) {
        true => Ok(rules),
        false => Err(("conclusions must be finite numbers".into(), None)),
    }
}

/// Rules of springs: stiffnesses above zero, infinite where rigid.
fn stiff(rules: Rules) -> Result<Rules, Wrong> {
    match rules.conclusions.iter().find(|stiffness| stiffness.is_nan() || **stiffness <= 0.0) {
        Some(wrong) => {
            Err((format!("a stiffness of {wrong} holds nothing"), Some("give one above zero; `.inf` is rigid")))
        }
        None => Ok(rules),
    }
}

/// What rules may name.
struct Known<'a> {
    inputs: &'a [String],
    /// SI units in the file's unit of each.
    sizes: Vec<f64>,
}

impl Known<'_> {
    /// Rules, their conclusions in the unit of the file.
    fn rules(&self, given: &RawFuzzyComponent) -> Result<Rules, Wrong> {
        let (premise, conclusions) = match &given.tree {
            Some(_) if !given.modes.is_empty() || !given.conclusions.is_empty() => {
                let remedy = "conclusions stand in the tree: leave `modes` and `conclusions` out";
                return Err(("both a `tree` and a grid are given".into(), Some(remedy)));
            }
            Some(RawBranch::Conclusion(value)) => (Premise::Tree(Splits::default()), vec![*value]),
            Some(branch) => {
                let mut found = (Splits::default(), Vec::new());
                self.split(branch, 0, &mut found)?;
                (Premise::Tree(found.0), found.1)
            }
            None => (Premise::Grid(self.grid(given)?), given.conclusions.clone()),
        };
        Ok(Rules { premise, conclusions })
    }

    fn grid(&self, given: &RawFuzzyComponent) -> Result<Vec<Vec<f64>>, Wrong> {
        if given.modes.len() != self.inputs.len() {
            let message = format!("`modes` has {} lists for {} inputs", given.modes.len(), self.inputs.len());
            return Err((message, Some("give the modal values of each input, in the order of `inputs`")));
        }
        let modes = given.modes.iter().zip(self.sizes.iter().chain(std::iter::repeat(&1.0)));
        let modes: Vec<Vec<f64>> = modes.map(|(list, size)| list.iter().map(|mode| mode * size).collect()).collect();
        if modes.iter().any(|list| list.is_empty() || list.windows(2).any(|pair| pair[0] >= pair[1]))
            || modes.iter().flatten().any(|mode| !mode.is_finite())
        {
            return Err(("modal values must be finite and ascend, at least one of each input".into(), None));
        }
        let rules = modes.iter().try_fold(1_usize, |rules, list| rules.checked_mul(list.len()));
        let found = given.conclusions.len();
        if rules != Some(found) || found > MOST_RULES {
            let wanted = rules.map_or("too many".into(), |rules| rules.to_string());
            let remedy = "give one conclusion a rule, the last input's sets counting fastest";
            return Err((format!("{found} conclusions for {wanted} rules"), Some(remedy)));
        }
        Ok(modes)
    }

    /// Adds a branch to the splits and conclusions found so far.
    fn split(&self, branch: &RawBranch, depth: usize, found: &mut (Splits, Vec<f64>)) -> Result<Branch, Wrong> {
        let given = match branch {
            RawBranch::Conclusion(value) => {
                found.1.push(*value);
                return Ok(Branch::Rule(found.1.len() - 1));
            }
            RawBranch::Split(given) => given,
        };
        if depth == DEEPEST || found.1.len() > MOST_RULES {
            return Err(("the tree is too deep".into(), Some("use fewer splits")));
        }
        let Some(input) = self.inputs.iter().position(|name| *name == given.input) else {
            let message = format!("`{}` is no input of the rules", given.input);
            return Err((message, Some("name one of `inputs`, or add it there")));
        };
        let size = self.sizes.get(input).copied().unwrap_or(1.0);
        let between = [given.from * size, given.to * size];
        if !between.iter().all(|end| end.is_finite()) || between[0] >= between[1] {
            let message = format!("a split of `{}` goes from {} to {}", given.input, given.from, given.to);
            return Err((message, Some("give finite numbers, `from` below `to`")));
        }
        let index = found.0.splits.len();
        found.0.splits.push(Split { input, between, branches: [Branch::Rule(0); 2] });
        let below = self.split(&given.below, depth + 1, found)?;
        let above = self.split(&given.above, depth + 1, found)?;
        found.0.splits[index].branches = [below, above];
        Ok(Branch::Split(index))
    }
}
