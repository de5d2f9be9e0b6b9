//! Paths: where a robot should pass, under what, read from a table with a campaign's columns.

use super::campaign::raw::{RawCampaign, RawEntry, RawKinds};
use super::campaign::{Campaign, LOAD_POINT, WRENCH, resolve};
use super::robot::Robot;
use super::table::{ColumnKind, ExpectedColumn, Table};
use super::units::{Unit, Units};
use crate::diagnostic::Diagnostic;
use crate::observation::{Kinds, POSE};

const POSITION: [&str; 3] = ["x", "y", "z"];
const ORIENTATION: [&str; 3] = ["rx", "ry", "rz"];

/// Points of a path in SI: a campaign that observes poses, its measurements where the points should be.
#[derive(Debug, Clone, PartialEq)]
pub struct Path {
    /// Joints, poses, markers, wrenches and conditions by row; zero where not given.
    pub campaign: Campaign,
    /// Whether the rows give joints.
    pub joints: bool,
    /// Whether they give positions.
    pub position: bool,
    /// Whether they give orientations.
    pub orientation: bool,
}

/// Columns a path of this robot may have, in units.
pub fn expected_columns(robot: &Robot, units: &Units) -> Vec<ExpectedColumn> {
    let column = |name: &str, kind| ExpectedColumn::new(name, kind, false);
    let number = |name: &str| column(name, ColumnKind::Number);
    let texts = ["pose", "marker"];
    let mut columns: Vec<ExpectedColumn> = texts.iter().map(|name| column(name, ColumnKind::Text)).collect();
    let of_kind = |kind| units.unit(kind).map_or(ColumnKind::Number, ColumnKind::Quantity);
    columns.extend(robot.variables.iter().map(|variable| column(&variable.name, of_kind(variable.kind()))));
    columns.extend(POSE.columns().iter().map(|wanted| column(wanted.name, of_kind(wanted.kind))));
    let wrench = WRENCH.into_iter().zip(units.of_wrench());
    columns.extend(wrench.map(|(name, unit)| column(name, ColumnKind::Quantity(unit))));
    columns.extend(["payload", LOAD_POINT].map(|name| column(name, ColumnKind::Text)));
    columns.push(number("temperature"));
    columns.push(column("time", ColumnKind::Quantity(Unit::Time(units.time))));
    let sides = robot.variables.iter().map(|variable| format!("approach.{}", variable.name));
    columns.extend(sides.map(|side| column(&side, ColumnKind::NumberOrZero)));
    columns.extend(robot.frames.iter().map(|frame| number(&format!("temperature.{}", frame.name))));
    columns
}

/// Resolves a path in given units.
///
/// # Errors
/// Every fault of the table, located.
pub fn read(table: &Table, robot: &Robot, units: Units) -> Result<Path, Vec<Diagnostic>> {
    let mut diagnostics = Vec::new();
    let variables: Vec<&str> = robot.variables.iter().map(|variable| variable.name.as_str()).collect();
    let mut whole = |names: &[&str], what: &str| -> bool {
        let missing: Vec<&str> = names.iter().copied().filter(|name| !table.has(name)).collect();
        if !missing.is_empty() && missing.len() < names.len() {
            let message = format!("`{}` has some columns of {what}, but not {}", table.file(), missing.join(", "));
            diagnostics.push(Diagnostic::error(message).remedy(format!("give all of {}, or none", names.join(", "))));
        }
        missing.is_empty()
    };
    let joints = whole(&variables, "the joints");
    let position = whole(&POSITION, "the position");
    let orientation = whole(&ORIENTATION, "the orientation");
    if !joints && !position && diagnostics.is_empty() {
        let message = format!("`{}` says neither joints nor positions", table.file());
        let remedy = format!("give columns {}, or x, y, z and rx, ry, rz", variables.join(", "));
        diagnostics.push(Diagnostic::error(message).remedy(remedy));
    } else if orientation && !position && diagnostics.is_empty() {
        let message = format!("`{}` has orientations without positions", table.file());
        diagnostics.push(Diagnostic::error(message).remedy("give x, y, z too, or leave rx, ry, rz out"));
    }
    for name in variables.iter().map(|name| format!("approach.{name}")) {
        let values = table.numbers(&name).unwrap_or_default();
        if let Some(row) = values.iter().position(|side| ![-1.0, 0.0, 1.0].contains(side)) {
            let message = format!("`{name}` is {}, and must be 1 or -1 (0: not known)", values[row]);
            diagnostics.push(Diagnostic::error(message).at(table.place(row, &name)));
        }
    }
    let raw = RawCampaign { units, observes: Some(RawKinds::one(POSE)), ..RawCampaign::default() };
    match resolve(&raw, &|_| None, robot, &Kinds::standard(), &[(raw.completed(&RawEntry::default()), table)]) {
        Ok((campaign, _)) if diagnostics.is_empty() => Ok(Path { campaign, joints, position, orientation }),
        Ok(_) => Err(diagnostics),
        Err(more) => {
            diagnostics.extend(more);
            Err(diagnostics)
        }
    }
}
