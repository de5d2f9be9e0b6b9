//! Limits of sums of joints.

use super::super::coupling::parse_sum;
use super::super::fuzzy::Input;
use super::super::raw::{JointKind, RawRobot};
use super::super::robot::SumLimit;
use super::collector::Collector;
use super::tree::Tree;

/// Limits as declared; those that cannot be read are reported.
pub fn resolve(raw: &RawRobot, tree: &Tree, diagnostics: &mut Collector) -> Vec<SumLimit> {
    let mut found = Vec::new();
    for (text, given) in &raw.limits {
        let path = ["limits", text.as_str()];
        let named = match parse_sum(text) {
            Ok(terms) if !terms.is_empty() => terms,
            parsed => {
                let why = parsed.err().unwrap_or_else(|| "there is no joint".into());
                let remedy = "write a sum of variables or joints with blanks around + and -: `q3 - q2: [-60, 90]`";
                diagnostics.reject(&path, format!("limits of `{text}`: {why}"), remedy);
                continue;
            }
        };
        let all = named.len();
        let terms: Vec<(f64, Input, bool)> = named
            .into_iter()
            .filter_map(|(factor, name)| {
                let (input, is_angle) = joint(tree, name, &path, diagnostics)?;
                Some((factor, input, is_angle))
            })
            .collect();
        let Some(&(_, _, is_angle)) = terms.first().filter(|_| terms.len() == all) else { continue };
        if terms.iter().any(|term| term.2 != is_angle) {
            let remedy = "limit a sum of angles, or a sum of lengths";
            diagnostics.reject(&path, format!("`{text}` adds a length to an angle"), remedy);
            continue;
        }
        let factor = if is_angle { raw.units.angle.factor() } else { raw.units.length.factor() };
        let Some(limits) = diagnostics.limits(&path, Some(*given), factor) else { continue };
        let terms = terms.into_iter().map(|(factor, input, _)| (factor, input)).collect();
        found.push(SumLimit { name: text.clone(), terms, is_angle, limits });
    }
    found
}

/// A variable or joint by its name, and whether it is an angle.
fn joint(tree: &Tree, name: &str, path: &[&str], diagnostics: &mut Collector) -> Option<(Input, bool)> {
    if let Some(index) = tree.variables.iter().position(|variable| variable.name == name) {
        return Some((Input::Variable(index), tree.variables[index].is_angle));
    }
    let Some(index) = tree.frames.iter().position(|frame| frame.name == name) else {
        let variables = tree.variables.iter().map(|variable| variable.name.as_str());
        let valid: Vec<&str> = variables.chain(tree.frames.iter().map(|frame| frame.name.as_str())).collect();
        // A name may hold a hyphen, so that blanks make a sum of it.
        let mut parts = name.split(['-', '+']).map(|part| part.rsplit('*').next().unwrap_or(part).trim());
        if name.contains(['-', '+']) && parts.all(|part| part.is_empty() || valid.contains(&part)) {
            let remedy =
                format!("write blanks around + and -: `{}`", name.replace('-', " - ").replace('+', " + ").trim());
            diagnostics.reject(path, format!("unknown joint `{name}`"), &remedy);
            return None;
        }
        diagnostics.unknown(path, "joint", name, valid);
        return None;
    };
    if tree.frames[index].joint == JointKind::Fixed {
        diagnostics.reject(path, format!("frame `{name}` does not move"), "name a joint or a variable");
        return None;
    }
    Some((Input::Joint(index), tree.frames[index].joint == JointKind::Revolute))
}
