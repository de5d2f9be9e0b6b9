//! Two tables of one campaign as one: the readings, and the joints of their configurations, joined by the names of the poses
//! or by order.

use std::collections::{HashMap, HashSet};

#[cfg(feature = "cli")]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::columns::{Joined, MOST_SHOWN, Table, TextColumn};
use crate::diagnostic::{Code, Diagnostic};

/// The column that names configurations.
const POSE: &str = "pose";
/// The column that names sessions, in each of which a pose may have joints of its own.
const SESSION: &str = "session";

/// How rows of two files belong together.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize)]
#[cfg_attr(feature = "cli", derive(JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Join {
    /// By the names in the column `pose` of both; and in `session`, where both have it.
    Name,
    /// The first row to the first; where the readings name their poses and repeat them, the first name to the first row.
    Order,
}

impl Table {
    /// Leaves columns of this table of joints out that the file of the readings, `readings`, has to have: what a controller shows there is
    /// no reading. It is noted.
    pub fn leave_out(&mut self, columns: &[String], readings: &str) {
        let both: Vec<&String> = columns.iter().filter(|name| self.fields.contains_key(*name)).collect();
        let Some(first) = both.first() else { return };
        let shown = both.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ");
        let message = format!("the joints are read from `{}`, without its columns {shown}", self.file);
        let diagnostic = Diagnostic::warning(message).at(self.place(0, first));
        self.notes.push(diagnostic.remedy(format!("nothing is to be done: what was measured stands in `{readings}`")));
        for name in both {
            self.numbers.remove(name);
            self.texts.remove(name);
            self.fields.remove(name);
        }
    }

    /// This table of readings with the columns of a table of joints; by names where both have a column `pose` and nothing
    /// else is asked.
    ///
    /// # Errors
    /// Names of readings that the joints do not have, names that the joints have twice, numbers of rows that do not match,
    /// and columns that both have, each located.
    pub fn with_joints(mut self, joints: Self, how: Option<Join>) -> Result<Self, Vec<Diagnostic>> {
        let both = self.texts.contains_key(POSE) && joints.texts.contains_key(POSE);
        let how = how.unwrap_or(if both { Join::Name } else { Join::Order });
        let mut faults = in_both(&self, &joints, how);
        let rows = match how {
            Join::Name => by_name(&self, &joints, &mut faults),
            Join::Order => by_order(&self, &joints).map_err(|fault| faults.push(fault)).ok(),
        };
        let Some(rows) = rows.filter(|_| faults.is_empty()) else { return Err(faults) };
        self.notes.extend(joints.notes.iter().cloned());
        self.notes.extend(without_readings(&joints, &rows));
        for (name, values) in &joints.numbers {
            let expanded = rows.iter().filter_map(|row| values.get(*row).copied()).collect();
            self.numbers.insert(name.clone(), expanded);
        }
        for (name, values) in &joints.texts {
            let expanded = rows.iter().filter_map(|row| values.rows.get(*row).copied()).collect();
            let expanded = TextColumn { texts: values.texts.clone(), rows: expanded };
            self.texts.entry(name.clone()).or_insert(expanded);
        }
        self.joined = Some(Joined { table: Box::new(joints), rows });
        Ok(self)
    }
}

/// Columns that both have, but for those by which they are joined.
fn in_both(readings: &Table, joints: &Table, how: Join) -> Vec<Diagnostic> {
    let joins = |name: &str| name == POSE || (name == SESSION && how == Join::Name);
    let both = readings.fields.keys().filter(|name| !joins(name) && joints.fields.contains_key(*name));
    let fault = |name: &String| {
        let message = format!("the column `{name}` is in `{}` and in `{}`", readings.file, joints.file);
        let diagnostic = Diagnostic::error(message).code(Code::Duplicate).at(readings.place(0, name));
        let diagnostic = diagnostic.related(joints.place(0, name), "and here");
        diagnostic.remedy("take it out of one of the two files: `ignore:` would leave out both")
    };
    both.map(fault).collect()
}

/// By reading the row of the joints that has its name.
fn by_name(readings: &Table, joints: &Table, faults: &mut Vec<Diagnostic>) -> Option<Vec<usize>> {
    let mut named = |table: &Table| {
        let column = table.texts.get(POSE).cloned();
        if column.is_none() {
            let message = format!("`{}` has no column `pose`, by which it is to be joined", table.file);
            let diagnostic = Diagnostic::error(message).code(Code::Missing).at(table.place(0, ""));
            faults.push(diagnostic.remedy("name the poses in both files, or join them with `join: order`"));
        }
        column
    };
    let (wanted, known) = (named(readings), named(joints));
    let (wanted, known) = (wanted?, known?);
    // By session, where both name it.
    let sessions = readings.texts.get(SESSION).zip(joints.texts.get(SESSION));
    let key = |names: &TextColumn, session: Option<&TextColumn>, row: usize| {
        let session = session.and_then(|names| names.get(row)).unwrap_or_default();
        Some((session.to_owned(), names.get(row)?.to_owned()))
    };
    let mut rows: HashMap<(String, String), usize> = HashMap::new();
    for row in 0..joints.row_count() {
        let Some(named) = key(&known, sessions.map(|(_, joints)| joints), row) else { continue };
        let first = *rows.entry(named.clone()).or_insert(row);
        if first != row && faults.len() < MOST_SHOWN {
            let message = format!("{} has two rows of joints", shown(&named));
            let diagnostic = Diagnostic::error(message).code(Code::Duplicate).at(joints.place(row, POSE));
            let diagnostic = diagnostic.related(joints.place(first, POSE), "first given here");
            faults.push(diagnostic.remedy("keep one of them, or rename the pose and its readings"));
        }
    }
    let mut lacking = HashSet::new();
    let mut joined = Vec::with_capacity(readings.row_count());
    for row in 0..readings.row_count() {
        let named = key(&wanted, sessions.map(|(readings, _)| readings), row)?;
        let found = rows.get(&named).copied();
        joined.extend(found);
        if found.is_none() && lacking.len() < MOST_SHOWN && lacking.insert(named.clone()) {
            let message = format!("{} has readings, and `{}` has no joints of it", shown(&named), joints.file);
            let diagnostic = Diagnostic::error(message).at(readings.place(row, POSE));
            let known = known.texts.iter().map(String::as_str).filter(|known| *known != named.1);
            faults.push(diagnostic.suggest(&named.1, known).code(Code::Missing));
        }
    }
    Some(joined)
}

/// A pose by its session, where there is one, and its name.
fn shown((session, pose): &(String, String)) -> String {
    if session.is_empty() { format!("the pose `{pose}`") } else { format!("the pose `{pose}` of session `{session}`") }
}

/// By reading the row of the joints in its place.
fn by_order(readings: &Table, joints: &Table) -> Result<Vec<usize>, Diagnostic> {
    let (count, rows) = (readings.row_count(), joints.row_count());
    if count == rows {
        return Ok((0..count).collect());
    }
    let names = readings.texts.get(POSE);
    if let Some(names) = names.filter(|names| names.texts.len() == rows) {
        // Texts are numbered in the order in which they first appear.
        return Ok(names.rows.iter().filter_map(|index| usize::try_from(*index).ok()).collect());
    }
    let named = names.map(|names| format!(" of {} poses", names.texts.len())).unwrap_or_default();
    let message =
        format!("`{}` has {count} readings{named}, and `{}` {rows} rows of joints", readings.file, joints.file);
    let (longer, other) = if count > rows { (readings, rows) } else { (joints, count) };
    let diagnostic = Diagnostic::error(message).at(longer.place(other, longer.first_column()));
    Err(diagnostic.remedy("give as many rows in both, or name the poses in both by a column `pose`"))
}

/// A warning of poses with joints and without readings.
fn without_readings(joints: &Table, rows: &[usize]) -> Option<Diagnostic> {
    let mut is_used = vec![false; joints.row_count()];
    for row in rows {
        if let Some(used) = is_used.get_mut(*row) {
            *used = true;
        }
    }
    let unused: Vec<usize> = (0..is_used.len()).filter(|row| !is_used[*row]).collect();
    let first = *unused.first()?;
    let what = if unused.len() == 1 { "1 pose has".into() } else { format!("{} poses have", unused.len()) };
    let message = format!("{what} joints and no reading, the first of them here");
    let diagnostic = Diagnostic::warning(message).at(joints.place(first, POSE));
    Some(diagnostic.remedy("check the names if they were measured; else they are passed over"))
}
