//! Measured torques against those with which motors hold the described masses: in another unit, of another joint, or of nothing that weighs.

use std::collections::BTreeMap;

use nalgebra::DVector;

use super::evidence::{Evidence, Limits};
use super::shown::number;
use crate::diagnostic::{Code, Diagnostic};

/// Holding loads of a joint that spread less than this part of the most loaded joint's are not judged: friction hides them.
const LITTLE: f64 = 0.05;
/// The same for torques that follow nothing. A judgement: where the load of a joint spreads half as much as the greatest does, its friction is
/// below that.
const MUCH: f64 = 0.5;
/// Share of the variance of measured torques from which they follow a joint's load, and up to which they do not: a tenth is friction as great
/// as a third of the load's spread, a half as great as all of it. A judgement.
const FOLLOWS: [f64; 2] = [0.9, 0.5];
/// Masses of a description are known to this factor. A judgement: units are farther apart, but for lbf.ft and N.m.
const KNOWN: f64 = 2.0;

/// What a sensor showed, less its known offset and over its known gain, and what holds each joint (N.m, N), of one reading.
struct Held {
    shown: Vec<f64>,
    holding: Vec<f64>,
}

/// A line through what a sensor shows over what holds a joint.
struct Line {
    slope: f64,
    /// Share of the variance.
    explained: f64,
}

pub(super) fn hold_the_masses(evidence: &Evidence, limits: &Limits) -> Vec<Diagnostic> {
    let (model, held) = (evidence.model, held(evidence));
    let count = model.variables.len();
    let spread = |variable: usize| {
        let all = centred(held.iter().map(|held| held.holding[variable]).filter(|value| value.is_finite()));
        if all.len() < limits.least_configurations { 0.0 } else { all.norm() / (all.len() as f64).sqrt() }
    };
    let spreads: Vec<f64> = (0..count).map(spread).collect();
    let most = spreads.iter().copied().fold(0.0, f64::max);
    let lines = |sensor: usize| -> Vec<Option<Line>> {
        let line = |variable: usize| {
            let pairs: Vec<(f64, f64)> = held.iter().map(|held| (held.holding[variable], held.shown[sensor])).collect();
            line(&pairs, limits).filter(|_| spreads[variable] > LITTLE * most)
        };
        (0..count).map(line).collect()
    };
    let mut wrong = Wrong::default();
    for sensor in 0..count {
        let all = lines(sensor);
        let Some(own) = &all[sensor] else { continue };
        let follows = |variable: &usize| all[*variable].as_ref().is_some_and(|line| line.explained >= FOLLOWS[0]);
        if own.explained >= FOLLOWS[0] {
            let is_other = !(1.0 / KNOWN..=KNOWN).contains(&own.slope);
            wrong.factors.extend((is_other && has_known_gain(evidence, sensor)).then_some((sensor, own.slope)));
        } else if own.explained <= FOLLOWS[1] {
            match (0..count).find(follows) {
                Some(other) => wrong.others.push((sensor, other)),
                None if spreads[sensor] >= MUCH * most => wrong.none.push((sensor, own.explained)),
                None => {}
            }
        }
    }
    wrong.reported(|variable| format!("`torque.{}`", model.variables[variable].name))
}

/// Sensors that do not show what holds their joints.
#[derive(Default)]
struct Wrong {
    /// How many times as much they show.
    factors: Vec<(usize, f64)>,
    /// The joint whose load they show.
    others: Vec<(usize, usize)>,
    /// Of what they show, the share of the variance that their joint's load explains.
    none: Vec<(usize, f64)>,
}

impl Wrong {
    fn reported(&self, name: impl Fn(usize) -> String) -> Vec<Diagnostic> {
        let mut found = Vec::new();
        let listed = |all: Vec<String>| all.join(", ");
        if let Some((_, factor)) = self.factors.first() {
            let times = |&(sensor, by): &(usize, f64)| match number(by.abs()) {
                size if by < 0.0 => format!("{} {size} times, with the other sign", name(sensor)),
                size => format!("{} {size} times", name(sensor)),
            };
            let message = format!(
                "measured torques are not those that hold the described masses, but multiples of them: {}",
                listed(self.factors.iter().map(times).collect())
            );
            let remedy = "state `torque` under `units:` as the file has it (N.m, N.mm, lbf.in); of currents give the gain under `torques:`, or \
                          `gain: unknown`; compare sign and masses with the description";
            let diagnostic = Diagnostic::warning(message).code(Code::WrongUnits).remedy(remedy);
            found.push(diagnostic.figure("factor", *factor));
        }
        if !self.others.is_empty() {
            let follows = |&(own, of): &(usize, usize)| format!("{} follows the load of {}", name(own), name(of));
            let all = listed(self.others.iter().map(follows).collect());
            let diagnostic = Diagnostic::warning(format!("measured torques are of other joints: {all}"));
            let remedy = "compare the names of the columns with the axes; map them under `columns:`";
            found.push(diagnostic.code(Code::Misread).remedy(remedy));
        }
        if !self.none.is_empty() {
            let part = |&(sensor, explained): &(usize, f64)| format!("{:.0} % of {}", 100.0 * explained, name(sensor));
            let message = format!(
                "measured torques do not follow the loads of the described masses: these explain {} (variance)",
                listed(self.none.iter().map(part).collect())
            );
            let remedy =
                "look at signs, units and rows of these columns; compare masses and gravity with the description";
            found.push(Diagnostic::warning(message).code(Code::Misread).remedy(remedy));
        }
        found
    }
}

/// Whether what a sensor shows is stated to be a torque, or in a known proportion to it.
fn has_known_gain(evidence: &Evidence, variable: usize) -> bool {
    let campaign = evidence.campaign;
    let sensor = campaign.load_sensor(&evidence.model.variables[variable].name);
    sensor.is_none_or(|sensor| evidence.model.target_values(sensor).first().is_none_or(Option::is_none))
}

/// By row of the files: torques that load joints, and those that are read.
fn held(evidence: &Evidence) -> Vec<Held> {
    let (model, campaign) = (evidence.model, evidence.campaign);
    let count = model.variables.len();
    let sensor = |variable: usize, shown: f64| {
        let [gain, offset] = campaign.sensor_values(campaign.load_sensor(&model.variables[variable].name));
        (shown - offset) / gain
    };
    let mut all: BTreeMap<usize, Held> = BTreeMap::new();
    for (index, reading) in campaign.readings.iter().enumerate() {
        let own = all
            .entry(reading.row)
            .or_insert_with(|| Held { shown: vec![f64::NAN; count], holding: vec![f64::NAN; count] });
        for (variable, described) in campaign.conditions.described_loads.iter().enumerate().take(count) {
            own.holding[variable] = described.get(index).map_or(f64::NAN, |load| -load);
        }
        let torques = campaign.conditions.torques.iter().enumerate().take(count);
        for (variable, shown) in torques.filter_map(|(variable, all)| Some((variable, all.as_ref()?.get(index)?))) {
            own.shown[variable] = sensor(variable, *shown);
        }
        let name = campaign.variable_read(reading);
        if let Some(variable) = model.variables.iter().position(|variable| Some(variable.name.as_str()) == name) {
            own.holding[variable] = reading.load;
            own.shown[variable] = sensor(variable, reading.measured[0]);
        }
    }
    all.into_values().collect()
}

fn line(pairs: &[(f64, f64)], limits: &Limits) -> Option<Line> {
    let known: Vec<(f64, f64)> = pairs.iter().copied().filter(|(x, y)| x.is_finite() && y.is_finite()).collect();
    if known.len() < limits.least_configurations {
        return None;
    }
    let x = centred(known.iter().map(|(x, _)| *x));
    let y = centred(known.iter().map(|(_, y)| *y));
    let (xx, xy, yy) = (x.norm_squared(), x.dot(&y), y.norm_squared());
    (xx > 0.0 && yy > 0.0).then(|| Line { slope: xy / xx, explained: xy * xy / (xx * yy) })
}

/// Values less their mean.
fn centred(values: impl Iterator<Item = f64>) -> DVector<f64> {
    let values = DVector::from_vec(values.collect());
    let mean = values.mean();
    values.add_scalar(-mean)
}
