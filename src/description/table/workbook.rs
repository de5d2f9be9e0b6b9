//! Sheets of workbooks (.xlsx) as tables: the cells are written as the rows of a text, which is then read like any other,
//! so that columns, units and faults are the same; places are those of cells.

use std::io::{Cursor, Read};

use calamine::{Cell, DataRef, Reader, Xlsx};

use super::columns::{Layout, Table};
use super::dialect::Dialect;
use super::rows::read_laid_out;
use super::source::is_comment;
use crate::diagnostic::{Code, Diagnostic, Place};

/// Most bytes of a workbook.
const MOST_BYTES: u64 = 64 << 20;
/// Most bytes of a sheet written as text: what a workbook packs tightly may unfold to any size.
const MOST_TEXT: usize = 256 << 20;
/// Most columns of a sheet of this format.
const MOST_COLUMNS: u32 = 16_384;

/// Reads a sheet of a workbook: the one named, or the only one that holds anything.
///
/// Cells count as they are stored, whatever they look like: a number keeps all its digits, a formula is its stored result.
///
/// # Errors
/// As [`super::read_table`]; and that there is no such workbook or sheet.
pub(super) fn read_workbook(
    file: &str,
    reader: impl Read,
    sheet: Option<&str>,
    layout: &Layout,
    max_rows: usize,
) -> Result<Table, Vec<Diagnostic>> {
    let fault = |message: String| Diagnostic::error(message).code(Code::Unreadable).at(Place::line_of(file, 1));
    let mut bytes = Vec::new();
    let read = reader.take(MOST_BYTES + 1).read_to_end(&mut bytes);
    read.map_err(|error| vec![fault(format!("the file cannot be read: {error}"))])?;
    if bytes.len() as u64 > MOST_BYTES {
        let fault = fault(format!("the workbook has more than {MOST_BYTES} bytes"));
        return Err(vec![fault.remedy("save the sheet as CSV, which is read row by row")]);
    }
    let broken = |error: &dyn std::fmt::Display| {
        vec![fault(format!("this is no workbook that can be read: {error}")).remedy("save it as .xlsx, or as CSV")]
    };
    let mut workbook: Xlsx<_> = Xlsx::new(Cursor::new(bytes)).map_err(|error| broken(&error))?;
    let names: Vec<String> = workbook.sheet_names();
    let name = match sheet {
        Some(name) if names.iter().any(|known| known == name) => name.to_owned(),
        Some(name) => {
            let diagnostic = fault(format!("the workbook has no sheet `{name}`"));
            return Err(vec![diagnostic.suggest(name, names.iter().map(String::as_str))]);
        }
        None => only_sheet(&mut workbook, file, names)?,
    };
    let text = text_of(&mut workbook, &name).map_err(|error| broken(&error))?;
    let dialect = Dialect { delimiter: Some(';'), decimal: Some('.'), ..layout.dialect.clone() };
    let layout = Layout { dialect: &dialect, sheet: Some(text.left), ..*layout };
    read_laid_out(&format!("{file}#{name}"), text.rows.as_slice(), &layout, max_rows)
}

/// The only sheet of a workbook that holds a cell.
fn only_sheet(workbook: &mut Xlsx<Cursor<Vec<u8>>>, file: &str, names: Vec<String>) -> Result<String, Vec<Diagnostic>> {
    let mut filled = Vec::new();
    for name in names {
        let mut cells = workbook.worksheet_cells_reader(&name).ok();
        let mut next = || cells.as_mut()?.next_cell().ok().flatten();
        if std::iter::from_fn(&mut next).any(|cell| *cell.get_value() != DataRef::Empty) {
            filled.push(name);
        }
    }
    let at = Place::line_of(file, 1);
    match filled.as_slice() {
        [only] => Ok(only.clone()),
        [] => {
            let diagnostic = Diagnostic::error("no sheet of the workbook holds anything").code(Code::Empty);
            Err(vec![diagnostic.at(at).remedy("give a sheet that begins with the names of its columns")])
        }
        [first, ..] => {
            let listed: Vec<String> = filled.iter().map(|name| format!("`{name}`")).collect();
            let message = format!("the workbook has the sheets {}, and none is named", listed.join(", "));
            Err(vec![Diagnostic::error(message).at(at).remedy(format!("name one: `{file}#{first}`"))])
        }
    }
}

/// The rows of a sheet as text, each on the line of its number.
struct Text {
    rows: Vec<u8>,
    /// Number of empty columns left of the first.
    left: usize,
}

fn text_of(workbook: &mut Xlsx<Cursor<Vec<u8>>>, name: &str) -> Result<Text, String> {
    let mut cells = workbook.worksheet_cells_reader(name).map_err(|error| error.to_string())?;
    let mut rows: Vec<(u32, Vec<(u32, String)>)> = Vec::new();
    let mut size = 0;
    while let Some(cell) = cells.next_cell().map_err(|error| error.to_string())? {
        let (row, column) = cell.get_position();
        let Some(text) = written(&cell) else { continue };
        size += text.len() + 1;
        if column >= MOST_COLUMNS || size > MOST_TEXT {
            return Err("the sheet is too large".into());
        }
        match rows.last_mut() {
            Some((last, cells)) if *last == row => cells.push((column, text)),
            Some((last, _)) if *last > row => return Err(format!("row {} stands below row {}", row + 1, *last + 1)),
            _ => rows.push((row, vec![(column, text)])),
        }
    }
    let left = rows.iter().flat_map(|(_, cells)| cells).map(|(column, _)| *column).min().unwrap_or(0);
    // Rows have at least as many fields as the header, so that a cell that is missing is an empty one.
    let is_header =
        |cells: &[(u32, String)]| cells.first().is_some_and(|(_, cell)| !is_comment(cell.as_bytes(), false));
    let header = rows.iter().find(|(_, cells)| is_header(cells));
    let width = header.and_then(|(_, cells)| cells.iter().map(|(column, _)| column - left + 1).max()).unwrap_or(0);
    let (mut text, mut line) = (Vec::new(), 0);
    for (row, cells) in rows {
        text.resize(text.len() + (row as usize).saturating_sub(line), b'\n');
        line = row as usize + 1;
        let mut fields: Vec<String> = Vec::new();
        for (column, cell) in cells {
            let field = (column - left) as usize;
            fields.resize(fields.len().max(field + 1), String::new());
            if let Some(place) = fields.get_mut(field) {
                *place = cell;
            }
        }
        fields.resize(fields.len().max(width as usize), String::new());
        text.extend_from_slice(fields.join(";").as_bytes());
        text.push(b'\n');
        if text.len() > MOST_TEXT {
            return Err("the sheet is too large".into());
        }
    }
    Ok(Text { rows: text, left: left as usize })
}

/// A cell as a field; `None` where it is empty.
fn written(cell: &Cell<DataRef>) -> Option<String> {
    let quoted = |text: &str| format!("\"{}\"", text.replace(['\r', '\n'], " ").replace('"', "\"\""));
    Some(match cell.get_value() {
        DataRef::Empty => return None,
        DataRef::Int(number) => number.to_string(),
        DataRef::Float(number) => number.to_string(),
        DataRef::Bool(value) => value.to_string(),
        DataRef::SharedString(text) => return field_of(text, quoted),
        DataRef::String(text) => return field_of(text, quoted),
        DataRef::DateTime(date) => {
            let (year, month, day, hour, minute, second, _) = date.to_ymd_hms_milli();
            format!("{year:04}-{month:02}-{day:02} {hour:02}:{minute:02}:{second:02}")
        }
        DataRef::DateTimeIso(text) | DataRef::DurationIso(text) => quoted(text),
        // In quotes, since it begins as a comment does.
        DataRef::Error(error) => quoted(&error.to_string()),
    })
}

fn field_of(text: &str, quoted: impl Fn(&str) -> String) -> Option<String> {
    let text = text.trim();
    let special = text.contains([';', '"', '\n', '\r']);
    (!text.is_empty()).then(|| if special { quoted(text) } else { text.to_owned() })
}
