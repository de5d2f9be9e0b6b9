//! Measurements as a CSV with the columns that [`super::expected_columns`] names.

use std::io;

use indexmap::IndexMap;

use super::sessions::{SESSION, STATION};
use super::{Campaign, ConditionColumn, InSession, OrderBy, Payload, Reading, WRENCH};
use crate::description::robot::Variable;
use crate::description::table::Sheet;
use crate::description::units::{Angle, Force, Length, Torque, Units};
use crate::observation::{Observes, ValueColumn};
use crate::parameter::Kind;

/// The readings of a campaign, one a row: mm, deg, N, N.m, s. `variables` and `markers` are the robot's; the set is `fit` where
/// none is given.
///
/// # Errors
/// As [`Sheet::csv`].
pub fn csv(campaign: &Campaign, variables: &[Variable], markers: &[String]) -> io::Result<String> {
    let units = Units {
        length: Length::Millimetre,
        angle: Angle::Degree,
        force: Force::Newton,
        torque: Torque::NewtonMetre,
        ..Units::default()
    };
    csv_in(campaign, variables, markers, &units)
}

/// A number with as many digits as an instrument could give.
fn shown(value: f64, kind: Kind, units: &Units) -> String {
    let value = value / units.of(kind);
    match kind {
        Kind::Length if units.length == Length::Millimetre => format!("{value:.6}"),
        Kind::Length | Kind::Angle if units.angle == Angle::Degree || kind == Kind::Length => format!("{value:.9}"),
        Kind::Angle => format!("{value:.11}"),
        _ => value.to_string(),
    }
}

/// The same in other units. Readings that were one row of a file are one row again.
///
/// # Errors
/// As [`Sheet::csv`].
pub fn csv_in(campaign: &Campaign, variables: &[Variable], markers: &[String], units: &Units) -> io::Result<String> {
    let readings = &campaign.readings;
    let begins = |row: &usize| *row == 0 || readings[*row].row == 0 || readings[*row].row != readings[*row - 1].row;
    let any = |holds: fn(&Reading) -> bool| readings.iter().any(holds);
    let mut sheet = Sheet::new();
    sheet.texts("pose", |row| campaign.poses[readings[row].pose].clone());
    if readings.iter().any(|reading| reading.marker.is_some_and(|marker| marker < markers.len())) {
        let name = |row: usize| readings[row].marker.and_then(|marker| markers.get(marker));
        sheet.texts("marker", move |row| name(row).map_or("TCP".into(), String::clone));
    }
    for (k, variable) in variables.iter().enumerate() {
        sheet.column(&variable.name, move |row| {
            let value = campaign.configuration(row)[k] / units.of(variable.kind());
            format!("{value:.9}")
        });
    }
    for column in measured_columns(campaign) {
        sheet.column(column.name, move |row| {
            let own = |reading: &Reading| {
                let own = reading.observes.columns().iter().position(|known| known.name == column.name);
                own.map(|k| reading.measured[k])
            };
            of_row(readings, row).find_map(own).map_or_else(String::new, |value| shown(value, column.kind, units))
        });
    }
    target_cells(&mut sheet, campaign);
    torque_cells(&mut sheet, campaign, variables, units);
    for (name, names, of) in [
        (SESSION, &campaign.sessions.names, (|at| at.session) as fn(&InSession) -> usize),
        (STATION, &campaign.sessions.stations, |at| at.station),
    ] {
        // Of a campaign's files some may say nothing of it.
        let is_named = |reading: &Reading| names.get(of(&reading.session)).is_some_and(|name| !name.is_empty());
        if readings.iter().any(is_named) {
            sheet.texts(name, move |row| names.get(of(&readings[row].session)).cloned().unwrap_or_default());
        }
    }
    if !campaign.payloads.is_empty() {
        sheet.texts("payload", |row| {
            let own = |(_, known): &&(String, Payload)| readings[row].payload == Some(*known);
            campaign.payloads.iter().find(own).map_or_else(|| "none".into(), |(name, _)| name.clone())
        });
    }
    if any(|reading| reading.wrench != [0.0; 6]) {
        for (k, name) in WRENCH.into_iter().enumerate() {
            let unit = if k < 3 { units.force.factor() } else { units.torque.factor() };
            sheet.column(name, move |row| (readings[row].wrench[k] / unit).to_string());
        }
    }
    if campaign.conditions.order == OrderBy::Numbers {
        sheet.column("order", move |row| readings[row].pose.to_string());
    }
    let mut conditions: Vec<_> = campaign.conditions.columns().collect();
    conditions.sort_by_key(|(condition, _)| *condition != ConditionColumn::Time);
    for (condition, values) in conditions {
        sheet.column(condition.column(|k| variables[k].name.as_str()), |row| values[row].to_string());
    }
    sheet.texts("set", |row| if readings[row].check == Some(true) { "check" } else { "fit" }.into());
    sheet.csv((0..readings.len()).filter(begins))
}

/// The readings that were one row of a file with the one at an index.
fn of_row(readings: &[Reading], row: usize) -> impl Iterator<Item = &Reading> {
    let more = readings[row + 1..].iter().take_while(move |other| other.row != 0 && other.row == readings[row].row);
    std::iter::once(&readings[row]).chain(more)
}

/// Columns that say what readings refer to, and in which placement of its fixture it stood.
fn target_cells<'a>(sheet: &mut Sheet<'a>, campaign: &'a Campaign) {
    let readings = &campaign.readings;
    for name in target_columns(campaign) {
        sheet.texts(name, move |row| {
            let own = |reading: &Reading| {
                let target = campaign.target_of(reading).filter(|target| target.column == name);
                target.filter(|_| reading.observes.target_column() == Some(name))
            };
            of_row(readings, row).find_map(own).map_or_else(String::new, |target| target.member.0.clone())
        });
    }
    // Sessions and stations are columns of their own.
    let is_own = |group: &&str| ![SESSION, STATION].contains(group);
    for group in
        groups(campaign).into_iter().filter(is_own).filter(|_| kinds_read(campaign).iter().any(|kind| kind.touches()))
    {
        sheet.texts(group, move |row| {
            let own = |reading: &Reading| {
                let target = campaign.target_of(reading);
                let target = target.filter(|target| reading.observes.target_column() == Some(target.column));
                let member = target.and_then(|target| target.member.1.as_ref());
                member.filter(|[column, _]| column == group).map(|[_, member]| member.clone())
            };
            of_row(readings, row).find_map(own).unwrap_or_default()
        });
    }
}

/// Columns of the readings of single joints.
fn torque_cells<'a>(sheet: &mut Sheet<'a>, campaign: &'a Campaign, variables: &'a [Variable], units: &Units) {
    let readings = &campaign.readings;
    for variable in variables {
        let of_variable = move |reading: &&Reading| {
            let target = campaign.target_of(reading);
            reading.observes.by_variable().is_some() && target.is_some_and(|own| own.member.0 == variable.name)
        };
        let Some(prefix) = readings.iter().find(of_variable).and_then(|reading| reading.observes.by_variable()) else {
            continue;
        };
        let unit = if variable.is_angle { units.torque.factor() } else { units.force.factor() };
        sheet.column(format!("{prefix}.{}", variable.name), move |row| {
            let own = of_row(readings, row).find(of_variable);
            own.map_or_else(String::new, |reading| (reading.measured[0] / unit).to_string())
        });
    }
}

/// What a row says of readings in addition to its joints, by column: what is touched and where, what is carried, in which session.
pub fn names(campaign: &Campaign, readings: &[Reading]) -> IndexMap<String, String> {
    let mut cells = IndexMap::new();
    for reading in readings {
        let target = campaign.target_of(reading);
        if let Some(target) = target.filter(|target| Some(target.column) == reading.observes.target_column()) {
            cells.insert(target.column.to_string(), target.member.0.clone());
            if let Some([group, member]) = &target.member.1 {
                cells.insert(group.clone(), member.clone());
            }
        }
        let session = campaign.sessions.names.get(reading.session.session).filter(|name| !name.is_empty());
        if let Some(name) = session {
            cells.insert(SESSION.into(), name.clone());
        }
        let station = campaign.sessions.stations.get(reading.session.station).filter(|name| !name.is_empty());
        if let Some(name) = station {
            cells.insert(STATION.into(), name.clone());
        }
        if !campaign.payloads.is_empty() {
            let own = campaign.payloads.iter().find(|(_, known)| Some(*known) == reading.payload);
            cells.insert("payload".into(), own.map_or_else(|| "none".into(), |(name, _)| name.clone()));
        }
    }
    cells
}

/// Columns that say in which placement a fixture stood.
fn groups(campaign: &Campaign) -> Vec<&str> {
    let mut groups: Vec<&str> = Vec::new();
    for [column, _] in campaign.targets.iter().filter_map(|target| target.member.1.as_ref()) {
        if !groups.contains(&column.as_str()) {
            groups.push(column);
        }
    }
    groups
}

/// Columns of the measured values of all kinds of readings.
fn measured_columns(campaign: &Campaign) -> Vec<ValueColumn> {
    let mut columns: Vec<ValueColumn> = Vec::new();
    for column in kinds_read(campaign).iter().flat_map(|kind| kind.columns()) {
        if columns.iter().all(|known| known.name != column.name) {
            columns.push(*column);
        }
    }
    columns
}

/// Columns that name what readings refer to.
fn target_columns(campaign: &Campaign) -> Vec<&'static str> {
    let mut columns: Vec<&str> = kinds_read(campaign).iter().filter_map(|kind| kind.target_column()).collect();
    columns.dedup();
    columns
}

/// Kinds of readings, in the order in which they first come; the campaign's where there are none.
fn kinds_read(campaign: &Campaign) -> Vec<Observes> {
    let mut kinds = Vec::new();
    for reading in &campaign.readings {
        if kinds.iter().all(|kind| *kind != reading.observes) {
            kinds.push(reading.observes);
        }
    }
    if kinds.is_empty() {
        kinds.push(campaign.observes);
    }
    kinds
}
