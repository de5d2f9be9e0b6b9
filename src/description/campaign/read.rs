//! A campaign file and its tables against the model they are about.

use std::collections::HashMap;

use nalgebra::Vector3;

use super::doubts::doubts;
use super::raw::{RawCampaign, RawSigma};
use super::{Campaign, Conditions, Reading, WRENCH};
use crate::description::resolve::{Explained, GREATEST, Locate};
use crate::description::robot::Robot;
use crate::description::table::{ColumnKind, ExpectedColumn, Table};
use crate::diagnostic::Diagnostic;
use crate::observation::{FAMILY, MOST_ROWS, POSITION};

/// Columns a campaign about this robot may have, under our names.
pub fn expected_columns(raw: &RawCampaign, robot: &Robot) -> Vec<ExpectedColumn> {
    let column = |name: &str, kind, required| ExpectedColumn { name: name.into(), kind, required };
    let number = |name: &str, required| column(name, ColumnKind::Number, required);
    let observes = raw.observes.unwrap_or(POSITION);
    let mut columns = vec![column("pose", ColumnKind::Text, false), column("marker", ColumnKind::Text, false)];
    columns.extend(robot.variables.iter().map(|variable| number(&variable.name, true)));
    columns.extend(observes.columns().iter().map(|measured| number(measured.name, true)));
    columns.extend(observes.anchor_column().map(|name| column(name, ColumnKind::Text, false)));
    columns.extend(WRENCH.map(|name| number(name, false)));
    columns.push(column("set", ColumnKind::Text, false));
    columns.extend(["temperature", "time"].map(|name| number(name, false)));
    columns.extend(robot.variables.iter().map(|variable| number(&format!("approach.{}", variable.name), false)));
    columns.extend(robot.frames.iter().map(|frame| number(&format!("temperature.{}", frame.name), false)));
    columns
}

/// Resolves a campaign: units, markers, sets, conditions.
///
/// # Errors
/// Every fault of the campaign file and of its tables, located.
pub fn resolve(
    raw: &RawCampaign,
    locate: Locate,
    robot: &Robot,
    tables: &[Table],
) -> Result<(Campaign, Vec<Diagnostic>), Vec<Diagnostic>> {
    let mut diagnostics = Vec::new();
    let (length, angle) = (raw.units.length.factor(), raw.units.angle.factor());
    let observes = raw.observes.unwrap_or(POSITION);
    let instrument = raw.instrument.clone().unwrap_or_default();
    let sigma = instrument.sigma.map(|sigma| match sigma {
        RawSigma::All(sigma) => [sigma * length; 3],
        RawSigma::ByAxis { x, y, z } => [x * length, y * length, z * length],
    });
    let sigma_orientation = instrument.orientation.map(|sigma| sigma * angle);
    let mut anchors = robot.anchors.clone();
    for (name, at) in &raw.anchors {
        anchors.insert(name.clone(), Vector3::from(*at) * length);
    }
    if observes.anchor_column().is_some() && anchors.is_empty() {
        let message = format!("{}s are measured from a fixed anchor, and none is declared", observes.name());
        let diagnostic = Diagnostic::error(message);
        diagnostics.push(
            diagnostic.at(locate(&["observes"])).remedy("add `anchors: {name: [x, y, z]}`, in the measurement frame"),
        );
    }
    let mut campaign = Campaign {
        name: raw.campaign.clone().unwrap_or_else(|| "campaign".into()),
        observes,
        sigma,
        sigma_orientation,
        estimate_base: raw.estimate.base,
        estimate_tool: raw.estimate.tool,
        calibrate: raw.calibrate.clone(),
        without: raw.without.clone(),
        anchors,
        poses: Vec::new(),
        variables: robot.variables.len(),
        joints: Vec::new(),
        readings: Vec::new(),
        conditions: Conditions::default(),
    };
    let mut rows = Rows { raw, robot, poses: HashMap::new(), sets: Vec::new() };
    for table in tables {
        rows.append(table, &mut campaign, &mut diagnostics);
    }
    let timed = |table: &&Table| table.has("time");
    if let (Some(with), Some(lacking)) = (tables.iter().find(timed), tables.iter().find(|table| !timed(table))) {
        let message = format!("`{}` has a column `time`, but `{}` has not", with.file(), lacking.file());
        diagnostics.push(
            Diagnostic::error(message).at(locate(&["measurements"])).remedy("give `time` in all files or in none"),
        );
    }
    if !diagnostics.iter().any(Diagnostic::is_error) {
        diagnostics.extend(doubts(&campaign, &raw.units, locate, robot, tables));
    }
    if diagnostics.iter().any(Diagnostic::is_error) { Err(diagnostics) } else { Ok((campaign, diagnostics)) }
}

/// Faults and doubts of the campaign file alone; `effects` are the names that `calibrate` may list.
pub fn faults(raw: &RawCampaign, effects: &[&str], locate: Locate, explained: Explained) -> Vec<Diagnostic> {
    let mut diagnostics = Vec::new();
    if raw.observes.is_none() && !explained(&["observes"]) {
        let diagnostic =
            Diagnostic::warning("`observes` is not given; positions are assumed").at(locate(&["observes"]));
        let others: Vec<&str> = FAMILY.iter().map(|kind| kind.name()).filter(|name| *name != POSITION.name()).collect();
        diagnostics.push(diagnostic.remedy(format!("add `observes: position` (or {})", others.join(", "))));
    }
    for (position, effect) in raw.calibrate.iter().enumerate() {
        if !effects.contains(&effect.as_str()) {
            let diagnostic = Diagnostic::error(format!("unknown effect `{effect}`"))
                .at(locate(&["calibrate", &position.to_string()]));
            diagnostics.push(diagnostic.suggest(effect, effects.iter().copied()));
        }
    }
    for (name, at) in &raw.anchors {
        if let Some(bad) = at.iter().find(|v| !(0.0..=GREATEST).contains(&(v.abs() * raw.units.length.factor()))) {
            let diagnostic = Diagnostic::error(format!("anchor `{name}`: `{bad}` where a finite length is needed"));
            diagnostics.push(diagnostic.at(locate(&["anchors", name])));
        }
    }
    let instrument = raw.instrument.clone().unwrap_or_default();
    let observes = raw.observes.unwrap_or(POSITION);
    if let Some(RawSigma::ByAxis { x, y, z }) = instrument.sigma
        && observes.length_rows() == 1
        && (x != y || y != z)
    {
        let message = format!("the noise of a {} is one number, not one by axis", observes.name());
        let diagnostic = Diagnostic::error(message).at(locate(&["instrument", "sigma"]));
        diagnostics.push(diagnostic.remedy("give `sigma:` as one number, that of the length itself"));
    }
    let mut noise = |path: &[&str], value: f64, factor: f64| {
        if !(value * factor >= LEAST_NOISE && value * factor <= GREATEST) {
            let diagnostic =
                Diagnostic::error(format!("the instrument's noise is {value}, and must be a finite number above 0"));
            diagnostics.push(
                diagnostic
                    .at(locate(path))
                    .remedy("give one sigma; leave it out to have it estimated from the residuals"),
            );
        }
    };
    let length = raw.units.length.factor();
    match instrument.sigma {
        Some(RawSigma::All(value)) => noise(&["instrument", "sigma"], value, length),
        Some(RawSigma::ByAxis { x, y, z }) => {
            for (axis, value) in [("x", x), ("y", y), ("z", z)] {
                noise(&["instrument", "sigma", axis], value, length);
            }
        }
        None => {}
    }
    if let Some(value) = instrument.orientation {
        noise(&["instrument", "orientation"], value, raw.units.angle.factor());
    }
    diagnostics
}

/// A noise below this (m or rad) is nothing but zero.
const LEAST_NOISE: f64 = 1e-15;

struct Rows<'a> {
    raw: &'a RawCampaign,
    robot: &'a Robot,
    poses: HashMap<String, usize>,
    /// Set of each configuration so far: its value and whether it was told to differ.
    sets: Vec<Option<(Option<bool>, bool)>>,
}

const MOST_TOLD: usize = 20;

fn too_great(column: &str) -> Diagnostic {
    Diagnostic::error(format!("column `{column}`: no robot measures so much")).remedy("check the value and `units:`")
}

impl Rows<'_> {
    fn append(&mut self, table: &Table, campaign: &mut Campaign, diagnostics: &mut Vec<Diagnostic>) {
        let units = &self.raw.units;
        let (length, angle) = (units.length.factor(), units.angle.factor());
        let observes = campaign.observes;
        let before = campaign.readings.len();
        let number = |name: &str, row: usize| table.numbers(name).and_then(|all| all.get(row)).copied().unwrap_or(0.0);
        let mut told = 0;
        let mut tell = |diagnostics: &mut Vec<Diagnostic>, diagnostic: Diagnostic| {
            told += 1;
            if told <= MOST_TOLD {
                diagnostics.push(diagnostic);
            }
        };
        for row in 0..table.row_count() {
            for variable in &self.robot.variables {
                let factor = if variable.is_angle { angle } else { length };
                let value = number(&variable.name, row) * factor;
                if value.abs() > GREATEST {
                    tell(diagnostics, too_great(&variable.name).at(table.place(row, &variable.name)));
                }
                campaign.joints.push(value);
            }
            let marker = match table.texts("marker").and_then(|texts| texts.get(row)) {
                None => None,
                Some("TCP" | "tcp" | "tool") => None,
                Some(name) => {
                    let found = self.robot.markers.iter().position(|marker| marker.name == name);
                    if found.is_none() {
                        let diagnostic =
                            Diagnostic::error(format!("unknown marker `{name}`")).at(table.place(row, "marker"));
                        let valid = self.robot.markers.iter().map(|marker| marker.name.as_str()).chain(["TCP"]);
                        tell(diagnostics, diagnostic.suggest(name, valid));
                    }
                    found
                }
            };
            let check = match table.texts("set").and_then(|texts| texts.get(row)) {
                None => None,
                Some("fit") => Some(false),
                Some("check") => Some(true),
                Some(other) => {
                    let diagnostic = Diagnostic::error(format!("unknown set `{other}`")).at(table.place(row, "set"));
                    tell(diagnostics, diagnostic.suggest(other, ["fit", "check"]));
                    None
                }
            };
            let pose_name = match table.texts("pose").and_then(|texts| texts.get(row)) {
                Some(name) => name.to_string(),
                None => format!("row {}", before + row + 1),
            };
            let pose = *self.poses.entry(pose_name.clone()).or_insert_with(|| {
                campaign.poses.push(pose_name.clone());
                campaign.poses.len() - 1
            });
            self.sets.resize(campaign.poses.len(), None);
            match self.sets[pose] {
                None => self.sets[pose] = Some((check, false)),
                Some((first, false)) if first != check => {
                    let message = format!("configuration `{pose_name}` is partly to fit and partly to check");
                    let diagnostic = Diagnostic::error(message).at(table.place(row, "set"));
                    tell(diagnostics, diagnostic.remedy("rows of one configuration share its set"));
                    self.sets[pose] = Some((first, true));
                }
                Some(_) => {}
            }
            let mut anchor = 0;
            if let Some(column) = observes.anchor_column() {
                match table.texts(column).and_then(|texts| texts.get(row)) {
                    Some(name) => match campaign.anchors.get_index_of(name) {
                        Some(index) => anchor = index,
                        None => {
                            let diagnostic =
                                Diagnostic::error(format!("unknown anchor `{name}`")).at(table.place(row, column));
                            tell(diagnostics, diagnostic.suggest(name, campaign.anchors.keys().map(String::as_str)));
                        }
                    },
                    None if campaign.anchors.len() > 1 => {
                        let diagnostic =
                            Diagnostic::error("several anchors are declared, and the rows do not say which was used");
                        tell(
                            diagnostics,
                            diagnostic
                                .at(table.place(row, observes.columns()[0].name))
                                .remedy(format!("add a column `{column}`")),
                        );
                    }
                    None => {}
                }
            }
            let mut measured = [0.0; MOST_ROWS];
            for (value, column) in measured.iter_mut().zip(observes.columns()) {
                *value = number(column.name, row) * units.of(column.kind);
            }
            if let Some((column, fault)) = observes.fault(&measured) {
                tell(diagnostics, Diagnostic::error(fault).at(table.place(row, column)));
            }
            for (column, value) in observes.columns().iter().zip(measured) {
                if value.abs() > GREATEST {
                    tell(diagnostics, too_great(column.name).at(table.place(row, column.name)));
                }
            }
            for column in WRENCH.iter().filter(|column| number(column, row).abs() > GREATEST) {
                tell(diagnostics, too_great(column).at(table.place(row, column)));
            }
            let wrench = std::array::from_fn(|k| {
                number(WRENCH[k], row) * if k < 3 { units.force.factor() } else { units.torque.factor() }
            });
            campaign.readings.push(Reading { row: before + row + 1, pose, marker, measured, anchor, wrench, check });
        }
        if told > MOST_TOLD {
            diagnostics.push(Diagnostic::error(format!(
                "and {} more like these in {}",
                told - MOST_TOLD,
                table.file()
            )));
        }
        self.conditions(table, before, campaign);
    }

    /// Conditions of a table's readings, behind those of the tables before it.
    fn conditions(&self, table: &Table, before: usize, campaign: &mut Campaign) {
        let append = |column: &mut Option<Vec<f64>>, name: &str, factor: f64| {
            if let Some(values) = table.numbers(name) {
                let column = column.get_or_insert_default();
                column.resize(before, f64::NAN);
                column.extend(values.iter().map(|value| value * factor));
            }
        };
        let conditions = &mut campaign.conditions;
        append(&mut conditions.temperature, "temperature", 1.0);
        append(&mut conditions.time, "time", self.raw.units.time.factor());
        conditions.approach.resize(self.robot.variables.len(), None);
        for (variable, column) in self.robot.variables.iter().zip(&mut conditions.approach) {
            append(column, &format!("approach.{}", variable.name), 1.0);
        }
        for frame in &self.robot.frames {
            let mut column = conditions.site_temperatures.shift_remove(&frame.name);
            append(&mut column, &format!("temperature.{}", frame.name), 1.0);
            conditions.site_temperatures.extend(column.map(|column| (frame.name.clone(), column)));
        }
        let all = campaign.readings.len();
        conditions.columns_mut().for_each(|column| column.resize(all, f64::NAN));
    }
}
