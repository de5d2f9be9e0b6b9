//! The readings of one entry of a campaign's `measurements:`, from a table or a list of points, and from a file of their joints
//! where that is another one.

use std::io::Read;

use crate::description::campaign::raw::{Format, RawCsv, RawEntry};
use crate::description::table::{Dialect, ExpectedColumn, Points, Table, read_table, widened};
use crate::description::units::Units;
use crate::diagnostic::{Diagnostic, Place};

/// What is asked of the files of an entry.
pub(super) struct Asked<'a> {
    /// Columns that both files together may or must have.
    pub expected: Vec<ExpectedColumn>,
    /// The robot's variables: what a file of joints holds.
    pub variables: Vec<&'a str>,
    pub units: &'a Units,
    /// The entry, completed by the campaign.
    pub entry: &'a RawEntry,
}

/// Keys of an entry that mean nothing without another, and names that neither of two files can have.
pub(super) fn faults(asked: &Asked, locate: impl Fn(&str) -> Option<Place>) -> Vec<Diagnostic> {
    let entry = asked.entry;
    let alone = |key: &str, is_alone: bool, remedy: &str| {
        let fault = Diagnostic::error(format!("`{key}:` means nothing here")).at(locate(key));
        is_alone.then(|| fault.remedy(remedy))
    };
    let of_table = entry.points.is_some() && entry.format != Some(Format::Points);
    let all = [
        alone("points", of_table, "it says what the fields of a list of points are: add `format: points`"),
        alone("markers", !entry.markers.is_empty() && measured(asked).is_empty(), "no readings here are of markers"),
        alone(
            "joint_columns",
            !entry.joint_columns.is_empty() && entry.joints.is_none(),
            "add `joints:`, the file they are of",
        ),
        alone("join", entry.join.is_some() && entry.joints.is_none(), "add `joints:`, the file to be joined"),
    ];
    let mut faults: Vec<Diagnostic> = all.into_iter().flatten().collect();
    let twice = |(k, marker): (usize, &String)| entry.markers.iter().take(k).any(|before| before == marker);
    if let Some((_, marker)) = entry.markers.iter().enumerate().find(|each| twice(*each)) {
        let fault = Diagnostic::error(format!("`markers:` names `{marker}` twice"));
        faults.push(fault.at(locate("markers")).remedy("name each marker of a row once"));
    }
    if entry.joints.is_some() {
        let expected = entry.orientation.unwrap_or_default().expected(asked.expected.clone());
        let names = || expected.iter().map(|column| column.name.as_str());
        for (key, columns) in [("columns", &entry.columns), ("joint_columns", &entry.joint_columns)] {
            for ours in columns.keys().filter(|ours| names().all(|name| name != ours.as_str())) {
                let fault = Diagnostic::error(format!("`{key}:` renames `{ours}`, which is no column here"));
                faults.push(fault.at(locate(key)).suggest(ours, names()));
            }
        }
    }
    faults
}

/// Reads the file of the readings, and the second one as that of their joints; each with its name.
pub(super) fn read(asked: &Asked, files: Vec<(String, Box<dyn Read>)>) -> Result<Table, Vec<Diagnostic>> {
    let entry = asked.entry;
    let csv = entry.csv.clone().unwrap_or_default();
    let orientation = entry.orientation.unwrap_or_default();
    let is_list = entry.format == Some(Format::Points);
    let points = is_list.then(|| entry.points.as_ref().map_or_else(Points::default, Points::from));
    let own = Dialect {
        delimiter: csv.delimiter,
        decimal: csv.decimal,
        orientation,
        points,
        is_shared: files.len() > 1,
        of_campaign: true,
    };
    // How the file of the joints is written is seen from itself.
    let of_joints = Dialect { is_shared: true, of_campaign: true, ..Dialect::default() };
    let (joints, mut readings) = split(orientation.expected(asked.expected.clone()), asked, files.len() > 1);
    let needed = readings.iter().filter(|column| column.required);
    let of_readings: Vec<String> = needed.map(|column| column.name.clone()).collect();
    let of_marker = measured(asked);
    if !entry.markers.is_empty() {
        readings = widened(readings, &entry.markers, &of_marker);
    }
    let (mut tables, mut faults) = (Vec::new(), Vec::new());
    let mut joint_columns = entry.columns.clone();
    joint_columns.extend(entry.joint_columns.clone());
    let asked_of_each = [(readings, own, &entry.columns), (joints, of_joints, &joint_columns)];
    for ((name, bytes), (expected, dialect, columns)) in files.into_iter().zip(asked_of_each) {
        let most = csv.max_rows.unwrap_or(RawCsv::MOST_ROWS);
        match read_table(&name, bytes, &expected, columns, &entry.ignore, &dialect, most) {
            Ok(table) => tables.push(table),
            Err(mut found) => faults.append(&mut found),
        }
    }
    let mut tables = tables.into_iter();
    let Some(mut table) = tables.next().filter(|_| faults.is_empty()) else { return Err(faults) };
    if let Some(mut joints) = tables.next() {
        joints.leave_out(&of_readings, table.file());
        table = table.with_joints(joints, entry.join)?;
    }
    if !entry.markers.is_empty() {
        table = table.by_marker(&entry.markers, &of_marker)?;
    }
    table.add_rotation_vectors(orientation, asked.units.angle)?;
    Ok(table)
}

/// The columns of a file of joints, and those of the readings: what is required stands in one of them, all else in either. A file of
/// joints may have the place that the controller shows in the columns of the readings as well.
fn split(expected: Vec<ExpectedColumn>, asked: &Asked, has_joints: bool) -> (Vec<ExpectedColumn>, Vec<ExpectedColumn>) {
    if !has_joints {
        return (Vec::new(), expected);
    }
    let is_joint = |column: &ExpectedColumn| is_joint(column, asked);
    let in_joints = |column: &ExpectedColumn| column.clone().required_if(is_joint(column));
    let joints = expected.iter().map(in_joints).collect();
    let readings = expected.iter().filter(|column| !is_joint(column)).cloned().collect();
    (joints, readings)
}

fn is_joint(column: &ExpectedColumn, asked: &Asked) -> bool {
    let prefixes = ["approach.", "commanded.", "recorded."];
    let variable = prefixes.iter().find_map(|prefix| column.name.strip_prefix(prefix));
    asked.variables.contains(&variable.unwrap_or(&column.name))
}

/// Columns of what is measured of a point: all that a reading must have, but for joints and what is read of each.
fn measured(asked: &Asked) -> Vec<String> {
    let expected = asked.entry.orientation.unwrap_or_default().expected(asked.expected.clone());
    let own = expected.into_iter().filter(|column| column.required && !is_joint(column, asked));
    own.map(|column| column.name).collect()
}
