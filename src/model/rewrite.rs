//! A description with other values: calibrated robots go back to the file they came from.

use super::Model;
use crate::description::fuzzy::{Branch, Component, Input, Premise, Rules, Tree};
use crate::description::parameters::{Owner, parameters};
use crate::description::raw::{JointKind, RawBranch, RawFuzzy, RawFuzzyComponent, RawRobot, RawSplit};
use crate::parameter::{Group, Slot};

/// The description `raw` with every value that differs from the model's nominal one put in, in the file's units.
/// The zero of a joint goes to `offset`, so that couplings and loops see it when the file is read again.
#[must_use]
pub fn with_values(raw: &RawRobot, model: &Model, values: &[f64]) -> RawRobot {
    let mut written = raw.clone();
    let changed = |slot: usize| {
        let value = *values.get(slot)?;
        (value != model.registry[slot].nominal).then_some(value)
    };
    for key in parameters(raw) {
        let Some((slot, value)) = model.registry.slot(&key.name).and_then(|slot| Some((slot, changed(slot)?))) else {
            continue;
        };
        if let Owner::Frame(name) = key.owner
            && let Some(of) = model.frame(name).map(|index| &model.frames[index])
            && of.moves()
            && of.moving_slot() == slot
            && let Some(frame) = written.frames.get_mut(name)
        {
            let prismatic = of.joint == JointKind::Prismatic;
            let unit = if prismatic { raw.units.length.factor() } else { raw.units.angle.factor() };
            frame.offset = Some((value - of.home) / unit);
            continue;
        }
        if key.owner == Owner::Tool {
            written.tool.frame.get_or_insert_with(|| model.frames[model.tool.0].name.clone());
        }
        let parameter = &model.registry[slot];
        let kind = parameter.shown_kind();
        key.write(&mut written, parameter.shown(value) / raw.units.of(kind), kind);
    }
    for (effect, entry) in model.effects.iter().zip(&mut written.effects) {
        for (parameter, slot) in effect.parameters.iter().zip(&effect.slots) {
            if let Some(value) = slot.and_then(changed) {
                entry.parameters.insert(parameter.symbol.clone(), value.into());
            }
        }
    }
    written
}

/// Bases, tools and markers (`base@monday`) whose values changed and that [`with_values`] does not write, because each is of a
/// session or station: a description has one of each.
#[must_use]
pub fn of_sessions(model: &Model, values: &[f64]) -> Vec<String> {
    let is_changed = |slot: Slot| {
        let parameter = &model.registry[slot];
        let is_written = matches!(parameter.group, Group::Base | Group::Tool);
        is_written && values.get(slot).is_some_and(|value| *value != parameter.nominal)
    };
    let changed = model.copied().iter().filter(|copy| copy.slots.clone().any(is_changed));
    changed.map(|copy| copy.name.clone()).collect()
}

/// The description with the model's rules put in, in the file's units.
#[must_use]
pub fn with_fuzzy(raw: &RawRobot, model: &Model) -> RawRobot {
    let mut raw = raw.clone();
    let units = &raw.units;
    let size = |angle: bool| if angle { units.angle.factor() } else { units.length.factor() };
    let of = model.fuzzy.as_ref().map(|fuzzy| &fuzzy.inputs);
    let of = of.or(model.local_springs.as_ref().map(|local| &local.inputs));
    let named = |input: &Input| {
        let (name, angle) = model.input(*input);
        (name.to_string(), size(angle))
    };
    let Some(inputs) = of.map(|of| of.iter().map(named).collect::<Vec<(String, f64)>>()) else {
        raw.fuzzy = None;
        return raw;
    };
    let mut written = RawFuzzy { inputs: inputs.iter().map(|(name, _)| name.clone()).collect(), ..RawFuzzy::default() };
    if let Some(fuzzy) = &model.fuzzy {
        written.at = fuzzy.at.map(|marker| model.markers[marker].name.clone());
        written.axes = fuzzy.axes.map(|frame| model.frames[frame].name.clone());
        written.adds = fuzzy.adds;
        let component = |component: &Component| {
            let factor = units.compliance(component.at);
            (Component::name(component.at), raw_rules(&component.rules, &inputs, |value| value / factor))
        };
        written.components = fuzzy.components.iter().map(component).collect();
    }
    for (slot, rules) in model.local_springs.iter().flat_map(|local| &local.springs) {
        let parameter = &model.registry[*slot];
        let unit = units.of(parameter.shown_kind());
        let found = raw_rules(rules, &inputs, |compliance| parameter.shown(compliance) / unit);
        written.springs.insert(parameter.name.clone(), found);
    }
    raw.fuzzy = Some(written);
    raw
}

/// Rules in the file's units: inputs with the unit of each, and how a conclusion is written.
fn raw_rules(rules: &Rules, inputs: &[(String, f64)], conclusion: impl Fn(f64) -> f64) -> RawFuzzyComponent {
    let mut written = RawFuzzyComponent::default();
    let conclusions: Vec<f64> = rules.conclusions.iter().map(|value| conclusion(*value)).collect();
    match &rules.premise {
        Premise::Grid(modes) => {
            let modes = modes.iter().zip(inputs);
            written.modes = modes.map(|(list, (_, size))| list.iter().map(|mode| mode / size).collect()).collect();
            written.conclusions = conclusions;
        }
        Premise::Tree(tree) => {
            let root = if tree.splits.is_empty() { Branch::Rule(0) } else { Branch::Split(0) };
            written.tree = Some(raw_branch(tree, root, inputs, &conclusions));
        }
    }
    written
}

fn raw_branch(tree: &Tree, branch: Branch, inputs: &[(String, f64)], conclusions: &[f64]) -> RawBranch {
    let split = match branch {
        Branch::Rule(rule) => return RawBranch::Conclusion(conclusions[rule]),
        Branch::Split(index) => &tree.splits[index],
    };
    let (input, size) = &inputs[split.input];
    let [from, to] = split.between.map(|end| end / size);
    let [below, above] = split.branches.map(|branch| raw_branch(tree, branch, inputs, conclusions));
    RawBranch::Split(Box::new(RawSplit { input: input.clone(), from, to, below, above }))
}
