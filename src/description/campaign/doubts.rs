//! What a campaign's readings say that can hardly be meant.

use indexmap::IndexMap;

use super::Campaign;
use crate::description::limits::{READINGS, beyond};
use crate::description::resolve::Locate;
use crate::description::robot::{Robot, Variable};
use crate::description::table::Table;
use crate::description::units::Units;
use crate::diagnostic::{Diagnostic, Place};

/// Variables of one configuration agree to this, rad or m: rounding in a file, and less than a joint moves on purpose.
const SAME_CONFIGURATION: f64 = 1e-3;

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
    // By configuration: a reading that differs from the first one, and the variable in which it does.
    let mut differing: IndexMap<usize, (usize, usize)> = IndexMap::new();
    for (index, reading) in campaign.readings.iter().enumerate() {
        let before = *first[reading.pose].get_or_insert(index);
        let (here, there) = (campaign.configuration(index), campaign.configuration(before));
        if let Some(variable) = here.iter().zip(there).position(|(a, b)| (a - b).abs() > SAME_CONFIGURATION) {
            differing.entry(reading.pose).or_insert((index, variable));
        }
    }
    let (&pose, &(index, variable)) = differing.first()?;
    let before = first[pose]?;
    let Variable { name, is_angle, .. } = &robot.variables[variable];
    let (unit, factor) = if *is_angle {
        (units.angle.symbol(), units.angle.factor())
    } else {
        (units.length.symbol(), units.length.factor())
    };
    let [here, there] = [index, before].map(|reading| campaign.configuration(reading)[variable] / factor);
    let more = if differing.len() > 1 { format!("; so have {} more", differing.len() - 1) } else { String::new() };
    let pose = &campaign.poses[pose];
    let message = format!(
        "the pose `{pose}` has rows with different joints: `{name}` is {here:.4} {unit}, and {there:.4} {unit} before{more}"
    );
    let diagnostic =
        Diagnostic::warning(message).at(place(index, name)).related(place(before, name), "first given here");
    Some(diagnostic.remedy("give each configuration a name of its own: readings of one name count as taken together"))
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
