//! Boxes through which no link may pass.

use super::super::raw::RawRobot;
use super::super::robot::KeepOut;
use super::collector::Collector;

/// Boxes as declared; those that are none are reported.
pub fn resolve(raw: &RawRobot, diagnostics: &mut Collector) -> Vec<KeepOut> {
    let length = raw.units.length.factor();
    let mut found = Vec::new();
    for (name, given) in &raw.keep_out {
        let axes = [("x", given.x), ("y", given.y), ("z", given.z)];
        if axes.iter().all(|(_, interval)| interval.is_none()) {
            let remedy = "give from and to along one axis at least: `keep_out: {table: {x: [800, 1400], z: [0, 700]}}`";
            diagnostics.reject(&["keep_out", name], format!("`{name}` has no x, y or z"), remedy);
            continue;
        }
        let space = axes.map(|(axis, interval)| match interval {
            Some(_) => diagnostics.limits(&["keep_out", name, axis], interval, length),
            None => Some([f64::NEG_INFINITY, f64::INFINITY]),
        });
        if let [Some(x), Some(y), Some(z)] = space {
            found.push(KeepOut { name: name.clone(), space: [x, y, z] });
        }
    }
    found
}
