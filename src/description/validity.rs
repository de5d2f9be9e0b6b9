//! The range of the readings by which a description was fitted, and its effects found: joints (rad, m), loads (N, N.m), time (s), temperature.

use super::campaign::Campaign;
use super::raw::RawValidity;
use crate::diagnostic::{Code, Diagnostic};
use crate::math::norm;

/// Share of a range by which a value may lie outside before it counts: readings never reach the ends exactly.
const MARGIN: f64 = 0.05;

/// 0 deg C in kelvin.
const KELVIN: f64 = 273.15;

/// Where and how a robot is used.
#[derive(Debug, Clone, Copy)]
pub struct State<'a> {
    /// Variables, rad or m.
    pub q: &'a [f64],
    /// On the tool, N and N.m.
    pub wrench: &'a [f64; 6],
    /// Mass of the payload, kg, where it is known.
    pub payload: Option<f64>,
    /// As the campaign had it, where it is known.
    pub temperature: Option<f64>,
}

impl<'a> State<'a> {
    /// Of unknown payload and temperature.
    pub fn new(q: &'a [f64], wrench: &'a [f64; 6]) -> Self {
        Self { q, wrench, payload: None, temperature: None }
    }
}

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
        let payload = campaign.readings.iter().map(|reading| reading.payload.map_or(0.0, |payload| payload.mass));
        let loads = loads.into_iter().filter_map(|(name, first)| Some((name.to_string(), range(load(first))?)));
        let loads = loads.chain(range(payload).map(|range| ("payload".to_string(), range)));
        let noted = |all: &Option<Vec<f64>>| all.as_ref().and_then(|all| range(all.iter().copied()));
        Self {
            joints: joints.collect(),
            loads: loads.collect(),
            time: noted(&conditions.time),
            temperature: noted(&conditions.temperature),
        }
    }

    /// A warning where readings of a campaign lie outside; where something `goes_with_time`, so do those of a session that lasts longer.
    pub fn outside_of(&self, variables: &[&str], campaign: &Campaign, goes_with_time: bool) -> Option<Diagnostic> {
        let readings = campaign.readings.iter().enumerate();
        let states = readings.map(|(index, reading)| State {
            payload: Some(reading.payload.map_or(0.0, |payload| payload.mass)),
            temperature: campaign.conditions.temperature_of(index),
            ..State::new(campaign.configuration(index), &reading.wrench)
        });
        let since_start = campaign.conditions.session_time.iter().flatten().copied();
        let lasts_longer =
            |[from, to]: [f64; 2]| range(since_start).is_some_and(|[_, most]| most > (1.0 + MARGIN) * (to - from));
        let first = self.time.filter(|_| goes_with_time).filter(|time| lasts_longer(*time)).map(|_| "time".to_string());
        self.outside_with(first, variables, states)
    }

    /// A warning where a state lies outside: what was found is extrapolated there.
    pub fn outside<'a>(&self, variables: &[&str], states: impl Iterator<Item = State<'a>>) -> Option<Diagnostic> {
        self.outside_with(None, variables, states)
    }

    fn outside_with<'a>(
        &self,
        first: Option<String>,
        variables: &[&str],
        states: impl Iterator<Item = State<'a>>,
    ) -> Option<Diagnostic> {
        let mut found: Vec<String> = first.into_iter().collect();
        let mut note = |what: String| {
            if !found.contains(&what) {
                found.push(what);
            }
        };
        let is_outside = |[low, high]: [f64; 2], value: f64| {
            let margin = MARGIN * (high - low);
            value < low - margin || value > high + margin
        };
        let mut is_kelvin = false;
        for State { q, wrench, payload, temperature } in states {
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
            let range = self.loads.get("payload");
            if range.zip(payload).is_some_and(|(range, mass)| is_outside(*range, mass)) {
                note("payload".to_string());
            }
            if let Some((range, value)) =
                self.temperature.zip(temperature).filter(|(range, value)| is_outside(*range, *value))
            {
                is_kelvin |= !is_outside(range, value - KELVIN);
                note("temperature".to_string());
            }
        }
        let remedy = match is_kelvin {
            true => "give temperatures in the unit of the campaign, deg C: these look like kelvin",
            false => {
                "trust the prediction less there, or measure there and identify or diagnose again; see `validity` in the description"
            }
        };
        (!found.is_empty()).then(|| {
            Diagnostic::warning(format!(
                "outside the range of the readings by which the description was fitted: {}",
                found.join(", ")
            ))
            .code(Code::OutsideValidity)
            .remedy(remedy)
        })
    }
}

fn size(wrench: &[f64; 6], first: usize) -> f64 {
    norm(&wrench[first..first + 3])
}

/// Least and greatest; `None` of nothing.
fn range(values: impl Iterator<Item = f64>) -> Option<[f64; 2]> {
    let ends = |known: Option<[f64; 2]>, value: f64| {
        Some(known.map_or([value; 2], |[low, high]| [low.min(value), high.max(value)]))
    };
    values.filter(|value| value.is_finite()).fold(None, ends)
}
