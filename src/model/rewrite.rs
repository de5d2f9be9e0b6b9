//! A description with other values: calibrated robots go back to the file they came from.

use super::Model;
use crate::description::parameters::{Owner, parameters};
use crate::description::raw::{JointKind, RawFuzzy, RawFuzzyComponent, RawRobot};

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

/// The description with the model's fuzzy compliance put in, in the file's units.
#[must_use]
pub fn with_fuzzy(raw: &RawRobot, model: &Model) -> RawRobot {
    use crate::description::fuzzy::{Component, Input};
    let mut raw = raw.clone();
    let units = &raw.units;
    let size = |angle: bool| if angle { units.angle.factor() } else { units.length.factor() };
    raw.fuzzy = model.fuzzy.as_ref().map(|fuzzy| {
        let named = |input: &Input| match *input {
            Input::Variable(k) => (model.variables[k].name.clone(), size(model.variables[k].is_angle)),
            Input::Joint(k) => (model.frames[k].name.clone(), size(model.frames[k].joint == JointKind::Revolute)),
        };
        let inputs: Vec<(String, f64)> = fuzzy.inputs.iter().map(named).collect();
        let component = |component: &Component| {
            let factor = units.compliance(component.at);
            let modes = component.modes.iter().zip(&inputs);
            let raw = RawFuzzyComponent {
                modes: modes.map(|(list, (_, size))| list.iter().map(|mode| mode / size).collect()).collect(),
                conclusions: component.conclusions.iter().map(|value| value / factor).collect(),
            };
            (Component::name(component.at), raw)
        };
        RawFuzzy {
            file: None,
            inputs: inputs.iter().map(|(name, _)| name.clone()).collect(),
            at: fuzzy.at.map(|marker| model.markers[marker].name.clone()),
            adds: fuzzy.adds,
            components: fuzzy.components.iter().map(component).collect(),
        }
    });
    raw
}
