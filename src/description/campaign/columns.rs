//! Columns that files of measurements may have, under our names.

use super::raw::{JointSource, LoadSource, RawCampaign, RawEntry};
use super::source::Source;
use super::stated::NOISE_COLUMNS;
use super::torques::{load_columns, torque_columns};
use super::{LOAD_POINT, WRENCH};
use crate::description::resolve::Locate;
use crate::description::robot::Robot;
use crate::description::table::{ColumnKind, ExpectedColumn, Table};
use crate::description::units::Unit;
use crate::diagnostic::Diagnostic;
use crate::observation::{FAMILY, Kinds, Observes, POSITION, ValueColumn};
use crate::parameter::Kind;

/// Kinds of readings that each row of a file holds, of those that there are; positions where it names none.
pub fn kinds(entry: &RawEntry, known: &Kinds) -> Vec<Observes> {
    let named = entry.observes.iter().flat_map(|observes| &observes.0);
    let kinds: Vec<Observes> = named.filter_map(|name| known.named(name)).collect();
    if kinds.is_empty() { vec![POSITION] } else { kinds }
}

/// The same for a file with these columns: a kind with further ones is meant where the file has them all.
pub(super) fn kinds_of_file(entry: &RawEntry, table: &Table, known: &Kinds) -> Vec<Observes> {
    let has_all = |kind: &Observes| kind.columns().iter().all(|column| table.has(column.name));
    let whole = |kind: Observes| kind.with_more_columns().map(Observes::new).filter(has_all).unwrap_or(kind);
    kinds(entry, known).into_iter().map(whole).collect()
}

/// Further columns of a kind of which a file has some and lacks others.
pub(super) fn half_of_more_columns(sources: &[Source]) -> Vec<Diagnostic> {
    let mut faults = Vec::new();
    for Source { table, kinds, .. } in sources {
        for (kind, more) in kinds.iter().filter_map(|kind| Some((kind, kind.with_more_columns()?))) {
            let own = |column: &&ValueColumn| kind.columns().iter().any(|known| known.name == column.name);
            let further = more.columns().iter().filter(|column| !own(column)).map(|column| column.name);
            let (there, lacking): (Vec<&str>, Vec<&str>) = further.partition(|name| table.has(name));
            let Some(first) = there.first() else { continue };
            let message =
                format!("a {} has `{}`, and lacks `{}`", kind.name(), there.join("`, `"), lacking.join("`, `"));
            let remedy = format!("give all of them, or take `{}` out with `ignore:`", there.join("`, `"));
            faults.push(Diagnostic::error(message).at(table.place(0, first)).remedy(remedy));
        }
    }
    faults
}

/// Kinds with a column that is a variable of the robot: those of a program's own, since other names are reserved.
pub(super) fn columns_of_joints(kinds: &[Observes], robot: &Robot, locate: Locate) -> Vec<Diagnostic> {
    let is_joint = |name: &str| robot.variables.iter().any(|variable| variable.name == name);
    let own = kinds.iter().filter(|kind| FAMILY.iter().all(|known| known != *kind));
    let taken = own.flat_map(|kind| kind.columns().iter().map(move |column| (kind.name(), column.name)));
    let fault = |(kind, column): (&str, &str)| {
        let message = format!("`{column}` is a column of a {kind}, and a joint of the robot");
        Diagnostic::error(message).at(locate(&["observes"])).remedy("name the column of the kind otherwise")
    };
    taken.filter(|(_, column)| is_joint(column)).map(fault).collect()
}

/// The column of a variable at which the model is evaluated.
pub(super) fn joint_column(raw: &RawCampaign, variable: &str) -> String {
    raw.joints.map_or_else(|| variable.to_string(), |source| format!("{}.{variable}", source.prefix()))
}

/// Columns of the other values of a variable.
pub(super) fn other_columns(raw: &RawCampaign, variable: &str) -> Vec<String> {
    let sources =
        [JointSource::Commanded, JointSource::Recorded].map(|source| format!("{}.{variable}", source.prefix()));
    let used = joint_column(raw, variable);
    std::iter::once(variable.to_string()).chain(sources).filter(|column| *column != used).collect()
}

/// Columns that a file of a campaign about this robot may have; `entry` is what holds of the file
/// ([`RawCampaign::completed`]).
pub fn expected_columns(raw: &RawCampaign, entry: &RawEntry, robot: &Robot, known: &Kinds) -> Vec<ExpectedColumn> {
    let column = |name: &str, kind, required| ExpectedColumn::new(name, kind, required);
    let number = |name: &str, required| column(name, ColumnKind::Number, required);
    let text = |name: &str| column(name, ColumnKind::Text, false);
    let text_or_none = |name: &str| column(name, ColumnKind::TextOrNone, false);
    let units = entry.units(raw.units);
    let of_kind = |kind| units.unit(kind).map_or(ColumnKind::Number, ColumnKind::Quantity);
    let mut columns = ["pose", "marker", "session", "station", "payload"].map(text).to_vec();
    for variable in &robot.variables {
        let quantity = of_kind(variable.kind());
        columns.push(column(&joint_column(raw, &variable.name), quantity, true));
        columns.extend(other_columns(raw, &variable.name).iter().map(|name| column(name, quantity, false)));
    }
    for observes in kinds(entry, known) {
        // A joint that is called so is that joint.
        let is_joint = |column: &ValueColumn| robot.variables.iter().any(|variable| variable.name == column.name);
        let other = match observes.other_columns() {
            other if other.iter().any(is_joint) => &[],
            other => other,
        };
        let measured = observes.columns().iter().chain(other);
        columns.extend(measured.map(|measured| column(measured.name, of_kind(measured.kind), other.is_empty())));
        let more = observes.with_more_columns().map_or(&[][..], |more| more.columns());
        columns.extend(more.iter().map(|measured| column(measured.name, of_kind(measured.kind), false)));
        columns.extend(observes.target_column().map(text));
        columns.extend(torque_columns(raw, entry, robot, observes));
    }
    if raw.loads.joints == LoadSource::Measured {
        columns.extend(load_columns(raw, entry, robot));
    }
    columns.extend(raw.contacts.values().filter_map(|contact| contact.group.as_deref()).map(text_or_none));
    columns.push(text(LOAD_POINT));
    let wrench = WRENCH.into_iter().zip(units.of_wrench());
    columns.extend(wrench.map(|(name, unit)| column(name, ColumnKind::Quantity(unit), false)));
    columns.push(text("set"));
    columns.extend(["temperature", "order"].map(|name| number(name, false)));
    columns.push(column("time", ColumnKind::Quantity(Unit::Time(units.time)), false));
    columns.extend(NOISE_COLUMNS.map(|(name, ..)| column(name, of_kind(Kind::Length), false)));
    let sides = robot.variables.iter().map(|variable| format!("approach.{}", variable.name));
    columns.extend(sides.map(|side| column(&side, ColumnKind::NumberOrZero, false)));
    columns.extend(robot.frames.iter().map(|frame| number(&format!("temperature.{}", frame.name), false)));
    let mut known = std::collections::HashSet::new();
    columns.retain(|column| known.insert(column.name.clone()));
    columns
}
