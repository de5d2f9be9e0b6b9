//! Fuzzy compliances.

use super::collector::Collector;
use super::tree::Tree;
use crate::description::fuzzy::{Component, DISPLACEMENTS, Fuzzy, Input, LOADS};
use crate::description::raw::{JointKind, RawRobot};

/// Most rules of a component.
const MOST_RULES: usize = 100_000;

pub fn resolve(raw: &RawRobot, tree: &Tree, diagnostics: &mut Collector) -> Option<Fuzzy> {
    let given = raw.fuzzy.as_ref()?;
    if given.file.is_some() {
        // Files are put in where descriptions are read from disk.
        diagnostics.reject(
            &["fuzzy", "file"],
            "the file of the rules is not read here",
            "read the description from its file, or write the rules out",
        );
        return None;
    }
    let units = &raw.units;
    let size = |angle: bool| if angle { units.angle.factor() } else { units.length.factor() };
    let mut inputs = Vec::new();
    let mut sizes = Vec::new();
    for (k, name) in given.inputs.iter().enumerate() {
        let position = k.to_string();
        let path = ["fuzzy", "inputs", &position];
        if given.inputs[..k].contains(name) {
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
    for (name, component) in &given.components {
        let path = ["fuzzy", "components", name.as_str()];
        let parts = name.split_once('.').and_then(|(row, column)| {
            let row = DISPLACEMENTS.iter().position(|known| *known == row)?;
            Some([row, LOADS.iter().position(|known| *known == column)?])
        });
        let Some(at) = parts else {
            diagnostics.reject(
                &path,
                format!("`{name}` is no component"),
                "write displacement.load: x, y, z, rx, ry or rz, then fx, .., mz (`x.fz`)",
            );
            continue;
        };
        if component.modes.len() != given.inputs.len() {
            let (found, wanted) = (component.modes.len(), given.inputs.len());
            diagnostics.reject(
                &path,
                format!("`modes` has {found} lists for {wanted} inputs"),
                "give the modal values of each input, in the order of `inputs`",
            );
            continue;
        }
        let modes: Vec<Vec<f64>> = component
            .modes
            .iter()
            .zip(sizes.iter().chain(std::iter::repeat(&1.0)))
            .map(|(list, size)| list.iter().map(|mode| mode * size).collect())
            .collect();
        if modes.iter().any(|list| list.is_empty() || list.windows(2).any(|pair| pair[0] >= pair[1]))
            || modes.iter().flatten().any(|mode| !mode.is_finite())
        {
            diagnostics.error(&path, "modal values must be finite and ascend, at least one of each input");
            continue;
        }
        let rules = modes.iter().try_fold(1_usize, |rules, list| rules.checked_mul(list.len()));
        if rules != Some(component.conclusions.len()) || component.conclusions.len() > MOST_RULES {
            let found = component.conclusions.len();
            let wanted = rules.map_or("too many".into(), |rules| rules.to_string());
            diagnostics.reject(
                &path,
                format!("{found} conclusions for {wanted} rules"),
                "give one conclusion a rule, the last input's sets counting fastest",
            );
            continue;
        }
        let unit = |k: usize, first: f64, second: f64| if k < 3 { first } else { second };
        let factor = unit(at[0], units.length.factor(), units.angle.factor())
            / unit(at[1], units.force.factor(), units.torque.factor());
        let conclusions: Vec<f64> = component.conclusions.iter().map(|value| value * factor).collect();
        if conclusions.iter().any(|value| !value.is_finite()) {
            diagnostics.error(&path, "conclusions must be finite numbers");
            continue;
        }
        components.push(Component { at, modes, conclusions });
    }
    Some(Fuzzy { inputs, at, adds: given.adds, components })
}
