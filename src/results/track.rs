//! What `track` finds. Lengths in mm, angles in deg, everything else in SI.

use serde::Serialize;

use super::own_weight::OwnWeight;
use super::units::{half_width_95, mm, unit};
use crate::math::quantiles::t95;
use crate::model::Model;
use crate::parameter::Parameter;
use crate::tracking::{self, Amount, Calibrated, Check, Event, EventKind, Finding, History, Shape, likely, meaning};

/// The value of a parameter at one check.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct TrackedValue {
    /// Difference from the first check.
    pub difference: f64,
    /// Half width of its 95 % interval, of this check alone.
    pub ci95: f64,
}

/// What the changes that were reported make of a parameter from one check on: a level, or a line.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TrackedCourse {
    /// First check, counted from 0.
    pub from: usize,
    /// Difference from the first check, at the checks from there on.
    pub values: Vec<f64>,
}

impl TrackedCourse {
    /// The level, or the line by time, of values, each with the weight of its interval.
    fn fitted(from: usize, grows: bool, times: &[f64], values: &[TrackedValue]) -> Self {
        let weight = |value: &TrackedValue| if value.ci95 > 0.0 { value.ci95.powi(-2) } else { 1.0 };
        let sum = |of: &dyn Fn(f64, f64) -> f64| -> f64 {
            times.iter().zip(values).map(|(time, value)| weight(value) * of(*time, value.difference)).sum()
        };
        let all = sum(&|_, _| 1.0);
        let (middle, mean) = (sum(&|time, _| time) / all, sum(&|_, value| value) / all);
        let spread = sum(&|time, _| (time - middle).powi(2));
        let slope = match grows && spread > 0.0 {
            true => sum(&|time, value| (time - middle) * (value - mean)) / spread,
            false => 0.0,
        };
        Self { from, values: times.iter().map(|time| mean + slope * (time - middle)).collect() }
    }
}

/// A parameter over all checks.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TrackedParameter {
    /// Name of the parameter.
    pub name: String,
    /// Unit of its differences and intervals.
    pub unit: &'static str,
    /// What it is on the machine.
    pub meaning: String,
    /// Whether a check shows a change of it.
    pub changed: bool,
    /// At the checks in order.
    pub values: Vec<TrackedValue>,
    /// What they are by the changes that were reported, in order.
    pub courses: Vec<TrackedCourse>,
}

/// The change of a parameter.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TrackedChange {
    /// Name of the parameter.
    pub name: String,
    /// Unit of the change and its interval.
    pub unit: &'static str,
    /// By a step; where it grows, in a unit of time.
    pub change: f64,
    /// Half width of its 95 % interval.
    pub ci95: f64,
    /// Unit of time of what grows.
    pub per: Option<&'static str>,
}

/// What a check shows.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TrackedEvent {
    /// Whether a constant jumped, a constant grows, or something else changed.
    pub kind: EventKind,
    /// In words.
    pub words: String,
    /// First check after a step, or of the line.
    pub since: String,
    /// Of growth: checks that showed it as a jump.
    pub revises: Vec<String>,
    /// Of a jump: the check that shows it to be part of growth.
    pub part_of: Option<String>,
    /// Parameters that changed, and by how much.
    pub changes: Vec<TrackedChange>,
    /// Parameters any of which alone would explain it nearly as well.
    pub indistinguishable_from: Vec<String>,
    /// Smallest probability by chance among the tests of the check.
    pub p: f64,
    /// What `diagnose` finds in the campaign with the reference as description, where constants alone do not explain it.
    pub diagnosis: Option<String>,
}

/// A check.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TrackedCheck {
    /// Name of the check.
    pub name: String,
    /// Its date as given; `None` where none is.
    pub date: Option<String>,
    /// Months, or checks, from the first.
    pub time: f64,
    /// Configurations fitted.
    pub poses: usize,
    /// T2 of the difference from the checks before it, since the last change.
    pub statistic: Option<f64>,
    /// What the statistic passes at the level of one test.
    pub limit: Option<f64>,
    /// Probability of a statistic as great by chance; `None` without a statistic.
    pub p: Option<f64>,
    /// Whether the check shows a change of the robot.
    pub alarm: bool,
    /// Whether the base stands elsewhere than at the check before; `None` where one of the two does not estimate it.
    pub base_moved: Option<bool>,
    /// Whether the tool is elsewhere than at the check before; `None` where one of the two does not estimate it.
    pub tool_moved: Option<bool>,
    /// Standard deviation of the residuals over the stated noise.
    pub noise_ratio: Option<f64>,
    /// Root mean square error of readings held out, mm.
    pub check_rms: Option<f64>,
    /// The change; `None` where none is shown.
    pub event: Option<TrackedEvent>,
}

/// Fewest poses with which the next check would show a change.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TrackedNext {
    /// Name of the parameter.
    pub name: String,
    /// Unit of the change.
    pub unit: &'static str,
    /// The change that is to be shown.
    pub change: f64,
    /// `None` where no number of poses does.
    pub poses: Option<usize>,
}

/// A robot over time.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Track {
    /// The description as it was given.
    pub robot: String,
    /// The robot's name.
    pub name: String,
    /// What the first comparison is with.
    pub reference: String,
    /// The finding in a sentence or two.
    pub answer: String,
    /// Probability of any false alarm in a year of so many checks.
    pub level: f64,
    /// Checks in a year, over which `level` is spread.
    pub checks_a_year: f64,
    /// Level of each test of a check.
    pub level_of_test: f64,
    /// Whether the readings of the first campaign are predicted with own weight.
    pub own_weight: OwnWeight,
    /// `month` or `check`.
    pub unit_of_time: &'static str,
    /// Checks in the order of time; the first may be the description.
    pub checks: Vec<TrackedCheck>,
    /// Parameters of the robot over all checks.
    pub parameters: Vec<TrackedParameter>,
    /// Probability with which the next check is to show a change.
    pub power: f64,
    /// What the next check needs to show a change of each parameter.
    pub next: Vec<TrackedNext>,
}

/// What is known of the checks in addition to what was computed.
#[derive(Debug, Clone)]
pub struct About {
    /// Name of the robot's description.
    pub robot: String,
    /// Dates as given, of each check.
    pub dates: Vec<Option<String>>,
    /// `month` or `check`.
    pub unit_of_time: &'static str,
    /// Whether the readings of the first campaign are predicted with own weight.
    pub own_weight: OwnWeight,
}

impl Track {
    /// With the names and units of a model; diagnoses are put in afterwards.
    pub fn new(
        model: &Model,
        all: &Calibrated,
        history: &History,
        next: &[tracking::NextCheck],
        about: &About,
        settings: &tracking::Settings,
    ) -> Self {
        let names = all.checks.first().map_or(&[][..], |check| &check.robot.names);
        let shown = Shown { model, checks: &all.checks, names, unit_of_time: about.unit_of_time };
        let dates = about.dates.iter().cloned().chain(std::iter::repeat(None));
        let rows = all.checks.iter().zip(&history.findings).zip(dates);
        let level = settings.of_check();
        let checks = rows.map(|((check, finding), date)| shown.check(check, finding, date, level)).collect::<Vec<_>>();
        let next = next.iter().filter_map(|next| shown.next(next)).collect();
        let mut track = Self {
            robot: about.robot.clone(),
            name: model.name.clone(),
            reference: match (all.with_description, checks.first()) {
                (true, _) => format!("the description `{}`", about.robot),
                (false, first) => format!("the first check, `{}`", first.map_or("", |check| check.name.as_str())),
            },
            answer: String::new(),
            level: settings.level,
            checks_a_year: settings.checks_a_year,
            level_of_test: settings.of_test(names.len()),
            own_weight: about.own_weight,
            unit_of_time: about.unit_of_time,
            parameters: (0..names.len()).filter_map(|k| shown.parameter(k, history)).collect(),
            checks,
            power: settings.power,
            next,
        };
        track.answer = track.answered();
        track
    }

    /// The finding in words.
    fn answered(&self) -> String {
        let events: Vec<String> = self
            .checks
            .iter()
            .filter_map(|check| Some((check, check.event.as_ref().filter(|event| event.part_of.is_none())?)))
            .map(|(check, event)| format!("{}: {}.", check.name, event.words))
            .collect();
        // A description is no check.
        let count = self.checks.iter().filter(|check| check.poses > 0).count();
        let base = self.checks.iter().filter(|check| check.base_moved == Some(true)).count();
        let base = match base {
            0 => String::new(),
            _ => format!(" The base stood elsewhere at {base} of them, which is no change of the robot."),
        };
        match (events.is_empty(), count) {
            (true, 1) => format!("No change of the robot: one check compared with the description.{base}"),
            (true, _) => format!("No change of the robot over {count} checks.{base}"),
            (false, _) => format!("{}{base}", events.join(" ")),
        }
    }

    /// Whether the last check shows a change.
    pub fn last_alarms(&self) -> bool {
        self.checks.last().is_some_and(|check| check.alarm)
    }

    /// Whether any check shows a change.
    pub fn any_alarms(&self) -> bool {
        self.checks.iter().any(|check| check.alarm)
    }
}

/// Turns what was computed into names and units.
struct Shown<'a> {
    model: &'a Model,
    checks: &'a [Check],
    names: &'a [String],
    unit_of_time: &'static str,
}

impl<'a> Shown<'a> {
    fn of(&self, index: usize) -> Option<(&'a str, &'a Parameter, f64)> {
        let name = self.names.get(index)?;
        let parameter = &self.model.registry[self.model.registry.slot(name)?];
        let value = self.checks.last()?.robot.values.get(index)?;
        Some((name, parameter, *value))
    }

    /// A difference (SI) about the last value, in its unit.
    fn difference(parameter: &Parameter, value: f64, difference: f64) -> f64 {
        let (_, size) = unit(parameter.shown_kind());
        (parameter.shown(value) - parameter.shown(value - difference)) / size
    }

    fn width(parameter: &Parameter, value: f64, width: f64) -> f64 {
        parameter.shown_width(value, width) / unit(parameter.shown_kind()).1
    }

    fn parameter(&self, index: usize, history: &History) -> Option<TrackedParameter> {
        let (name, parameter, _) = self.of(index)?;
        let first = *self.checks.first()?.robot.values.get(index)?;
        let value = |check: &Check| {
            let (now, sigma) =
                (check.robot.values.get(index)?, check.robot.covariance.get((index, index))?.max(0.0).sqrt());
            let width =
                if check.robot.freedom.is_finite() { t95(check.robot.freedom) * sigma } else { half_width_95(sigma) };
            Some(TrackedValue {
                difference: Self::difference(parameter, *now, now - first),
                ci95: Self::width(parameter, *now, width),
            })
        };
        let values: Vec<TrackedValue> = self.checks.iter().filter_map(value).collect();
        let events = history.findings.iter().filter_map(|finding| finding.event.as_ref());
        Some(TrackedParameter {
            name: name.into(),
            unit: unit(parameter.shown_kind()).0,
            meaning: meaning(self.model, name),
            changed: events.flat_map(|event| &event.changes).any(|change| change.parameter == index),
            courses: self.courses(index, history, &values),
            values,
        })
    }

    /// Levels and lines of a parameter, from change to change as they were reported.
    fn courses(&self, index: usize, history: &History, values: &[TrackedValue]) -> Vec<TrackedCourse> {
        let mut starts = vec![(0, false)];
        let events = history.findings.iter().filter_map(|finding| finding.event.as_ref());
        let own = events.filter(|event| event.changes.iter().any(|change| change.parameter == index));
        for event in own.filter(|event| event.part_of.is_none()) {
            match event.shape {
                // What grew before a jump grows after it.
                Shape::Step { at } => starts.push((at, starts.last().is_some_and(|(_, grows)| *grows))),
                Shape::Line { from } => {
                    starts.retain(|(start, _)| *start < from);
                    starts.push((from, true));
                }
                Shape::Residuals => {}
            }
        }
        let times: Vec<f64> = self.checks.iter().map(|check| check.time).collect();
        let ends = starts.iter().skip(1).map(|(start, _)| *start).chain([values.len()]);
        let course = |((from, grows), end): (&(usize, bool), usize)| {
            Some(TrackedCourse::fitted(*from, *grows, times.get(*from..end)?, values.get(*from..end)?))
        };
        starts.iter().zip(ends).filter_map(course).collect()
    }

    fn check(&self, check: &Check, finding: &Finding, date: Option<String>, level: f64) -> TrackedCheck {
        let [base_moved, tool_moved] = finding.placed.map(|p| p.map(|p| p < level));
        TrackedCheck {
            name: check.name.clone(),
            date,
            time: check.time,
            poses: check.poses,
            statistic: finding.t2,
            limit: finding.limit,
            p: finding.p,
            alarm: finding.alarm(),
            base_moved,
            tool_moved,
            noise_ratio: check.residuals.map(|residuals| residuals.ratio),
            check_rms: check.check_rms.map(mm),
            event: finding.event.as_ref().map(|event| self.event(check, event)),
        }
    }

    fn event(&self, check: &Check, event: &Event) -> TrackedEvent {
        let grows = matches!(event.shape, Shape::Line { .. });
        let change = |amount: &Amount| {
            let (name, parameter, value) = self.of(amount.parameter)?;
            Some(TrackedChange {
                name: name.into(),
                unit: unit(parameter.shown_kind()).0,
                change: Self::difference(parameter, value, amount.change),
                ci95: Self::width(parameter, value, t95(amount.freedom) * amount.sigma),
                per: grows.then_some(self.unit_of_time),
            })
        };
        let changes: Vec<TrackedChange> = event.changes.iter().filter_map(change).collect();
        let names: Vec<&str> = changes.iter().map(|change| change.name.as_str()).collect();
        let (kind, words) = likely(self.model, &names, event);
        let named = |k: &usize| self.checks.get(*k).map(|check| check.name.clone());
        let revises: Vec<String> = event.revises.iter().filter_map(named).collect();
        let part_of = event.part_of.as_ref().and_then(named);
        let words = match (&part_of, revises.is_empty()) {
            (Some(growth), _) => format!("{words} (as it looked then; it is part of the growth that `{growth}` shows)"),
            (None, true) => words,
            (None, false) => {
                let jumps: Vec<String> = revises.iter().map(|name| format!("`{name}`")).collect();
                format!("{words}; what looked like a jump at {} was part of it", jumps.join(", "))
            }
        };
        let since = match event.shape {
            Shape::Step { at } | Shape::Line { from: at } => self.checks.get(at).unwrap_or(check),
            Shape::Residuals => check,
        };
        TrackedEvent {
            kind,
            words,
            since: since.name.clone(),
            revises,
            part_of,
            changes,
            indistinguishable_from: event.rivals.iter().filter_map(|&k| self.names.get(k).cloned()).collect(),
            p: event.p,
            diagnosis: None,
        }
    }

    fn next(&self, next: &tracking::NextCheck) -> Option<TrackedNext> {
        let (name, parameter, value) = self.of(next.parameter)?;
        let change = Self::difference(parameter, value, next.change);
        Some(TrackedNext { name: name.into(), unit: unit(parameter.shown_kind()).0, change, poses: next.poses })
    }
}
