//! Reading the rows of a table below its header, streaming.

use std::io::Read;

use csv::{ByteRecord, Reader};

use super::cell::Data;
use super::columns::{Layout, MOST_SHOWN, Table};
use super::dialect::Dialect;
use super::header::Header;
use super::line::reader as reader_of;
use super::points::{NAMES, Unused};
use super::row::{Delimiter, Row, Writing};
use super::source::{LONGEST_ROW, Source, is_comment};
use super::units::{OfColumn, doubt, is_row_of_units, of_columns};
use crate::diagnostic::{Diagnostic, Place};

/// Reads the columns of a text that a layout expects, streaming.
pub(super) fn read_laid_out(
    file: &str,
    reader: impl Read,
    layout: &Layout,
    max_rows: usize,
) -> Result<Table, Vec<Diagnostic>> {
    let mut rename = layout.rename.clone();
    let own_ignored = layout.ignore;
    let mut ignore = own_ignored.to_vec();
    let points = layout.dialect.points.as_ref();
    if let Some(points) = points {
        rename.extend(points.columns.clone());
        ignore.extend(NAMES.into_iter().filter(|name| !rename.values().any(|used| used == name)).map(String::from));
    }
    let layout = &Layout { rename: &rename, ignore: &ignore, ..*layout };
    let mut source = Source::new(reader, points.is_some());
    let (line, number) = source.first_line().map_err(|error| vec![failure(file, &error)])?;
    let header = Header::read(file, &line, number, &source, layout)?;
    let unused = points.map(|points| Unused::of(&header.titles, points, own_ignored)).unwrap_or_default();
    let delimiter = header.writing.delimiter;
    source.delimiter = Some(delimiter);
    let reader = reader_of(delimiter).buffer_capacity(1 << 16).from_reader(source);
    let decimal = layout.dialect.decimal.or((delimiter == Delimiter::Byte(b',')).then_some('.'));
    let rows = Rows {
        file,
        dialect: layout.dialect,
        decimal,
        reader,
        faults: Faults::default(),
        data: header.columns.iter().map(Data::of).collect(),
        lines: Vec::new(),
        units: Vec::new(),
        commented: (0, None),
        notes: Vec::new(),
        quote_reported: false,
        unused,
        header,
    };
    rows.read(max_rows)
}

/// A failure of the disk or the network.
fn failure(file: &str, error: &std::io::Error) -> Diagnostic {
    Diagnostic::error(format!("the file cannot be read: {error}")).at(Place::line_of(file, 1))
}

/// The faults shown and the number of the others.
#[derive(Default)]
pub(super) struct Faults {
    shown: Vec<Diagnostic>,
    hidden: usize,
    /// The place of the first one that is not shown.
    next: Option<Place>,
}

impl Faults {
    pub fn add(&mut self, fault: impl FnOnce() -> Diagnostic) {
        if self.shown.len() < MOST_SHOWN {
            self.shown.push(fault());
            return;
        }
        if self.hidden == 0 {
            self.next = fault().place;
        }
        self.hidden += 1;
    }

    pub fn none(&self) -> bool {
        self.shown.is_empty()
    }

    pub fn finish(mut self) -> Vec<Diagnostic> {
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
    /// By column, where a row of units is given.
    units: Vec<OfColumn>,
    /// Comments that read like rows, and the place of the first.
    commented: (usize, Option<Place>),
    notes: Vec<Diagnostic>,
    /// An unclosed quote has been shown.
    quote_reported: bool,
    /// Of a list of points.
    unused: Vec<Unused>,
}

impl<R: Read> Rows<'_, R> {
    fn read(mut self, max_rows: usize) -> Result<Table, Vec<Diagnostic>> {
        self.faults.shown = std::mem::take(&mut self.header.faults);
        let mut record = ByteRecord::new();
        let mut count = 0;
        let mut header_seen = !self.header.is_line;
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
                if header_seen {
                    self.count_comment(at, line);
                }
                continue;
            }
            if !header_seen {
                header_seen = true;
                continue;
            }
            if count == 0 && self.units.is_empty() && is_row_of_units(&record, &self.header.columns) {
                self.take_units(&record, at, line)?;
                continue;
            }
            count += 1;
            if count > max_rows {
                let place = self.row(at, line).field(0);
                self.faults.shown.truncate(MOST_SHOWN - 1);
                self.faults.shown.push(too_many(max_rows).at(place));
                return Err(self.faults.finish());
            }
            self.take(&record, at, line);
        }
        let row = row_of(&self.reader, self.file, last.0, last.1, self.header.writing);
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
        Row::at(self.file, self.reader.get_ref().from(at), line, self.header.writing)
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

    /// Takes the row of units in.
    fn take_units(&mut self, record: &ByteRecord, at: u64, line: usize) -> Result<(), Vec<Diagnostic>> {
        let row = row_of(&self.reader, self.file, at, line, self.header.writing);
        match of_columns(record, &self.header, &row) {
            Ok(units) => self.units = units,
            Err(mut faults) => {
                self.faults.shown.append(&mut faults);
                return Err(std::mem::take(&mut self.faults).finish());
            }
        }
        Ok(())
    }

    /// Counts a comment that has as many fields as a row.
    fn count_comment(&mut self, at: u64, line: usize) {
        let row = row_of(&self.reader, self.file, at, line, self.header.writing);
        let bytes = row.bytes.trim_ascii();
        if self.header.count > 1
            && bytes.starts_with(b"#")
            && is_comment(bytes, false)
            && row.count() == self.header.count
        {
            self.commented.0 += 1;
            let place = row.fields_from(0);
            self.commented.1.get_or_insert(place);
        }
    }

    /// Takes one row in.
    fn take(&mut self, record: &ByteRecord, at: u64, line: usize) {
        let (found, wanted) = (record.len(), self.header.count);
        // A delimiter at the very end of a row is passed over.
        let trailing = found == wanted + 1 && record.get(wanted).is_some_and(|cell| cell.trim_ascii().is_empty());
        if found != wanted && !trailing {
            let row = row_of(&self.reader, self.file, at, line, self.header.writing);
            let comma = self.header.writing.delimiter == Delimiter::Byte(b',');
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
        self.unused.iter_mut().for_each(|unused| unused.take(record));
        for (column, data) in self.header.columns.iter().zip(&mut self.data) {
            let cell = record.get(column.field).unwrap_or_default();
            if let Err(wrong) = data.push(cell, &mut self.decimal, self.faults.none()) {
                let row = row_of(&self.reader, self.file, at, line, self.header.writing);
                let (writing, decimal) = (self.header.writing, self.decimal.unwrap_or('.'));
                let diagnostic = || wrong.diagnostic(cell, column, self.dialect, writing, decimal);
                self.faults.add(|| diagnostic().at(row.field(column.field)));
            }
        }
        if let Some(&field) = self.header.nameless.as_ref()
            && record.get(field).is_some_and(|cell| !cell.trim_ascii().is_empty())
        {
            let row = row_of(&self.reader, self.file, at, line, self.header.writing);
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
        let mut notes = self.notes;
        notes.extend(doubt(&self.header.columns, &self.units));
        let not_used = self.unused.iter().filter_map(Unused::doubt);
        notes.extend(not_used.map(|doubt| doubt.at(Place::line_of(self.file, 1))));
        let (commented, place) = self.commented;
        if commented > 0 {
            let rows = if commented == 1 { "1 row is".into() } else { format!("{commented} rows are") };
            let doubt = Diagnostic::warning(format!("{rows} passed over as a comment, the first of them here"));
            notes.push(doubt.at(place).remedy("remove the `#` of what is meant as a reading"));
        }
        let mut table = Table {
            file: self.file.to_owned(),
            lines: self.lines,
            notes,
            writing: self.header.writing,
            whole: self.reader.into_inner().into_whole(),
            ..Table::default()
        };
        let factors = self.units.iter().map(|units| units.factor).chain(std::iter::repeat(1.0));
        for ((column, data), factor) in self.header.columns.into_iter().zip(self.data).zip(factors) {
            table.fields.insert(column.name.clone(), column.field);
            match data {
                Data::Numbers { column: mut numbers, .. } => {
                    // Exact where the units are the same.
                    numbers.iter_mut().for_each(|number| *number *= factor);
                    table.numbers.insert(column.name, numbers);
                }
                Data::Texts { column: texts, .. } => drop(table.texts.insert(column.name, texts)),
            }
        }
        table
    }
}

/// More rows than are read.
pub(crate) fn too_many(most: usize) -> Diagnostic {
    Diagnostic::error(format!("more than {most} rows, the most that is read where the campaign allows no more"))
        .remedy("average repeats, or allow more with `csv: {max_rows: ..}`: a calibration takes 5 to 7 kB a row")
}

/// A quote that the file never closes.
fn unclosed(row: &Row<'_>, quote: usize) -> Diagnostic {
    Diagnostic::error("this quote is never closed").at(row.place(quote..quote + 1)).remedy("close it, or remove it")
}

/// As [`Rows::row`], borrowing the reader alone.
fn row_of<'a, R: Read>(
    reader: &'a Reader<Source<R>>,
    file: &'a str,
    at: u64,
    line: usize,
    writing: Writing,
) -> Row<'a> {
    Row::at(file, reader.get_ref().from(at), line, writing)
}
