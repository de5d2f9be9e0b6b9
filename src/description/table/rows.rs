//! Reading the rows of a table below its header, streaming.

use std::collections::BTreeMap;
use std::io::Read;

use csv::{ByteRecord, Reader, ReaderBuilder, Terminator};

use super::cell::Data;
use super::columns::{Dialect, ExpectedColumn, Layout, Table};
use super::header::Header;
use super::source::{LONGEST_ROW, Row, Source};
use crate::diagnostic::{Diagnostic, Place};

/// Most faults shown of one file; the others are counted.
const MOST_SHOWN: usize = 20;

/// Reads the columns that are expected, streaming.
///
/// `rename` maps our name of a column to the file's, where they differ; `ignore` lists columns of the file to pass over.
/// Blanks around names and numbers, quoted fields, a byte-order mark, CRLF and empty lines are accepted.
///
/// # Errors
///
/// Every fault of the file, each with its line: columns missing, unknown, given twice or renamed from nothing, cells that are
/// empty or no finite numbers, rows of another length, a wrong delimiter or decimal sign, no rows or more than `max_rows`, text
/// that is not UTF-8. After the first faults the others are counted.
pub fn read_table(
    file: &str,
    reader: impl Read,
    expected: &[ExpectedColumn],
    rename: &BTreeMap<String, String>,
    ignore: &[String],
    dialect: &Dialect,
    max_rows: usize,
) -> Result<Table, Vec<Diagnostic>> {
    let mut source = Source::new(reader);
    let head = source.first_line().map_err(|error| vec![failure(file, &error)])?;
    let header = Header::read(file, &head, &source, &Layout { expected, rename, ignore, dialect })?;
    let mut builder = ReaderBuilder::new();
    builder.delimiter(header.delimiter).has_headers(false).flexible(true).terminator(Terminator::Any(b'\n'));
    let reader = builder.buffer_capacity(1 << 16).from_reader(source);
    let (faults, data, lines) = (Faults::default(), Vec::new(), Vec::new());
    let decimal = dialect.decimal.or((header.delimiter == b',').then_some('.'));
    Rows { file, header, dialect, decimal, reader, faults, data, lines, quote_reported: false }.read(max_rows)
}

/// A failure of the disk or the network.
fn failure(file: &str, error: &std::io::Error) -> Diagnostic {
    let start = Place { file: file.to_owned(), line: 1, column: 1, excerpt: String::new(), highlight: 0..0 };
    Diagnostic::error(format!("the file cannot be read: {error}")).at(start)
}

/// The faults shown and the number of the others.
#[derive(Default)]
struct Faults {
    shown: Vec<Diagnostic>,
    hidden: usize,
    /// The place of the first one that is not shown.
    next: Option<Place>,
}

impl Faults {
    fn add(&mut self, fault: impl FnOnce() -> Diagnostic) {
        if self.shown.len() < MOST_SHOWN {
            self.shown.push(fault());
            return;
        }
        if self.hidden == 0 {
            self.next = fault().place;
        }
        self.hidden += 1;
    }

    fn none(&self) -> bool {
        self.shown.is_empty()
    }

    fn finish(mut self) -> Vec<Diagnostic> {
        if self.hidden > 0 {
            let more = Diagnostic::error(format!("and {} more; the first of them is here", self.hidden));
            self.shown.push(more.at(self.next));
        }
        self.shown
    }
}

/// The reading of the rows below the header.
struct Rows<'a, R> {
    file: &'a str,
    header: Header,
    dialect: &'a Dialect,
    /// The decimal sign, once it is known.
    decimal: Option<char>,
    reader: Reader<Source<R>>,
    faults: Faults,
    data: Vec<Data>,
    lines: Vec<u32>,
    /// An unclosed quote has been shown.
    quote_reported: bool,
}

impl<R: Read> Rows<'_, R> {
    fn read(mut self, max_rows: usize) -> Result<Table, Vec<Diagnostic>> {
        self.faults.shown = std::mem::take(&mut self.header.faults);
        self.data = self.header.columns.iter().map(|column| Data::of(column.kind)).collect();
        let mut record = ByteRecord::new();
        let mut count = 0;
        let mut header_seen = false;
        let mut last = (0, 1);
        loop {
            let (at, line) = (self.reader.position().byte(), self.line());
            self.reader.get_mut().row_starts(at);
            match self.reader.read_byte_record(&mut record) {
                Ok(true) => {}
                Ok(false) => break,
                Err(error) => {
                    self.faults.shown.truncate(MOST_SHOWN - 1);
                    let fault = self.broken(at, line, &error);
                    self.faults.shown.push(fault);
                    return Err(self.faults.finish());
                }
            }
            last = (at, line);
            if record.iter().all(|cell| cell.trim_ascii().is_empty()) {
                continue;
            }
            if !header_seen {
                header_seen = true;
                continue;
            }
            count += 1;
            if count > max_rows {
                let place = self.row(at, line).field(0);
                let fault = Diagnostic::error(format!("more than {max_rows} rows, the most that is read of one file"))
                    .at(place);
                self.faults.shown.truncate(MOST_SHOWN - 1);
                self.faults.shown.push(fault.remedy("keep the readings that matter, or average repeats"));
                return Err(self.faults.finish());
            }
            self.take(&record, at, line);
        }
        let row = row_of(&self.reader, self.file, last.0, last.1, self.header.delimiter);
        if let Some(quote) = row.open_quote().filter(|_| !self.quote_reported) {
            self.faults.shown.truncate(MOST_SHOWN - 1);
            self.faults.shown.push(unclosed(&row, quote));
        } else if count == 0 {
            let place = self.row(0, 1).fields_from(0);
            self.faults
                .add(|| Diagnostic::error("the file holds a header and no rows").at(place).remedy("add the readings"));
        }
        if self.faults.none() { Ok(self.table()) } else { Err(self.faults.finish()) }
    }

    fn line(&self) -> usize {
        usize::try_from(self.reader.position().line()).unwrap_or(usize::MAX)
    }

    /// The row that starts at an offset, as it stands in the file.
    fn row(&self, at: u64, line: usize) -> Row<'_> {
        Row::at(self.file, self.reader.get_ref().from(at), line, self.header.delimiter)
    }

    /// A row that could not be read.
    fn broken(&self, at: u64, line: usize, error: &csv::Error) -> Diagnostic {
        let row = self.row(at, line);
        if !self.reader.get_ref().too_long {
            return Diagnostic::error(format!("the file cannot be read on: {error}")).at(row.field(0));
        }
        match row.open_quote() {
            Some(quote) => {
                let diagnostic =
                    Diagnostic::error("this quote is not closed within 1 MiB").at(row.place(quote..quote + 1));
                diagnostic.remedy("close it, or remove it")
            }
            None => Diagnostic::error(format!("a row longer than {LONGEST_ROW} bytes")).at(row.field(0)),
        }
    }

    /// Takes one row in.
    fn take(&mut self, record: &ByteRecord, at: u64, line: usize) {
        let (found, wanted) = (record.len(), self.header.count);
        // A delimiter at the very end of a row is passed over.
        let trailing = found == wanted + 1 && record.get(wanted).is_some_and(|cell| cell.trim_ascii().is_empty());
        if found != wanted && !trailing {
            let row = row_of(&self.reader, self.file, at, line, self.header.delimiter);
            let comma = self.header.delimiter == b',';
            let quote = row.open_quote();
            self.quote_reported |= quote.is_some();
            self.faults.add(|| {
                if let Some(quote) = quote {
                    return unclosed(&row, quote);
                }
                let place = if found > wanted { row.fields_from(wanted) } else { row.place(row.bytes.len()..row.bytes.len()) };
                let fields = if found == 1 { "field" } else { "fields" };
                let diagnostic = Diagnostic::error(format!("{found} {fields} in this row, expected {wanted} as in the header")).at(place);
                diagnostic.remedy(match (found > wanted, comma) {
                    (true, true) => {
                        "remove the extra fields; where the decimal sign is a comma, separate the columns by `;` instead"
                    }
                    (true, false) => "remove the extra fields, or put a text that holds the delimiter in quotes",
                    (false, _) => "add the missing fields, or remove the row",
                })
            });
            return;
        }
        for (column, data) in self.header.columns.iter().zip(&mut self.data) {
            let cell = record.get(column.field).unwrap_or_default();
            if let Err(wrong) = data.push(cell, &mut self.decimal, self.faults.none()) {
                let row = row_of(&self.reader, self.file, at, line, self.header.delimiter);
                let (delimiter, decimal) = (self.header.delimiter, self.decimal.unwrap_or('.'));
                let diagnostic = || wrong.diagnostic(cell, column, self.dialect, delimiter, decimal);
                self.faults.add(|| diagnostic().at(row.field(column.field)));
            }
        }
        if let Some(&field) = self.header.nameless.as_ref()
            && record.get(field).is_some_and(|cell| !cell.trim_ascii().is_empty())
        {
            let row = row_of(&self.reader, self.file, at, line, self.header.delimiter);
            let remedy = "name the column in the header, or remove the value";
            self.faults
                .add(|| Diagnostic::error("a value in a column without a name").at(row.field(field)).remedy(remedy));
        }
        if self.faults.none() {
            let empty = self.reader.get_ref().from(at).iter().take_while(|&&byte| byte == b'\n').count();
            self.lines.push(u32::try_from(line + empty).unwrap_or(u32::MAX));
        } else {
            // Nothing of a faulty file is used.
            self.data.iter_mut().for_each(Data::forget);
            self.lines = Vec::new();
        }
    }

    fn table(self) -> Table {
        let mut table = Table {
            file: self.file.to_owned(),
            lines: self.lines,
            delimiter: self.header.delimiter,
            whole: self.reader.into_inner().into_whole(),
            ..Table::default()
        };
        for (column, data) in self.header.columns.into_iter().zip(self.data) {
            table.fields.insert(column.name.clone(), column.field);
            match data {
                Data::Numbers(numbers) => drop(table.numbers.insert(column.name, numbers)),
                Data::Texts { column: texts, .. } => drop(table.texts.insert(column.name, texts)),
            }
        }
        table
    }
}

/// A quote that the file never closes.
fn unclosed(row: &Row<'_>, quote: usize) -> Diagnostic {
    Diagnostic::error("this quote is never closed").at(row.place(quote..quote + 1)).remedy("close it, or remove it")
}

/// As [`Rows::row`], borrowing the reader alone.
fn row_of<'a, R: Read>(reader: &'a Reader<Source<R>>, file: &'a str, at: u64, line: usize, delimiter: u8) -> Row<'a> {
    Row::at(file, reader.get_ref().from(at), line, delimiter)
}
