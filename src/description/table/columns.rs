//! The columns of a table: what is expected of a file, and what one holds.

use std::collections::BTreeMap;

use super::dialect::Dialect;
use super::row::{Row, Writing};
use crate::description::units::Unit;
use crate::diagnostic::{Diagnostic, Place};

/// Most faults shown of one file; the others are counted.
pub const MOST_SHOWN: usize = 20;

/// What the cells of a column hold.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ColumnKind {
    /// Finite numbers.
    Number,
    /// The same, where an empty cell is 0: not known.
    NumberOrZero,
    /// Finite numbers in this unit, unless a row of units below the header names another: then they are converted to this.
    Quantity(Unit),
    /// Texts, such as names; each different one is kept once.
    Text,
    /// The same, of which a cell may be empty.
    TextOrNone,
}

/// A column that a file may or must have.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ExpectedColumn {
    /// Our name of it.
    pub name: String,
    /// What its cells hold.
    pub kind: ColumnKind,
    /// Whether its absence is a fault.
    pub required: bool,
    /// Whether cells of numbers may be empty: NaN, for what follows to look at.
    pub(super) or_none: bool,
}

impl ExpectedColumn {
    /// A column all of whose cells are filled in, but for the kinds that say otherwise.
    pub fn new(name: impl Into<String>, kind: ColumnKind, required: bool) -> Self {
        Self { name: name.into(), kind, required, or_none: false }
    }

    /// The same, required where it was and this holds.
    pub fn required_if(self, holds: bool) -> Self {
        Self { required: self.required && holds, ..self }
    }
}

/// The cells of a text column: for each row the number of its text among the different ones.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct TextColumn {
    pub(super) texts: Vec<String>,
    pub(super) rows: Vec<u32>,
}

impl TextColumn {
    /// The different texts, in the order in which they first appear.
    pub fn texts(&self) -> &[String] {
        &self.texts
    }

    /// For each row, the index of its text in [`TextColumn::texts`].
    pub fn indices(&self) -> &[u32] {
        &self.rows
    }

    /// The text of a row.
    pub fn get(&self, row: usize) -> Option<&str> {
        self.texts.get(usize::try_from(*self.rows.get(row)?).ok()?).map(String::as_str)
    }
}

/// A table whose columns hold for rows of another.
#[derive(Debug, Clone)]
pub(super) struct Joined {
    pub table: Box<Table>,
    /// By row of the readings, the row of this table.
    pub rows: Vec<usize>,
}

/// The columns of a file under our names.
#[derive(Debug, Clone, Default)]
pub struct Table {
    pub(super) file: String,
    pub(super) numbers: BTreeMap<String, Vec<f64>>,
    pub(super) texts: BTreeMap<String, TextColumn>,
    /// Field of each column in the file.
    pub(super) fields: BTreeMap<String, usize>,
    pub(super) lines: Vec<u32>,
    pub(super) writing: Writing,
    pub(super) whole: Option<Vec<u8>>,
    pub(super) notes: Vec<Diagnostic>,
    pub(super) joined: Option<Joined>,
}

impl Table {
    /// Display name of the file.
    pub fn file(&self) -> &str {
        &self.file
    }

    /// Number of rows, header and empty lines left out.
    pub fn row_count(&self) -> usize {
        self.lines.len()
    }

    /// The line of the file, counted from 1, on which a row starts.
    pub fn line(&self, row: usize) -> Option<usize> {
        self.lines.get(row).and_then(|&line| usize::try_from(line).ok())
    }

    /// Whether the file has the column.
    pub fn has(&self, column: &str) -> bool {
        self.fields.contains_key(column) || self.joined.as_ref().is_some_and(|joined| joined.table.has(column))
    }

    /// The name of the column that stands first.
    pub fn first_column(&self) -> &str {
        self.fields.iter().min_by_key(|(_, field)| **field).map_or("", |(name, _)| name)
    }

    /// The numbers of a column; `None` if the file does not have it, or it holds texts.
    pub fn numbers(&self, column: &str) -> Option<&[f64]> {
        self.numbers.get(column).map(Vec::as_slice)
    }

    /// The texts of a column; `None` if the file does not have it, or it holds numbers.
    pub fn texts(&self, column: &str) -> Option<&TextColumn> {
        self.texts.get(column)
    }

    /// What is worth knowing of how the file was read: warnings only.
    pub fn notes(&self) -> &[Diagnostic] {
        &self.notes
    }

    /// Where a cell stands, for a later diagnostic about it; beyond 4 MiB of file, the line alone without its text.
    pub fn place(&self, row: usize, column: &str) -> Option<Place> {
        if let Some(joined) = self.joined.as_ref().filter(|_| !self.fields.contains_key(column))
            && joined.table.has(column)
        {
            return joined.table.place(*joined.rows.get(row)?, column);
        }
        let line = self.line(row)?;
        let field = self.fields.get(column).copied().unwrap_or(0);
        let whole = self.whole.as_deref().unwrap_or_default();
        let start = whole.split_inclusive(|&byte| byte == b'\n').take(line - 1).map(<[u8]>::len).sum();
        match whole.get(start..) {
            Some(from) if !from.is_empty() => Some(Row::at(&self.file, from, line, self.writing).field(field)),
            _ => Some(Place::line_of(&self.file, line)),
        }
    }
}

/// What a table should hold, and how its file says so.
pub(super) struct Layout<'a> {
    pub expected: &'a [ExpectedColumn],
    /// Our name of a column and the file's, where they differ.
    pub rename: &'a BTreeMap<String, String>,
    /// Columns of the file to pass over.
    pub ignore: &'a [String],
    pub dialect: &'a Dialect,
    /// Of a sheet of a workbook: the number of empty columns left of its first.
    pub sheet: Option<usize>,
}

impl Layout<'_> {
    /// Whether a column has this name, ours or the file's.
    pub fn names(&self, title: &str) -> bool {
        self.expects(title) || self.rename.values().any(|renamed| renamed.trim() == title)
    }

    /// Whether a column has this name of ours.
    pub fn expects(&self, name: &str) -> bool {
        self.expected.iter().any(|column| column.name == name)
    }

    /// Whether the file's column is to be passed over.
    pub fn ignores(&self, title: &str) -> bool {
        self.ignore.iter().any(|ignored| ignored.trim() == title)
    }
}
