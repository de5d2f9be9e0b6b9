//! Two tables of one campaign as one: the readings, and the joints of their configurations, joined by the names of the poses
//! or by order.

use std::collections::HashMap;

#[cfg(feature = "cli")]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::columns::{Joined, Table, TextColumn};
use crate::diagnostic::{Code, Diagnostic};

/// The column that names configurations.
const POSE: &str = "pose";

/// Most faults of one kind shown.
const MOST_SHOWN: usize = 20;

/// How rows of two files belong together.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize)]
#[cfg_attr(feature = "cli", derive(JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Join {
    /// By the names in the column `pose` of both.
    Name,
    /// The first row to the first; where the readings name their poses and repeat them, the first name to the first row.
    Order,
}

impl Table {
    /// This table of readings with the columns of a table of joints; by names where both have a column `pose` and nothing
    /// else is asked.
    ///
    /// # Errors
    /// Names of readings that the joints do not have, names that the joints have twice, numbers of rows that do not match,
    /// and columns that both have, each located.
    pub fn with_joints(mut self, joints: Self, how: Option<Join>) -> Result<Self, Vec<Diagnostic>> {
        let both = self.texts.contains_key(POSE) && joints.texts.contains_key(POSE);
        let how = how.unwrap_or(if both { Join::Name } else { Join::Order });
        let mut faults = in_both(&self, &joints);
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

/// Columns that both have, but for the names of poses.
fn in_both(readings: &Table, joints: &Table) -> Vec<Diagnostic> {
    let both = readings.fields.keys().filter(|name| *name != POSE && joints.fields.contains_key(*name));
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
    let mut rows: HashMap<&str, usize> = HashMap::new();
    for row in 0..joints.row_count() {
        let Some(name) = known.get(row) else { continue };
        let Some(first) = rows.insert(name, row) else { continue };
        if faults.len() < MOST_SHOWN {
            let message = format!("the pose `{name}` has two rows of joints");
            let diagnostic = Diagnostic::error(message).code(Code::Duplicate).at(joints.place(row, POSE));
            let diagnostic = diagnostic.related(joints.place(first, POSE), "first given here");
            faults.push(diagnostic.remedy("keep one of them, or rename the pose and its readings"));
        }
        rows.insert(name, first);
    }
    let by_name: Vec<Option<usize>> = wanted.texts.iter().map(|name| rows.get(name.as_str()).copied()).collect();
    for (name, _) in wanted.texts.iter().zip(&by_name).filter(|(_, row)| row.is_none()).take(MOST_SHOWN) {
        let row = (0..readings.row_count()).find(|row| wanted.get(*row) == Some(name.as_str())).unwrap_or(0);
        let message = format!("the pose `{name}` has readings, and `{}` has no joints of it", joints.file);
        let diagnostic = Diagnostic::error(message).at(readings.place(row, POSE));
        let known = known.texts.iter().map(String::as_str);
        faults.push(diagnostic.suggest(name, known).code(Code::Missing));
    }
    let row_of = |index: &u32| by_name.get(usize::try_from(*index).ok()?).copied().flatten();
    wanted.rows.iter().map(row_of).collect()
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
