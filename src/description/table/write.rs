//! Tables written as CSV (commas between fields, quotes where a field needs them, one line a row: RFC 4180, lines end with a
//! line feed) or as a workbook of one sheet. The caller's columns say in which units their numbers are.

use std::io;
use std::path::Path;

use super::read::workbook_name;

/// A named column: its text in each row.
struct Column<'a> {
    name: String,
    /// Whether cells that read as numbers are numbers in a workbook, not names.
    #[cfg_attr(not(feature = "xlsx"), allow(dead_code))]
    is_number: bool,
    cell: Box<dyn Fn(usize) -> String + 'a>,
}

/// A table to be written, column by column.
#[derive(Default)]
pub struct Sheet<'a> {
    columns: Vec<Column<'a>>,
}

impl<'a> Sheet<'a> {
    /// A table without columns.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a column of numbers; `cell` gives its text in a row, empty where there is none.
    pub fn column(&mut self, name: impl Into<String>, cell: impl Fn(usize) -> String + 'a) {
        self.columns.push(Column { name: name.into(), is_number: true, cell: Box::new(cell) });
    }

    /// Adds a column of names or other texts, which stay texts even if they look like numbers.
    pub fn texts(&mut self, name: impl Into<String>, cell: impl Fn(usize) -> String + 'a) {
        self.columns.push(Column { name: name.into(), is_number: false, cell: Box::new(cell) });
    }

    /// The CSV of these rows, under a line with the names.
    ///
    /// # Errors
    /// None in practice: it is written to memory.
    pub fn csv(&self, rows: impl IntoIterator<Item = usize>) -> io::Result<String> {
        let mut writer = csv::Writer::from_writer(Vec::new());
        writer.write_record(self.columns.iter().map(|column| &column.name))?;
        for row in rows {
            writer.write_record(self.columns.iter().map(|column| (column.cell)(row)))?;
        }
        let bytes = writer.into_inner().map_err(csv::IntoInnerError::into_error)?;
        String::from_utf8(bytes).map_err(io::Error::other)
    }

    /// The bytes of a file of these rows: a workbook where its name ends in `.xlsx`, else CSV.
    ///
    /// # Errors
    /// More rows than a sheet holds, or no feature `xlsx`.
    pub fn file(&self, path: &Path, rows: impl IntoIterator<Item = usize>) -> io::Result<Vec<u8>> {
        match path.to_str().and_then(workbook_name) {
            Some(_) => self.workbook(rows),
            None => Ok(self.csv(rows)?.into_bytes()),
        }
    }

    /// A workbook of one sheet, the names in its first row.
    #[cfg(feature = "xlsx")]
    fn workbook(&self, rows: impl IntoIterator<Item = usize>) -> io::Result<Vec<u8>> {
        let mut workbook = rust_xlsxwriter::Workbook::new();
        let written = self.fill(workbook.add_worksheet(), rows);
        written.and_then(|()| workbook.save_to_buffer()).map_err(io::Error::other)
    }

    #[cfg(feature = "xlsx")]
    fn fill(
        &self,
        sheet: &mut rust_xlsxwriter::Worksheet,
        rows: impl IntoIterator<Item = usize>,
    ) -> Result<(), rust_xlsxwriter::XlsxError> {
        let bold = rust_xlsxwriter::Format::new().set_bold();
        for (at, column) in (0..).zip(&self.columns) {
            sheet.write_with_format(0, at, &column.name, &bold)?;
        }
        sheet.set_freeze_panes(1, 0)?;
        for (line, row) in (1..).zip(rows) {
            for (at, column) in (0..).zip(&self.columns) {
                let text = (column.cell)(row);
                match text.parse::<f64>() {
                    Ok(number) if column.is_number && number.is_finite() => sheet.write(line, at, number)?,
                    _ if text.is_empty() => continue,
                    _ => sheet.write(line, at, text)?,
                };
            }
        }
        Ok(())
    }

    #[cfg(not(feature = "xlsx"))]
    fn workbook(&self, _: impl IntoIterator<Item = usize>) -> io::Result<Vec<u8>> {
        Err(io::Error::other("this program is built without workbooks (feature `xlsx`)"))
    }
}
