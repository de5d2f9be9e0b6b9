//! A row of a table of readings, and the faults of one table.

use crate::description::resolve::GREATEST;
use crate::description::table::Table;
use crate::description::units::Units;
use crate::diagnostic::{Diagnostic, Place};

/// Most faults shown of one table.
pub const MOST_SHOWN: usize = 20;

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

    pub fn unknown<'n>(&mut self, row: &Row, column: &str, name: &str, valid: impl IntoIterator<Item = &'n str>) {
        let diagnostic = Diagnostic::error(format!("unknown {column} `{name}`")).at(row.place(column));
        let valid: Vec<&str> = valid.into_iter().collect();
        self.push(match valid.is_empty() {
            // That there is none of them is an error of its own.
            true => diagnostic.remedy(format!("declare it under `{column}s:`")),
            false => diagnostic.suggest(name, valid),
        });
    }

    pub fn check_size(&mut self, row: &Row, column: &str, value: f64) {
        if value.abs() > GREATEST {
            let diagnostic = Diagnostic::error(format!("column `{column}`: no robot measures so much"));
            self.push(diagnostic.remedy("check the value and `units:`").at(row.place(column)));
        }
    }
}
