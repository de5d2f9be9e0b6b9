//! Fuzzy compliances.

use super::collector::Collector;
use super::tree::Tree;
use crate::description::fuzzy::{Component, DISPLACEMENTS, Fuzzy, Input, LOADS};
use crate::description::raw::{JointKind, RawFuzzyComponent, RawRobot};
use crate::description::units::Units;

/// Most rules of a component.
const MOST_RULES: usize = 100_000;

pub fn resolve(raw: &RawRobot, tree: &Tree, diagnostics: &mut Collector) -> Option<Fuzzy> {
    let given = raw.fuzzy.as_ref()?;
    if given.file.is_some() {
        // Files are put in where descriptions are read from disk.
        let remedy = "read the description from its file, or write the rules out";
        diagnostics.reject(&["fuzzy", "file"], "the file of the rules is not read here", remedy);
        return None;
    }
    let (inputs, sizes) = inputs(raw, tree, &given.inputs, diagnostics);
    let at = given.at.as_ref().and_then(|name| {
        let found = raw.markers.keys().position(|known| known == name);
        if found.is_none() {
            diagnostics.unknown(&["fuzzy", "at"], "marker", name, raw.markers.keys().map(String::as_str));
        }
        found
    });
    if given.components.is_empty() {
        diagnostics.lacking(&["fuzzy"], "components", "the fuzzy model has no `components`");
    }
    let mut components = Vec::new();
    for (name, component_given) in &given.components {
        match component(name, component_given, given.inputs.len(), &sizes, &raw.units) {
            Ok(component) => components.push(component),
            Err((message, None)) => {
                diagnostics.error(&["fuzzy", "components", name], message);
            }
            Err((message, Some(remedy))) => diagnostics.reject(&["fuzzy", "components", name], message, remedy),
        }
    }
    Some(Fuzzy { inputs, at, adds: given.adds, components })
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

/// A component in SI, or what is wrong with it and perhaps what to do.
fn component(
    name: &str,
    given: &RawFuzzyComponent,
    inputs: usize,
    sizes: &[f64],
    units: &Units,
) -> Result<Component, (String, Option<&'static str>)> {
    let parts = name.split_once('.').and_then(|(row, column)| {
        let row = DISPLACEMENTS.iter().position(|known| *known == row)?;
        Some([row, LOADS.iter().position(|known| *known == column)?])
    });
    let remedy = "write displacement.load: x, y, z, rx, ry or rz, then fx, .., mz (`x.fz`)";
    let at = parts.ok_or((format!("`{name}` is no component"), Some(remedy)))?;
    if given.modes.len() != inputs {
        let message = format!("`modes` has {} lists for {inputs} inputs", given.modes.len());
        return Err((message, Some("give the modal values of each input, in the order of `inputs`")));
    }
    let modes = given.modes.iter().zip(sizes.iter().chain(std::iter::repeat(&1.0)));
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
    let factor = units.compliance(at);
    let conclusions: Vec<f64> = given.conclusions.iter().map(|value| value * factor).collect();
    if conclusions.iter().any(|value| !value.is_finite()) {
        return Err(("conclusions must be finite numbers".into(), None));
    }
    Ok(Component { at, modes, conclusions })
}
