//! Rows of measurement tables as readings, in SI; every fault located. Of each table the first faults are shown, the others
//! counted.

use std::collections::HashMap;

use super::raw::RawCampaign;
use super::{Campaign, Reading, WRENCH};
use crate::description::resolve::GREATEST;
use crate::description::robot::Robot;
use crate::description::table::Table;
use crate::diagnostic::{Diagnostic, Place};
use crate::observation::{MOST_ROWS, Observes, Rows};

/// Most faults shown of one table.
const MOST_SHOWN: usize = 20;

/// A row of a table.
struct Row<'a> {
    table: &'a Table,
    row: usize,
}

impl Row<'_> {
    /// A number; zero where the table has no such column, which is then not required.
    fn number(&self, column: &str) -> f64 {
        self.table.numbers(column).and_then(|all| all.get(self.row)).copied().unwrap_or(0.0)
    }

    fn text(&self, column: &str) -> Option<&str> {
        self.table.texts(column)?.get(self.row)
    }

    fn place(&self, column: &str) -> Option<Place> {
        self.table.place(self.row, column)
    }
}

/// Faults of one table.
#[derive(Default)]
struct Faults {
    shown: Vec<Diagnostic>,
    count: usize,
}

impl Faults {
    fn push(&mut self, diagnostic: Diagnostic) {
        self.count += 1;
        if self.count <= MOST_SHOWN {
            self.shown.push(diagnostic);
        }
    }

    fn unknown<'n>(&mut self, row: &Row, column: &str, name: &str, valid: impl IntoIterator<Item = &'n str>) {
        let diagnostic = Diagnostic::error(format!("unknown {column} `{name}`")).at(row.place(column));
        self.push(diagnostic.suggest(name, valid));
    }

    fn check_size(&mut self, row: &Row, column: &str, value: f64) {
        if value.abs() > GREATEST {
            let diagnostic = Diagnostic::error(format!("column `{column}`: no robot measures so much"));
            self.push(diagnostic.remedy("check the value and `units:`").at(row.place(column)));
        }
    }
}

/// The set of a configuration, as its first row gives it.
#[derive(Clone, Copy)]
struct SetOfPose {
    check: Option<bool>,
    is_reported: bool,
}

/// Appends tables to a campaign.
pub struct RowReader<'a> {
    raw: &'a RawCampaign,
    robot: &'a Robot,
    /// Configurations by name.
    poses: HashMap<String, usize>,
    /// By configuration.
    sets: Vec<SetOfPose>,
}

impl<'a> RowReader<'a> {
    pub fn new(raw: &'a RawCampaign, robot: &'a Robot) -> Self {
        Self { raw, robot, poses: HashMap::new(), sets: Vec::new() }
    }

    /// Appends the readings of a table and their conditions.
    pub fn append(&mut self, table: &Table, campaign: &mut Campaign, diagnostics: &mut Vec<Diagnostic>) {
        let before = campaign.readings.len();
        let mut faults = Faults::default();
        for row in 0..table.row_count() {
            let number = before + row + 1;
            let row = Row { table, row };
            self.joints(&row, &mut campaign.joints, &mut faults);
            let marker = self.marker(&row, &mut faults);
            let check = set(&row, &mut faults);
            let pose = self.pose(&row, number, check, campaign, &mut faults);
            let anchor = anchor(&row, campaign, &mut faults);
            let measured = self.measured(&row, campaign.observes, &mut faults);
            let wrench = self.wrench(&row, &mut faults);
            campaign.readings.push(Reading { row: number, pose, marker, measured, anchor, wrench, check });
        }
        diagnostics.append(&mut faults.shown);
        if faults.count > MOST_SHOWN {
            let more = faults.count - MOST_SHOWN;
            diagnostics.push(Diagnostic::error(format!("and {more} more like these in {}", table.file())));
        }
        self.conditions(table, before, campaign);
    }

    fn joints(&self, row: &Row, joints: &mut Vec<f64>, faults: &mut Faults) {
        for variable in &self.robot.variables {
            let value = row.number(&variable.name) * self.raw.units.of(variable.kind());
            faults.check_size(row, &variable.name, value);
            joints.push(value);
        }
    }

    /// The marker; none for the tool centre point.
    fn marker(&self, row: &Row, faults: &mut Faults) -> Option<usize> {
        let name = row.text("marker").filter(|name| !matches!(*name, "TCP" | "tcp" | "tool"))?;
        let found = self.robot.markers.iter().position(|marker| marker.name == name);
        if found.is_none() {
            let valid = self.robot.markers.iter().map(|marker| marker.name.as_str()).chain(["TCP"]);
            faults.unknown(row, "marker", name, valid);
        }
        found
    }

    /// The configuration, by index; rows without a name are configurations of their own.
    fn pose(
        &mut self,
        row: &Row,
        number: usize,
        check: Option<bool>,
        campaign: &mut Campaign,
        faults: &mut Faults,
    ) -> usize {
        let name = row.text("pose").map_or_else(|| format!("row {number}"), String::from);
        let Some(&pose) = self.poses.get(&name) else {
            self.sets.push(SetOfPose { check, is_reported: false });
            campaign.poses.push(name.clone());
            self.poses.insert(name, campaign.poses.len() - 1);
            return campaign.poses.len() - 1;
        };
        let set = &mut self.sets[pose];
        if set.check != check && !set.is_reported {
            let message = format!("configuration `{name}` is partly to fit and partly to check");
            let diagnostic = Diagnostic::error(message).at(row.place("set"));
            faults.push(diagnostic.remedy("rows of one configuration share its set"));
            set.is_reported = true;
        }
        pose
    }

    fn measured(&self, row: &Row, observes: Observes, faults: &mut Faults) -> Rows {
        let mut measured = [0.0; MOST_ROWS];
        for (value, column) in measured.iter_mut().zip(observes.columns()) {
            *value = row.number(column.name) * self.raw.units.of(column.kind);
        }
        if let Some((column, fault)) = observes.fault(&measured) {
            faults.push(Diagnostic::error(fault).at(row.place(column)));
        }
        for (value, column) in measured.iter().zip(observes.columns()) {
            faults.check_size(row, column.name, *value);
        }
        measured
    }

    fn wrench(&self, row: &Row, faults: &mut Faults) -> [f64; 6] {
        WRENCH.iter().for_each(|column| faults.check_size(row, column, row.number(column)));
        let [force, torque] = [self.raw.units.force.factor(), self.raw.units.torque.factor()];
        std::array::from_fn(|k| row.number(WRENCH[k]) * if k < 3 { force } else { torque })
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

/// The set that a row gives: whether it is to check.
fn set(row: &Row, faults: &mut Faults) -> Option<bool> {
    match row.text("set")? {
        "fit" => Some(false),
        "check" => Some(true),
        other => {
            faults.unknown(row, "set", other, ["fit", "check"]);
            None
        }
    }
}

/// The anchor of a row, by index; the first where the kind of readings needs none.
fn anchor(row: &Row, campaign: &Campaign, faults: &mut Faults) -> usize {
    let Some(column) = campaign.observes.anchor_column() else { return 0 };
    let found = row.text(column).map(|name| (name, campaign.anchors.get_index_of(name)));
    match found {
        Some((_, Some(index))) => return index,
        Some((name, None)) => faults.unknown(row, column, name, campaign.anchors.keys().map(String::as_str)),
        None if campaign.anchors.len() > 1 => {
            let diagnostic = Diagnostic::error("several anchors are declared, and the rows do not name one");
            let measured = campaign.observes.columns().first().and_then(|measured| row.place(measured.name));
            faults.push(diagnostic.at(measured).remedy(format!("add a column `{column}`")));
        }
        None => {}
    }
    0
}
