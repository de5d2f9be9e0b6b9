//! Rows of measurement tables as readings, in SI; every fault located. Of each table the first faults are shown, the others
//! counted.

use std::collections::HashMap;

use super::bodies::sensor;
use super::columns::{joint_column, other_columns};
use super::faults::{GREATEST_NOISE, LEAST_NOISE, no_name};
use super::order::{numbered_twice, order_readings};
use super::raw::{LoadSource, RawCampaign, RawEntry, RowOrder};
use super::row::{Faults, OfFile, Row};
use super::row_loads::{load_point, payload, wrench};
use super::source::Source;
use super::stated::{NOISE_COLUMNS, stated_noise};
use super::{Campaign, InSession, Reading, noise_of};
use crate::description::columns::TOOL_POINT;
use crate::description::robot::Robot;
use crate::description::table::{MOST_SHOWN, Table};
use crate::description::units::Units;
use crate::diagnostic::{Diagnostic, Locate};
use crate::observation::{MOST_ROWS, Noise, Observes, Rows, ValueColumn};

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
    locate: Locate<'a>,
    /// Configurations by session and name.
    poses: HashMap<(InSession, String), usize>,
    /// By configuration.
    sets: Vec<SetOfPose>,
    /// Rows of the tables before.
    rows_before: usize,
    /// By reading: the number in its order of measurement, where the files give one.
    orders: Vec<Option<i64>>,
}

impl<'a> RowReader<'a> {
    pub fn new(raw: &'a RawCampaign, robot: &'a Robot, locate: Locate<'a>) -> Self {
        Self { raw, robot, locate, poses: HashMap::new(), sets: Vec::new(), rows_before: 0, orders: Vec::new() }
    }

    /// Appends the readings of a table and their conditions.
    pub fn append(&mut self, source: &Source, campaign: &mut Campaign, diagnostics: &mut Vec<Diagnostic>) {
        let Source { table, entry, kinds } = source;
        let file = OfFile { entry, number: campaign.files.len(), locate: self.locate };
        let before = campaign.readings.len();
        let units = entry.units(self.raw.units);
        let mut faults = Faults::default();
        // By reading: the row of the table.
        let mut rows = Vec::new();
        for index in 0..table.row_count() {
            let number = self.rows_before + index + 1;
            // Markers of one row are of one configuration.
            let own = self.rows_before + index - index % entry.markers.len().max(1) + 1;
            let row = Row { table, row: index, units };
            let check = set(&row, &mut faults);
            let session = in_session(&row, entry, campaign, &mut faults);
            let marker = self.marker(&row, &mut faults);
            let blank = Reading {
                row: number,
                line: table.line(index).unwrap_or_default(),
                pose: self.pose(&row, session, own, check, campaign, &mut faults),
                observes: campaign.observes,
                marker,
                measured: [0.0; MOST_ROWS],
                noise: noise(&row, entry, &mut faults),
                target: None,
                session,
                wrench: wrench(&row, &mut faults),
                load_point: load_point(&row, &file, self.robot, marker, &mut faults),
                load: 0.0,
                payload: payload(&row, &file, campaign, &mut faults),
                check,
            };
            self.check_sides(&row, &mut faults);
            check_order(&row, &mut faults);
            let first = campaign.readings.len();
            kinds.iter().for_each(|&kind| self.readings(&row, kind, entry, blank, campaign, &mut faults));
            for _ in first..campaign.readings.len() {
                self.joints(&row, &mut campaign.joints, &mut faults);
                self.orders.push(row.order());
                rows.push(index);
            }
        }
        diagnostics.append(&mut faults.shown);
        if faults.count > MOST_SHOWN {
            let more = faults.count - MOST_SHOWN;
            diagnostics.push(Diagnostic::error(format!("and {more} more like these in {}", table.file())));
        }
        self.rows_before += table.row_count();
        campaign.files.push((table.file().to_owned(), self.rows_before));
        self.conditions(table, &units, before, &rows, campaign);
    }

    /// Says of each reading what was measured before it, once all tables are appended; numbers of the order given twice are
    /// faults, and so are numbers where the campaign states otherwise how rows follow one another.
    pub fn finish(self, campaign: &mut Campaign, stated: Option<RowOrder>, locate: Locate) -> Vec<Diagnostic> {
        let is_numbered = self.orders.iter().any(Option::is_some);
        order_readings(campaign, &self.orders, stated.filter(|_| !is_numbered));
        let twice = stated.filter(|_| is_numbered).map(|_| {
            Diagnostic::error("`order:` says how rows follow one another, and a column `order` numbers them")
                .at(locate(&["order"]))
                .remedy("leave `order:` out, or the column")
        });
        numbered_twice(campaign, &self.orders).into_iter().chain(twice).collect()
    }

    /// Appends the readings of one kind that a row holds.
    fn readings(
        &self,
        row: &Row,
        observes: Observes,
        entry: &RawEntry,
        blank: Reading,
        campaign: &mut Campaign,
        faults: &mut Faults,
    ) {
        if let Some(prefix) = observes.by_variable() {
            return self.by_variable(row, observes, prefix, blank, campaign, faults);
        }
        let [marker, target] = match observes.ignores_arrangement() {
            true => sensor(entry, self.robot, campaign),
            false => [blank.marker, target(row, entry, observes, campaign, faults)],
        };
        // What is touched decides the kind of a contact; other kinds refer to nothing.
        let of_target =
            target.and_then(|target| campaign.targets.get(target)).filter(|_| observes.target_column().is_some());
        let observes = of_target.and_then(|target| target.observes).unwrap_or(observes);
        let reading = Reading { observes, marker, target, ..blank };
        let of_target = target.and_then(|target| campaign.targets.get(target));
        let is_free = of_target.iter().flat_map(|target| &target.values).map(|value| value.parameter.is_some());
        let measured = measured(row, observes, &is_free.collect::<Vec<bool>>(), faults);
        campaign.readings.push(Reading { measured, noise: reading.noise.at(&*observes, &measured), ..reading });
    }

    /// Appends a reading for each variable of which the table has a column.
    fn by_variable(
        &self,
        row: &Row,
        observes: Observes,
        prefix: &str,
        blank: Reading,
        campaign: &mut Campaign,
        faults: &mut Faults,
    ) {
        for variable in &self.robot.variables {
            let column = format!("{prefix}.{}", variable.name);
            let Some(value) = row.given(&column) else { continue };
            let factor = if variable.is_angle { row.units.torque.factor() } else { row.units.force.factor() };
            faults.check_size(row, &column, value * factor);
            let mut measured = [0.0; MOST_ROWS];
            measured[0] = value * factor;
            let Some(target) = campaign.sensor_of(&observes, &variable.name) else {
                let diagnostic = Diagnostic::error(format!("column `{column}`: a campaign reads joints in one way"));
                faults.push(diagnostic.at(row.place(&column)).remedy("write a campaign for each kind"));
                continue;
            };
            campaign.readings.push(Reading { observes, target: Some(target), measured, ..blank });
        }
    }

    fn joints(&self, row: &Row, joints: &mut Vec<f64>, faults: &mut Faults) {
        for variable in &self.robot.variables {
            let column = joint_column(self.raw, &variable.name);
            let value = row.number(&column) * row.units.of(variable.kind());
            faults.check_size(row, &column, value);
            joints.push(value);
        }
    }

    /// The marker; none for the tool centre point.
    fn marker(&self, row: &Row, faults: &mut Faults) -> Option<usize> {
        let name = row.text("marker").filter(|name| !TOOL_POINT.contains(name))?;
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
        session: InSession,
        number: usize,
        check: Option<bool>,
        campaign: &mut Campaign,
        faults: &mut Faults,
    ) -> usize {
        let name = row.text("pose").map_or_else(|| format!("row {number}"), String::from);
        let key = (session, name.clone());
        let Some(&pose) = self.poses.get(&key) else {
            self.sets.push(SetOfPose { check, is_reported: false });
            campaign.poses.push(name.clone());
            self.poses.insert(key, campaign.poses.len() - 1);
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

    /// A side of approach is one of two, or not known.
    fn check_sides(&self, row: &Row, faults: &mut Faults) {
        for variable in &self.robot.variables {
            let column = format!("approach.{}", variable.name);
            if let Some(side) = row.given(&column).filter(|side| ![-1.0, 0.0, 1.0].contains(side)) {
                let diagnostic = Diagnostic::error(format!("column `{column}`: `{side}` is no side of approach"));
                let remedy = "write 1 where the joint came from above, its value falling, -1 where it came from below, 0 where that is not known";
                faults.push(diagnostic.at(row.place(&column)).remedy(remedy));
            }
        }
    }

    /// Conditions of a table's readings (`rows` of it), behind those of the tables before it.
    fn conditions(&self, table: &Table, units: &Units, before: usize, rows: &[usize], campaign: &mut Campaign) {
        let append = |column: &mut Option<Vec<f64>>, name: &str, factor: f64| {
            if let Some(values) = table.numbers(name) {
                let column = column.get_or_insert_default();
                column.resize(before, f64::NAN);
                column.extend(rows.iter().map(|&row| values[row] * factor));
            }
        };
        let conditions = &mut campaign.conditions;
        append(&mut conditions.temperature, "temperature", 1.0);
        append(&mut conditions.time, "time", units.time.factor());
        let count = self.robot.variables.len();
        conditions.approach.resize(count, None);
        conditions.other_joints.resize(count, None);
        if self.raw.loads.joints == LoadSource::Measured {
            conditions.torques.resize(count, None);
        }
        for (k, variable) in self.robot.variables.iter().enumerate() {
            append(&mut conditions.approach[k], &format!("approach.{}", variable.name), 1.0);
            for column in other_columns(self.raw, &variable.name) {
                append(&mut conditions.other_joints[k], &column, units.of(variable.kind()));
            }
            if let Some(torques) = conditions.torques.get_mut(k) {
                let factor = if variable.is_angle { units.torque.factor() } else { units.force.factor() };
                append(torques, &format!("torque.{}", variable.name), factor);
            }
        }
        for frame in &self.robot.frames {
            let mut column = conditions.site_temperatures.shift_remove(&frame.name);
            append(&mut column, &format!("temperature.{}", frame.name), 1.0);
            conditions.site_temperatures.extend(column.map(|column| (frame.name.clone(), column)));
        }
        let all = campaign.readings.len();
        conditions.all_mut().for_each(|column| column.resize(all, f64::NAN));
    }
}

/// A number in the order of measurement is an integer.
fn check_order(row: &Row, faults: &mut Faults) {
    if let Some(number) = row.given("order").filter(|number| number.fract() != 0.0) {
        let diagnostic = Diagnostic::error(format!("column `order`: `{number}` is no whole number"));
        faults.push(diagnostic.at(row.place("order")).remedy("number the readings 1, 2, 3 as they were measured"));
    }
}

fn measured(row: &Row, observes: Observes, is_free: &[bool], faults: &mut Faults) -> Rows {
    let mut measured = [0.0; MOST_ROWS];
    let other = observes.other_columns();
    let lacks = observes.columns().iter().any(|column| !row.table.has(column.name));
    if lacks && !other.is_empty() {
        let read = |column: &ValueColumn| row.number(column.name) * row.units.of(column.kind);
        return observes.of_other_columns(&other.iter().map(read).collect::<Vec<f64>>());
    }
    for (value, column) in measured.iter_mut().zip(observes.columns()) {
        *value = row.number(column.name) * row.units.of(column.kind);
    }
    if let Some(fault) = observes.fault(&measured, is_free) {
        faults.push(Diagnostic::error(fault.message).at(row.place(fault.column)).remedy(fault.remedy));
    }
    for (value, column) in measured.iter().zip(observes.columns()) {
        faults.check_size(row, column.name, *value);
    }
    measured
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

/// What a row of a kind of readings refers to, by index; `None` where the kind needs nothing, or what it needs is not there.
fn target(row: &Row, entry: &RawEntry, observes: Observes, campaign: &Campaign, faults: &mut Faults) -> Option<usize> {
    let column = observes.target_column()?;
    let mut own = campaign.targets.iter().enumerate().filter(|(_, target)| target.column == column);
    let Some(name) = row.text(column) else {
        let first = own.next().map(|(index, _)| index);
        if own.next().is_some() {
            let diagnostic = Diagnostic::error(format!("several {column}s are declared, and the rows do not name one"));
            let measured = observes.columns().first().and_then(|measured| row.place(measured.name));
            let place = measured.or_else(|| row.place(row.table.first_column()));
            faults.push(diagnostic.at(place).remedy(format!("add a column `{column}`")));
        }
        return first;
    };
    let found = own.clone().find(|(_, target)| target.is_meant(name, |group| row.text(group).or(entry.named(group))));
    if let Some((index, _)) = found {
        return Some(index);
    }
    // Of a contact without a group the cell may be empty.
    let mut groups =
        own.clone().filter(|(_, target)| target.member.0 == name).filter_map(|(_, of)| of.member.1.as_ref());
    if let Some([group, _]) = groups.find(|[group, _]| row.text(group).is_some_and(str::is_empty)) {
        let message = format!("empty cell in column `{group}`, by which the {column} `{name}` is grouped");
        faults.push(Diagnostic::error(message).at(row.place(group)).remedy("fill it in, or remove the row"));
        return None;
    }
    // Where none is declared, that is said once, of the campaign.
    if own.clone().next().is_some() || !(observes.needs_anchor() || observes.touches()) {
        faults.unknown(row, column, name, own.map(|(_, target)| target.member.0.as_str()));
    }
    None
}

/// Noise of a row's readings: as its columns say, else as its file's instrument says.
fn noise(row: &Row, entry: &RawEntry, faults: &mut Faults) -> Noise {
    let stated = stated_noise(entry.instrument.as_ref(), &row.units);
    let mut noise = noise_of(stated.sigma, stated.orientation);
    noise.ppm = stated.ppm;
    noise.load = stated.load.unwrap_or(noise.load);
    noise.is_stated[2] = stated.load.is_some();
    for (column, axes, factor) in NOISE_COLUMNS {
        let Some(value) = row.given(column) else { continue };
        let sigma = value * factor * row.units.length.factor();
        if !(LEAST_NOISE..=GREATEST_NOISE).contains(&sigma) {
            let message = match sigma.is_finite() && sigma > GREATEST_NOISE {
                true => format!("column `{column}`: `{value}`: more than {GREATEST_NOISE} m is no measurement"),
                false => format!("column `{column}`: `{value}` where a finite noise above 0 is needed"),
            };
            let remedy = "give one standard deviation, in the unit of the readings";
            faults.push(Diagnostic::error(message).at(row.place(column)).remedy(remedy));
        }
        axes.iter().for_each(|&axis| noise.position[axis] = sigma);
        noise.is_stated[0] = true;
    }
    noise
}

/// Session and station of a row.
fn in_session(row: &Row, entry: &RawEntry, campaign: &mut Campaign, faults: &mut Faults) -> InSession {
    let mut index = |column: &str, of_file: Option<&str>, names: &mut Vec<String>| {
        let of_row = row.text(column);
        if let Some(fault) = of_row.and_then(|name| no_name(column, name)) {
            faults.push(fault.at(row.place(column)));
        }
        let name = of_row.or(of_file).unwrap_or_default();
        names.iter().position(|known| known == name).unwrap_or_else(|| {
            names.push(name.to_string());
            names.len() - 1
        })
    };
    let sessions = &mut campaign.sessions;
    InSession {
        session: index("session", entry.session.as_deref(), &mut sessions.names),
        station: index("station", entry.station.as_deref(), &mut sessions.stations),
    }
}
