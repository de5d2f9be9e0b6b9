//! Tables of measurements: CSV as laboratories write it, and sheets of workbooks; every fault located.
//!
//! A text is streamed row by row and never held whole; only the columns that are asked for are kept.

mod cell;
mod columns;
mod dialect;
mod header;
mod join;
mod line;
mod orientation;
mod points;
mod read;
mod rotations;
mod row;
mod rows;
mod source;
mod titles;
mod units;
mod wide;
#[cfg(feature = "xlsx")]
mod workbook;
mod write;

pub(in crate::description) use columns::MOST_SHOWN;
pub use columns::{ColumnKind, ExpectedColumn, Table, TextColumn};
pub use dialect::{Dialect, Points};
pub use join::Join;
pub use orientation::{Orientation, QuaternionOrder};
pub use read::{read_table, workbook_name};
pub(crate) use rows::too_many;
pub use wide::widened;
pub use write::Sheet;
