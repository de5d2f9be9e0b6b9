//! Measurements as a CSV with the columns that [`super::expected_columns`] names: mm, deg, N, N.m, s.

use std::io;

use super::{Campaign, ConditionColumn, InSession, Payload, Reading, WRENCH};
use crate::description::robot::Variable;
use crate::description::table::Sheet;
use crate::observation::{Observes, ValueColumn};
use crate::parameter::Kind;

/// The readings of a campaign, one a row. `variables` and `markers` are the robot's; the set is `fit` where none is given.
///
/// # Errors
/// As [`Sheet::csv`].
pub fn csv(campaign: &Campaign, variables: &[Variable], markers: &[String]) -> io::Result<String> {
    let readings = &campaign.readings;
    let any = |holds: fn(&Reading) -> bool| readings.iter().any(holds);
    let mut sheet = Sheet::new();
    sheet.texts("pose", |row| campaign.poses[readings[row].pose].clone());
    if any(|reading| reading.marker.is_some()) {
        sheet.texts("marker", |row| readings[row].marker.map_or("TCP".into(), |marker| markers[marker].clone()));
    }
    for (k, variable) in variables.iter().enumerate() {
        sheet.column(&variable.name, move |row| {
            let value = campaign.configuration(row)[k];
            format!("{:.9}", if variable.is_angle { value.to_degrees() } else { value * 1e3 })
        });
    }
    for column in measured_columns(campaign) {
        sheet.column(column.name, move |row| {
            let own = readings[row].observes.columns().iter().position(|known| known.name == column.name);
            let Some(value) = own.map(|k| readings[row].measured[k]) else { return String::new() };
            match column.kind {
                Kind::Length => format!("{:.6}", value * 1e3),
                Kind::Angle => format!("{:.9}", value.to_degrees()),
                _ => value.to_string(),
            }
        });
    }
    for name in target_columns(campaign) {
        sheet.texts(name, move |row| {
            let target = campaign.targets.get(readings[row].target);
            target.filter(|target| target.column == name).map_or_else(String::new, |target| target.member.0.clone())
        });
    }
    for (name, names, of) in [
        ("session", &campaign.sessions.names, (|at| at.session) as fn(&InSession) -> usize),
        ("station", &campaign.sessions.stations, |at| at.station),
    ] {
        if names.iter().any(|name| !name.is_empty()) {
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
            sheet.column(name, move |row| readings[row].wrench[k].to_string());
        }
    }
    if campaign.conditions.is_ordered {
        sheet.column("order", move |row| readings[row].pose.to_string());
    }
    let mut conditions: Vec<_> = campaign.conditions.columns().collect();
    conditions.sort_by_key(|(condition, _)| *condition != ConditionColumn::Time);
    for (condition, values) in conditions {
        sheet.column(condition.column(|k| variables[k].name.as_str()), |row| values[row].to_string());
    }
    sheet.texts("set", |row| if readings[row].check == Some(true) { "check" } else { "fit" }.into());
    sheet.csv(0..readings.len())
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
    let mut kinds = vec![campaign.observes];
    for reading in &campaign.readings {
        if kinds.iter().all(|kind| *kind != reading.observes) {
            kinds.push(reading.observes);
        }
    }
    kinds
}
