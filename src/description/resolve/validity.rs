//! The range of the readings by which a description was fitted, as it stands in it.

use super::super::raw::RawRobot;
use super::collector::Collector;
use super::tree::Tree;

/// Reports ranges of no variable and of no load, and such as begin above their end.
pub fn validate(raw: &RawRobot, tree: &Tree, diagnostics: &mut Collector) {
    let Some(validity) = &raw.validity else { return };
    let variables = tree.variables.iter().map(|variable| variable.name.as_str());
    for (name, range) in &validity.joints {
        let path = ["validity", "joints", name.as_str()];
        diagnostics.known(&path, "variable", name, variables.clone());
        in_order(&path, *range, diagnostics);
    }
    for (name, range) in &validity.loads {
        let path = ["validity", "loads", name.as_str()];
        diagnostics.known(&path, "load", name, ["force", "moment", "payload"].into_iter());
        in_order(&path, *range, diagnostics);
    }
    for (name, range) in [("time", validity.time), ("temperature", validity.temperature)] {
        range.into_iter().for_each(|range| in_order(&["validity", name], range, diagnostics));
    }
}

fn in_order(path: &[&str], [from, to]: [f64; 2], diagnostics: &mut Collector) {
    if from > to || !from.is_finite() || !to.is_finite() {
        let message = format!("a range from {from} to {to}");
        diagnostics.reject(path, message, "write the smaller value first: `[from, to]`, in rad, m, N, N.m, kg or s");
    }
}
