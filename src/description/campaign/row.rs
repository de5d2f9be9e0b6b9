//! A row of a table of readings, and the faults of one table.

use super::raw::RawEntry;
use crate::description::resolve::GREATEST;
use crate::description::table::{MOST_SHOWN, Table};
use crate::description::units::Units;
use crate::diagnostic::{Diagnostic, Locate, Place};

/// A row of a table.
pub struct Row<'a> {
    pub table: &'a Table,
    pub row: usize,
    pub units: Units,
}

impl Row<'_> {
    /// A number; zero where the table has no such column, which is then not required.
    pub fn number(&self, column: &str) -> f64 {
        self.table.numbers(column).and_then(|all| all.get(self.row)).copied().unwrap_or(0.0)
    }

    /// A number, where the table has the column.
    pub fn given(&self, column: &str) -> Option<f64> {
        self.table.numbers(column)?.get(self.row).copied()
    }

    /// The number in the order of measurement.
    pub fn order(&self) -> Option<i64> {
        self.given("order").filter(|number| number.is_finite()).map(|number| number.round() as i64)
    }

    pub fn text(&self, column: &str) -> Option<&str> {
        self.table.texts(column)?.get(self.row)
    }

    pub fn place(&self, column: &str) -> Option<Place> {
        self.table.place(self.row, column)
    }
}

/// What the campaign file says of all rows of a table.
pub struct OfFile<'a> {
    pub entry: &'a RawEntry,
    /// Its place in `measurements:`.
    pub number: usize,
    pub locate: Locate<'a>,
}

impl OfFile<'_> {
    /// The place of a key.
    pub fn place(&self, key: &str) -> Option<Place> {
        let number = self.number.to_string();
        let of_list = |key: &str| (self.locate)(&["measurements", &number, key]);
        // A single one is no list. What is not there is placed where what would hold it stands.
        let is_list = of_list(key) != of_list("no such key");
        if is_list { of_list(key) } else { (self.locate)(&["measurements", key]) }
    }
}

/// Faults of one table.
#[derive(Default)]
pub struct Faults {
    pub shown: Vec<Diagnostic>,
    pub count: usize,
}

impl Faults {
    pub fn push(&mut self, diagnostic: Diagnostic) {
        self.count += 1;
        if self.count <= MOST_SHOWN {
            self.shown.push(diagnostic);
        }
    }

    /// A fault that all rows share, once.
    pub fn push_once(&mut self, diagnostic: Diagnostic) {
        if self.shown.iter().all(|known| known.message != diagnostic.message) {
            self.push(diagnostic);
        }
    }

    pub fn unknown<'n>(&mut self, row: &Row, column: &str, name: &str, valid: impl IntoIterator<Item = &'n str>) {
        self.push(unknown(column, name, valid).at(row.place(column)));
    }

    pub fn check_size(&mut self, row: &Row, column: &str, value: f64) {
        if value.abs() > GREATEST {
            let diagnostic = Diagnostic::error(format!("column `{column}`: no robot measures so much"));
            self.push(diagnostic.remedy("check the value and `units:`").at(row.place(column)));
        }
    }
}

/// A name that nothing has.
pub fn unknown<'n>(column: &str, name: &str, valid: impl IntoIterator<Item = &'n str>) -> Diagnostic {
    let diagnostic = Diagnostic::error(format!("unknown {column} `{name}`"));
    let valid: Vec<&str> = valid.into_iter().collect();
    match valid.is_empty() {
        // That there is none of them is an error of its own.
        true => diagnostic.remedy(format!("declare it under `{column}s:`")),
        false => diagnostic.suggest(name, valid),
    }
}
