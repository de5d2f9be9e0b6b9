//! A file of readings as its rows are read.

use super::raw::RawEntry;
use crate::description::table::Table;
use crate::diagnostic::{Locate, Place};
use crate::observation::Observes;

/// A table of readings, and what the campaign says of its file.
pub struct Source<'a> {
    /// The readings.
    pub table: &'a Table,
    /// What holds of the file.
    pub entry: &'a RawEntry,
    /// Kinds of the readings in each row.
    pub kinds: Vec<Observes>,
}

impl Source<'_> {
    /// Where the campaign names the kinds of its readings, for a fault of the file's columns.
    pub fn place_of_kinds(locate: Locate) -> Option<Place> {
        locate(&["observes"]).or_else(|| locate(&["measurements"]))
    }
}
