//! Torques of the joints: the columns that files may have, and gain and offset of each sensor as values of targets.

use super::raw::{LoadSource, OrUnknown, RawCampaign, RawEntry, RawTorque};
use super::source::Source;
use super::targets::{Target, TargetValue};
use super::{Campaign, Reading};
use crate::description::resolve::Locate;
use crate::description::robot::{Robot, Variable};
use crate::description::table::{ColumnKind, ExpectedColumn};
use crate::diagnostic::Diagnostic;
use crate::observation::{Observes, TORQUE};
use crate::parameter::Kind;

fn column(prefix: &str, variable: &Variable) -> String {
    format!("{prefix}.{}", variable.name)
}

/// The kind whose columns hold measured loads of joints, also where they are no readings of their own.
const LOADS: Observes = TORQUE;

/// Columns of measured loads.
pub(super) fn load_columns(raw: &RawCampaign, entry: &RawEntry, robot: &Robot) -> Vec<ExpectedColumn> {
    torque_columns(raw, entry, robot, LOADS)
}

impl Campaign {
    /// The sensor of the load of a variable's joint, by index in [`Campaign::targets`].
    pub fn load_sensor(&self, variable: &str) -> Option<usize> {
        self.sensor_of(&LOADS, variable)
    }

    /// Gain and offset (N.m or N) of a sensor, known or assumed; 1 and 0 where there is none.
    pub fn sensor_values(&self, sensor: Option<usize>) -> [f64; 2] {
        let own = sensor.and_then(|sensor| self.targets.get(sensor));
        [(0, 1.0), (1, 0.0)].map(|(k, usual)| own.and_then(|own| own.values.get(k)).map_or(usual, |value| value.value))
    }

    /// Name of the variable whose load a reading holds; `None` of readings of another kind.
    pub fn variable_read(&self, reading: &Reading) -> Option<&str> {
        let target = self.target_of(reading).filter(|_| reading.observes.by_variable().is_some());
        target.map(|target| target.member.0.as_str())
    }
}

/// Columns of a kind of readings of which each variable may have one.
pub(super) fn torque_columns(
    raw: &RawCampaign,
    entry: &RawEntry,
    robot: &Robot,
    kind: Observes,
) -> Vec<ExpectedColumn> {
    let Some(prefix) = kind.by_variable() else { return Vec::new() };
    let [force, .., torque] = entry.units(raw.units).of_wrench();
    let expected = |variable: &Variable| {
        let unit = if variable.is_angle { torque } else { force };
        ExpectedColumn::new(column(prefix, variable), ColumnKind::Quantity(unit), false)
    };
    robot.variables.iter().map(expected).collect()
}

/// Gain and offset of each variable's sensor.
pub(super) fn sensors(raw: &RawCampaign, robot: &Robot, kinds: &[Observes]) -> Vec<Target> {
    let is_load = raw.loads.joints == LoadSource::Measured;
    let prefix = kinds.iter().find_map(|kind| kind.by_variable()).or(LOADS.by_variable().filter(|_| is_load));
    let Some(prefix) = prefix else { return Vec::new() };
    let target = |variable: &Variable| {
        let owner = column(prefix, variable);
        let own = raw.torques.get(&variable.name).copied().unwrap_or_default();
        let unit = if variable.is_angle { "N.m" } else { "N" };
        let factor = if variable.is_angle { raw.units.torque.factor() } else { raw.units.force.factor() };
        let value = |symbol: &str, given: Option<OrUnknown<f64>>, usual: f64, kind: Kind, factor: f64| {
            let given = given.unwrap_or(OrUnknown::Known(usual / factor));
            TargetValue {
                value: given.known().map_or(usual, |value| value * factor),
                kind,
                parameter: given.known().is_none().then(|| format!("{owner}.{symbol}")),
            }
        };
        Target {
            name: owner.clone(),
            column: prefix,
            member: (variable.name.clone(), None),
            observes: None,
            values: vec![
                value("gain", own.gain, 1.0, Kind::Other("1"), 1.0),
                value("offset", own.offset, 0.0, Kind::Other(unit), factor),
            ],
            has_start: true,
            is_near: false,
        }
    };
    robot.variables.iter().map(target).collect()
}

/// Sensors of joints that the robot does not have, and files without any column.
pub(super) fn faults(raw: &RawCampaign, robot: &Robot, sources: &[Source], locate: Locate) -> Vec<Diagnostic> {
    let mut faults = Vec::new();
    let names = || robot.variables.iter().map(|variable| variable.name.as_str());
    for (name, RawTorque { gain, .. }) in &raw.torques {
        if names().all(|known| known != name) {
            let diagnostic = Diagnostic::error(format!("`torques:` has `{name}`, which is no variable of the robot"));
            faults.push(diagnostic.at(locate(&["torques", name])).suggest(name, names()));
        }
        if gain.and_then(OrUnknown::known).is_some_and(|gain| !gain.is_finite() || gain == 0.0) {
            let diagnostic = Diagnostic::error(format!("`torques:` `{name}`: a gain is a finite number, and not 0"));
            faults.push(diagnostic.at(locate(&["torques", name, "gain"])).remedy("correct it, or write `unknown`"));
        }
    }
    faults.extend(faults_of_loads(raw, robot, sources, locate));
    faults.extend(unseen(raw, robot, sources, locate));
    for source in sources {
        let Some(prefix) = source.kinds.iter().find_map(|kind| kind.by_variable()) else { continue };
        if robot.variables.iter().all(|variable| !source.table.has(&column(prefix, variable))) {
            let wanted: Vec<String> = robot.variables.iter().map(|variable| column(prefix, variable)).collect();
            let message = format!("{}: torques are observed, and no joint has a column", source.table.file());
            let remedy = format!("name at least one of {}, in the file or under `columns:`", wanted.join(", "));
            faults.push(Diagnostic::error(message).at(Source::place_of_kinds(locate)).remedy(remedy));
        }
    }
    faults
}

/// Unknown gains and offsets of sensors that no reading shows.
fn unseen(raw: &RawCampaign, robot: &Robot, sources: &[Source], locate: Locate) -> Vec<Diagnostic> {
    let is_read = |variable: &Variable| {
        let of_source = |source: &Source| {
            let mut prefixes = source.kinds.iter().filter_map(|kind| kind.by_variable());
            prefixes.any(|prefix| source.table.has(&column(prefix, variable)))
        };
        sources.is_empty() || sources.iter().any(of_source)
    };
    let prefix = LOADS.by_variable().unwrap_or_default();
    let mut faults = Vec::new();
    for variable in robot.variables.iter().filter(|variable| !is_read(variable)) {
        let Some(own) = raw.torques.get(&variable.name) else { continue };
        for (key, value) in [("gain", own.gain), ("offset", own.offset)] {
            if value.is_none_or(|value| value.known().is_some()) {
                continue;
            }
            let (name, of) = (&variable.name, column(prefix, variable));
            let message = match raw.loads.joints {
                LoadSource::Measured => format!(
                    "`torques:` `{name}`: the {key} is unknown, and `loads: {{joints: measured}}` uses `{of}` without reading it"
                ),
                _ => format!("`torques:` `{name}`: the {key} is unknown, and no file observes `{of}`"),
            };
            let remedy = format!(
                "add `torque` to what a file with `{of}` observes (`observes: [position, torque]`), or give the {key}"
            );
            faults.push(Diagnostic::error(message).at(locate(&["torques", name, key])).remedy(remedy));
        }
    }
    faults
}

/// Measured loads without a measurement, or of readings that hold only what a wrench adds.
fn faults_of_loads(raw: &RawCampaign, robot: &Robot, sources: &[Source], locate: Locate) -> Option<Diagnostic> {
    if raw.loads.joints != LoadSource::Measured {
        return None;
    }
    let fault = |message: &str| Diagnostic::error(format!("`loads: {{joints: measured}}`: {message}"));
    let at = || locate(&["loads", "joints"]);
    if let Some(kind) = sources.iter().flat_map(|source| &source.kinds).find(|kind| kind.is_difference()) {
        let message = format!("a {} holds only what the wrench adds, and torques hold all", kind.name());
        return Some(fault(&message).at(at()).remedy("give loaded and unloaded readings as positions"));
    }
    let prefix = LOADS.by_variable()?;
    let has = |variable: &Variable| sources.iter().any(|source| source.table.has(&column(prefix, variable)));
    if sources.is_empty() || robot.variables.iter().any(has) {
        return None;
    }
    let wanted: Vec<String> = robot.variables.iter().map(|variable| column(prefix, variable)).collect();
    let remedy = format!("name at least one of {}, in the file or under `columns:`", wanted.join(", "));
    Some(fault("no file has a column of torques").at(at()).remedy(remedy))
}
