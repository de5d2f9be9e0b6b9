//! Tables written as CSV: commas between fields, quotes where a field needs them, one line a row (RFC 4180, lines end with a
//! line feed). The caller's columns say in which units their numbers are.

use std::io;

/// A named column: its text in each row.
type Column<'a> = (String, Box<dyn Fn(usize) -> String + 'a>);

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

    /// Adds a column; `cell` gives its text in a row.
    pub fn column(&mut self, name: impl Into<String>, cell: impl Fn(usize) -> String + 'a) {
        self.columns.push((name.into(), Box::new(cell)));
    }

    /// The CSV of these rows, under a line with the names.
    ///
    /// # Errors
    /// None in practice: it is written to memory.
    pub fn csv(&self, rows: impl IntoIterator<Item = usize>) -> io::Result<String> {
        let mut writer = csv::Writer::from_writer(Vec::new());
        writer.write_record(self.columns.iter().map(|(name, _)| name))?;
        for row in rows {
            writer.write_record(self.columns.iter().map(|(_, cell)| cell(row)))?;
        }
        let bytes = writer.into_inner().map_err(csv::IntoInnerError::into_error)?;
        String::from_utf8(bytes).map_err(io::Error::other)
    }
}
