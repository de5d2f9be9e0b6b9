//! Tables of measurements: CSV as laboratories write it, every fault located.
//!
//! A file is streamed row by row and never held whole; only the columns that are asked for are kept.

mod cell;
mod columns;
mod header;
mod rows;
mod source;
mod write;

pub use columns::{ColumnKind, Dialect, ExpectedColumn, Table, TextColumn};
pub use rows::read_table;
pub use write::Sheet;
