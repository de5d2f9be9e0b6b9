//! Reading a table, whatever it is kept in.

use std::collections::BTreeMap;
use std::io::Read;

use super::columns::{ExpectedColumn, Layout, Table};
use super::dialect::Dialect;
use super::rows::read_laid_out;
use crate::diagnostic::Diagnostic;
#[cfg(not(feature = "xlsx"))]
use crate::diagnostic::Place;

/// Reads the columns that are expected: of a text, streaming, or, where the file's name ends in `.xlsx` or `.xlsx#Sheet`, of a
/// sheet of a workbook.
///
/// `rename` maps our name of a column to the file's, where they differ; `ignore` lists columns of the file to pass over.
/// Blanks around names and numbers, quoted fields, a byte-order mark, CRLF, empty lines, comments (`#`, `//`), a first line
/// `sep=;` and a row of units below the header are accepted.
///
/// # Errors
///
/// Every fault of the file, each with its line: columns missing, unknown, given twice or renamed from nothing, cells that are
/// empty or no finite numbers, rows of another length, a wrong delimiter or decimal sign, units of another quantity, no rows
/// or more than `max_rows`, text that is not UTF-8. After the first faults the others are counted.
pub fn read_table(
    file: &str,
    reader: impl Read,
    expected: &[ExpectedColumn],
    rename: &BTreeMap<String, String>,
    ignore: &[String],
    dialect: &Dialect,
    max_rows: usize,
) -> Result<Table, Vec<Diagnostic>> {
    let layout = Layout { expected, rename, ignore, dialect, sheet: None };
    match workbook_name(file) {
        Some((path, sheet)) => workbook(path, reader, sheet, &layout, max_rows),
        None => read_laid_out(file, reader, &layout, max_rows),
    }
}

#[cfg(feature = "xlsx")]
use super::workbook::read_workbook as workbook;

/// Without the reader of workbooks.
#[cfg(not(feature = "xlsx"))]
fn workbook(path: &str, _: impl Read, _: Option<&str>, _: &Layout, _: usize) -> Result<Table, Vec<Diagnostic>> {
    let diagnostic = Diagnostic::error("this program is built without workbooks (feature `xlsx`)");
    Err(vec![diagnostic.at(Place::line_of(path, 1)).remedy("save the sheet as CSV")])
}

/// The path of a workbook and the name of its sheet, if the name of a file is that of one: `readings.xlsx`,
/// `readings.xlsx#Monday`.
///
/// ```
/// use elastogeo::description::table::workbook_name;
/// assert_eq!(workbook_name("a/b.xlsx#Day 1"), Some(("a/b.xlsx", Some("Day 1"))));
/// assert_eq!(workbook_name("b.XLSX"), Some(("b.XLSX", None)));
/// assert_eq!(workbook_name("b#1.csv"), None);
/// ```
pub fn workbook_name(file: &str) -> Option<(&str, Option<&str>)> {
    let is_workbook = |path: &str| {
        let end = path.len().checked_sub(5).and_then(|start| path.get(start..));
        end.is_some_and(|end| end.eq_ignore_ascii_case(".xlsx") || end.eq_ignore_ascii_case(".xlsm"))
    };
    if is_workbook(file) {
        return Some((file, None));
    }
    let (path, sheet) = file.match_indices('#').map(|(at, _)| file.split_at(at)).find(|(path, _)| is_workbook(path))?;
    Some((path, sheet.get(1..)))
}
