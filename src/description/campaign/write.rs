//! Measurements as a CSV with the columns that [`super::expected_columns`] names: mm, deg, N, N.m, s.

use std::io;

use super::{Campaign, ConditionColumn, Reading, WRENCH};
use crate::description::robot::Variable;
use crate::description::table::Sheet;
use crate::parameter::Kind;

/// The readings of a campaign, one a row. `variables` and `markers` are the robot's; the set is `fit` where none is given.
///
/// # Errors
/// As [`Sheet::csv`].
pub fn csv(campaign: &Campaign, variables: &[Variable], markers: &[String]) -> io::Result<String> {
    let readings = &campaign.readings;
    let any = |holds: fn(&Reading) -> bool| readings.iter().any(holds);
    let mut sheet = Sheet::new();
    sheet.column("pose", |row| campaign.poses[readings[row].pose].clone());
    if any(|reading| reading.marker.is_some()) {
        sheet.column("marker", |row| readings[row].marker.map_or("TCP".into(), |marker| markers[marker].clone()));
    }
    for (k, variable) in variables.iter().enumerate() {
        sheet.column(&variable.name, move |row| {
            let value = campaign.configuration(row)[k];
            format!("{:.9}", if variable.is_angle { value.to_degrees() } else { value * 1e3 })
        });
    }
    for (k, column) in campaign.observes.columns().iter().enumerate() {
        sheet.column(column.name, move |row| {
            let value = readings[row].measured[k];
            match column.kind {
                Kind::Length => format!("{:.6}", value * 1e3),
                Kind::Angle => format!("{:.9}", value.to_degrees()),
                _ => value.to_string(),
            }
        });
    }
    if let Some(name) = campaign.observes.anchor_column() {
        sheet.column(name, |row| {
            campaign.anchors.get_index(readings[row].anchor).map_or_else(String::new, |(name, _)| name.clone())
        });
    }
    if any(|reading| reading.wrench != [0.0; 6]) {
        for (k, name) in WRENCH.into_iter().enumerate() {
            sheet.column(name, move |row| readings[row].wrench[k].to_string());
        }
    }
    let mut conditions: Vec<_> = campaign.conditions.columns().collect();
    conditions.sort_by_key(|(condition, _)| *condition != ConditionColumn::Time);
    for (condition, values) in conditions {
        sheet.column(condition.column(|k| variables[k].name.as_str()), |row| values[row].to_string());
    }
    sheet.column("set", |row| if readings[row].check == Some(true) { "check" } else { "fit" }.into());
    sheet.csv(0..readings.len())
}
