//! The range in which the effects of a description were found: joints (rad, m), loads (N, N.m), time (s), temperature.

use super::campaign::Campaign;
use super::raw::RawValidity;
use crate::diagnostic::{Code, Diagnostic};

/// Share of a range by which a value may lie outside before it counts: readings never reach the ends exactly.
const MARGIN: f64 = 0.05;

impl RawValidity {
    /// The range that the readings of a campaign cover, `variables` being the names of the actuated variables.
    pub fn of(campaign: &Campaign, variables: &[&str]) -> Self {
        let conditions = &campaign.conditions;
        let q = |variable: usize| {
            (0..campaign.readings.len())
                .filter_map(move |reading| campaign.configuration(reading).get(variable).copied())
        };
        let joints = variables.iter().enumerate();
        let joints = joints.filter_map(|(variable, name)| Some(((*name).to_string(), range(q(variable))?)));
        let load = |first: usize| campaign.readings.iter().map(move |reading| size(&reading.wrench, first));
        let loads = [("force", 0), ("moment", 3)];
        let loads = loads.into_iter().filter_map(|(name, first)| Some((name.to_string(), range(load(first))?)));
        let noted = |all: &Option<Vec<f64>>| all.as_ref().and_then(|all| range(all.iter().copied()));
        Self {
            joints: joints.collect(),
            loads: loads.collect(),
            time: noted(&conditions.time),
            temperature: noted(&conditions.temperature),
        }
    }

    /// A warning where configurations or wrenches (N, N.m) lie outside: what was found is extrapolated there.
    pub fn outside<'a>(
        &self,
        variables: &[&str],
        states: impl Iterator<Item = (&'a [f64], &'a [f64; 6])>,
    ) -> Option<Diagnostic> {
        let mut found: Vec<String> = Vec::new();
        let mut note = |what: String| {
            if !found.contains(&what) {
                found.push(what);
            }
        };
        let is_outside = |[low, high]: [f64; 2], value: f64| {
            let margin = MARGIN * (high - low);
            value < low - margin || value > high + margin
        };
        for (q, wrench) in states {
            for (name, value) in variables.iter().zip(q) {
                if self.joints.get(*name).is_some_and(|range| is_outside(*range, *value)) {
                    note((*name).to_string());
                }
            }
            for (name, first) in [("force", 0), ("moment", 3)] {
                if self.loads.get(name).is_some_and(|range| is_outside(*range, size(wrench, first))) {
                    note(name.to_string());
                }
            }
        }
        (!found.is_empty()).then(|| {
            Diagnostic::warning(format!("outside the range in which the effects were found: {}", found.join(", ")))
                .code(Code::OutsideValidity)
                .remedy("trust the prediction less there, or measure there and diagnose again; see `validity` in the description")
        })
    }
}

fn size(wrench: &[f64; 6], first: usize) -> f64 {
    wrench[first..first + 3].iter().map(|part| part * part).sum::<f64>().sqrt()
}

/// Least and greatest; `None` of nothing.
fn range(values: impl Iterator<Item = f64>) -> Option<[f64; 2]> {
    let ends = |known: Option<[f64; 2]>, value: f64| {
        Some(known.map_or([value; 2], |[low, high]| [low.min(value), high.max(value)]))
    };
    values.filter(|value| value.is_finite()).fold(None, ends)
}
