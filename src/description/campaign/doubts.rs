//! What a campaign's readings say that can hardly be meant.

use super::Campaign;
use crate::description::limits::{READINGS, beyond};
use crate::description::resolve::Locate;
use crate::description::robot::Robot;
use crate::description::table::Table;
use crate::description::units::Units;
use crate::diagnostic::{Diagnostic, Place};

/// Configurations of one name that differ by more than this (rad or m) are two.
const ANOTHER: f64 = 1e-3;

/// Variables beyond their limits, a name for two configurations, deflections that nothing causes (an error).
pub fn doubts(campaign: &Campaign, units: &Units, locate: Locate, robot: &Robot, tables: &[Table]) -> Vec<Diagnostic> {
    let place = |reading: usize, column: &str| place(tables, reading, column);
    let mut diagnostics = Vec::new();
    // A path may have no joints.
    if robot.variables.iter().all(|variable| tables.iter().all(|table| table.has(&variable.name))) {
        let configurations = (0..campaign.readings.len()).map(|reading| campaign.configuration(reading));
        diagnostics.extend(beyond(&robot.variables, units, READINGS, configurations, place));
    }
    diagnostics.extend(one_name_for_two(campaign, units, robot, &place));
    let unloaded = campaign.readings.iter().all(|reading| reading.wrench == [0.0; 6]);
    if campaign.observes.is_difference() && unloaded && !campaign.readings.is_empty() {
        let diagnostic =
            Diagnostic::error(format!("{}s are observed, and no reading is loaded", campaign.observes.name()))
                .at(locate(&["observes"]));
        diagnostics.push(diagnostic.remedy("give the load of each reading in columns fx, fy, fz, mx, my, mz"));
    }
    diagnostics
}

/// The first pose whose readings have different joints, and how many more there are.
fn one_name_for_two(
    campaign: &Campaign,
    units: &Units,
    robot: &Robot,
    place: &impl Fn(usize, &str) -> Option<Place>,
) -> Option<Diagnostic> {
    let mut first: Vec<Option<usize>> = vec![None; campaign.poses.len()];
    let mut told = vec![false; campaign.poses.len()];
    let mut found: Option<(usize, usize, usize)> = None;
    for (index, reading) in campaign.readings.iter().enumerate() {
        let Some(before) = first[reading.pose] else {
            first[reading.pose] = Some(index);
            continue;
        };
        let (here, there) = (campaign.configuration(index), campaign.configuration(before));
        if let Some(variable) = here.iter().zip(there).position(|(a, b)| (a - b).abs() > ANOTHER)
            && !told[reading.pose]
        {
            told[reading.pose] = true;
            found = found.or(Some((before, index, variable)));
        }
    }
    let (before, index, variable) = found?;
    let more = told.iter().filter(|told| **told).count() - 1;
    let Variable { name, unit, factor } = Variable::of(robot, variable, units);
    let value = |reading: usize| format!("{:.4}", campaign.configuration(reading)[variable] / factor);
    let pose = &campaign.poses[campaign.readings[index].pose];
    let rest = if more > 0 { format!("; so have {more} more") } else { String::new() };
    let message = format!(
        "the pose `{pose}` has rows with different joints: `{name}` is {} {unit}, and {} {unit} before{rest}",
        value(index),
        value(before)
    );
    let diagnostic =
        Diagnostic::warning(message).at(place(index, name)).related(place(before, name), "first given here");
    Some(diagnostic.remedy("give each configuration a name of its own: readings of one name count as taken together"))
}

/// A variable as the campaign writes it.
struct Variable<'a> {
    name: &'a str,
    unit: &'static str,
    factor: f64,
}

impl<'a> Variable<'a> {
    fn of(robot: &'a Robot, index: usize, units: &Units) -> Self {
        let variable = &robot.variables[index];
        let (unit, factor) = if variable.is_angle {
            (units.angle.symbol(), units.angle.factor())
        } else {
            (units.length.symbol(), units.length.factor())
        };
        Self { name: &variable.name, unit, factor }
    }
}

/// Where a reading's column stands, by its index through all tables.
fn place(tables: &[Table], reading: usize, column: &str) -> Option<Place> {
    let mut row = reading;
    for table in tables {
        if row < table.row_count() {
            return table.place(row, column);
        }
        row -= table.row_count();
    }
    None
}
