//! What a campaign's readings say that can hardly be meant.

use indexmap::IndexMap;

use super::Campaign;
use super::columns::joint_column;
use super::raw::RawCampaign;
use super::source::Source;
use crate::description::limits::{READINGS, beyond};
use crate::description::resolve::Locate;
use crate::description::robot::{Robot, Variable};
use crate::description::units::Units;
use crate::diagnostic::{Diagnostic, Place};

/// Variables of one configuration agree to this, rad or m: rounding in a file, and less than a joint moves on purpose.
const SAME_CONFIGURATION: f64 = 1e-3;

/// Variables beyond their limits, a name for two configurations, deflections that nothing causes (an error).
pub fn doubts(
    campaign: &Campaign,
    raw: &RawCampaign,
    locate: Locate,
    robot: &Robot,
    sources: &[Source],
) -> Vec<Diagnostic> {
    let units = &raw.units;
    let place = |reading: usize, column: &str| place(sources, campaign.readings[reading].row, column);
    let mut diagnostics = Vec::new();
    // A path may have no joints.
    let has_all =
        |source: &Source| robot.variables.iter().all(|variable| source.table.has(&joint_column(raw, &variable.name)));
    if sources.iter().all(has_all) {
        let configurations = (0..campaign.readings.len()).map(|reading| campaign.configuration(reading));
        diagnostics.extend(beyond(&robot.variables, units, READINGS, configurations, place));
    }
    diagnostics.extend(one_name_for_two(campaign, units, robot, &place));
    let mut differences = campaign.readings.iter().filter(|reading| reading.observes.is_difference()).peekable();
    if differences.peek().is_some() && differences.all(|reading| !reading.is_loaded()) {
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

/// Where the column of a row stands, rows counted from 1 through all tables.
fn place(sources: &[Source], row: usize, column: &str) -> Option<Place> {
    let mut row = row.checked_sub(1)?;
    for Source { table, .. } in sources {
        if row < table.row_count() {
            return table.place(row, column);
        }
        row -= table.row_count();
    }
    None
}
