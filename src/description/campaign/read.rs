//! A campaign file and its tables against the model they are about.

use nalgebra::Vector3;

use super::doubts::doubts;
use super::raw::{RawCampaign, RawSigma};
use super::rows::RowReader;
use super::{Campaign, Conditions, WRENCH};
use crate::description::resolve::Locate;
use crate::description::robot::Robot;
use crate::description::table::{ColumnKind, ExpectedColumn, Table};
use crate::diagnostic::Diagnostic;
use crate::observation::POSITION;

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
        let diagnostic = Diagnostic::error(message).at(locate(&["observes"]));
        diagnostics.push(diagnostic.remedy("add `anchors: {name: [x, y, z]}`, in the measurement frame"));
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
    let mut rows = RowReader::new(raw, robot);
    for table in tables {
        rows.append(table, &mut campaign, &mut diagnostics);
    }
    diagnostics.extend(time_in_some(locate, tables));
    if !diagnostics.iter().any(Diagnostic::is_error) {
        diagnostics.extend(doubts(&campaign, &raw.units, locate, robot, tables));
    }
    if diagnostics.iter().any(Diagnostic::is_error) { Err(diagnostics) } else { Ok((campaign, diagnostics)) }
}

/// Times count from one start: all tables have them, or none.
fn time_in_some(locate: Locate, tables: &[Table]) -> Option<Diagnostic> {
    let with = tables.iter().find(|table| table.has("time"))?;
    let lacking = tables.iter().find(|table| !table.has("time"))?;
    let message = format!("`{}` has a column `time`, but `{}` has not", with.file(), lacking.file());
    let diagnostic = Diagnostic::error(message).at(locate(&["measurements"]));
    Some(diagnostic.remedy("give `time` in all files or in none"))
}
