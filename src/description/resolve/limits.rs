//! Limits of sums of joints.

use std::f64::consts::TAU;

use super::super::coupling::parse_sum;
use super::super::fuzzy::Input;
use super::super::raw::{JointKind, RawRobot};
use super::super::robot::{Motion, SumLimit};
use super::collector::Collector;
use super::tree::Tree;

/// Limits that are apart by less than this (rad or m) touch.
const ROUNDED: f64 = 1e-9;

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
        let again = |(at, (_, name)): &(usize, &(f64, &str))| named[..*at].iter().any(|(_, before)| before == name);
        if let Some((_, (_, twice))) = named.iter().enumerate().find(again) {
            let remedy = format!("name each joint once, with its factor, such as `2 * {twice}`");
            diagnostics.reject(&path, format!("`{text}` names `{twice}` twice"), remedy);
            continue;
        }
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
        let terms: Vec<(f64, Input)> = terms.into_iter().map(|(factor, input, _)| (factor, input)).collect();
        if let Some([low, high]) = never_within(tree, &terms, is_angle, limits) {
            let unit = if is_angle { raw.units.angle.symbol() } else { raw.units.length.symbol() };
            let [from, to] = limits;
            let [from, to, low, high] = [from, to, low, high].map(|v| (v / factor * 1e4).round() / 1e4);
            let message = format!(
                "`{text}` is limited to {from} .. {to} {unit}, and within the limits of its joints it is {low} .. {high} {unit}: no \
                 configuration is within both"
            );
            diagnostics.reject(&path, message, "check the signs of the sum, its limits, and those of its joints");
            continue;
        }
        found.push(SumLimit { name: text.clone(), terms, is_angle, limits });
    }
    found
}

/// The least and greatest value of a sum by the limits of its joints, where no such value is within the `limits` of the sum. The sum of
/// joints that a loop moves is known up to whole turns.
fn never_within(tree: &Tree, terms: &[(f64, Input)], is_angle: bool, limits: [f64; 2]) -> Option<[f64; 2]> {
    let own = |input: Input| match input {
        Input::Variable(variable) => tree.variables.get(variable)?.limits,
        Input::Joint(joint) => tree.frames.get(joint)?.limits,
    };
    let is_passive = |input: Input| matches!(input, Input::Joint(k) if tree.frames[k].motion == Motion::Passive);
    let mut sum = [0.0, 0.0];
    for (factor, input) in terms {
        let [low, high] = own(*input)?;
        let ends = [factor * low, factor * high];
        sum = [sum[0] + ends[0].min(ends[1]), sum[1] + ends[0].max(ends[1])];
    }
    let turns = if is_angle && terms.iter().any(|(_, input)| is_passive(*input)) {
        (0.5 * (limits[0] + limits[1] - sum[0] - sum[1]) / TAU).round() * TAU
    } else {
        0.0
    };
    let apart = sum[0] + turns > limits[1] + ROUNDED || sum[1] + turns < limits[0] - ROUNDED;
    apart.then_some(sum)
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
