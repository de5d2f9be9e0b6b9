//! The first line of a table: the delimiter, and which field is which column.

use super::source::{Row, Source};
use super::{ColumnKind, Dialect, ExpectedColumn};
use crate::diagnostic::{Diagnostic, Place, nearest};
use std::collections::BTreeMap;
use std::io::{self, Read};

/// A column to read.
pub(super) struct Column {
    /// Our name.
    pub name: String,
    /// The file's name.
    pub title: String,
    pub kind: ColumnKind,
    pub field: usize,
}

/// What the first line says.
pub(super) struct Header {
    pub columns: Vec<Column>,
    /// Number of fields in a row.
    pub count: usize,
    /// A last field without a name, as a delimiter at the end of each line makes it.
    pub nameless: Option<usize>,
    pub delimiter: u8,
    pub faults: Vec<Diagnostic>,
}

/// A cell without the blanks and quotes around it.
pub(super) fn unquoted(cell: &str) -> &str {
    let cell = cell.trim();
    cell.strip_prefix('"').and_then(|cell| cell.strip_suffix('"')).map_or(cell, str::trim)
}

/// How to begin a file.
fn wanted(expected: &[ExpectedColumn]) -> String {
    let names = |all: bool| -> Vec<&str> {
        let wanted = expected.iter().filter(|column| all || column.required);
        wanted.map(|column| column.name.as_str()).filter(|name| !name.contains('.')).collect()
    };
    match names(false) {
        needed if needed.is_empty() => {
            format!("start it with a header line that names its columns, of {}", names(true).join(", "))
        }
        needed => format!("start it with a header line that names {}", needed.join(", ")),
    }
}

/// A tab is named, not shown.
fn shown(delimiter: u8) -> &'static str {
    match delimiter {
        b'\t' => "\\t",
        b';' => ";",
        _ => ",",
    }
}

impl Header {
    /// Reads the header; `head` is the file up to the end of its first line that is not blank.
    ///
    /// Faults that leave the rows readable are in the header; the others are the error.
    pub fn read<R: Read>(
        file: &str,
        head: &[u8],
        source: &Source<R>,
        dialect: &Dialect,
        expected: &[ExpectedColumn],
        rename: &BTreeMap<String, String>,
        ignore: &[String],
    ) -> Result<Self, Vec<Diagnostic>> {
        let start = Place { file: file.to_owned(), line: 1, column: 1, excerpt: String::new(), highlight: 0..0 };
        let fatal = |message: &str, remedy: &str| vec![Diagnostic::error(message).at(start.clone()).remedy(remedy)];
        if source.wide {
            return Err(fatal(
                "the file is in UTF-16, expected UTF-8",
                "save it as UTF-8 (\"CSV UTF-8\" in a spreadsheet)",
            ));
        }
        let blank = head.split_inclusive(|&byte| byte == b'\n').take_while(|line| line.trim_ascii().is_empty()).count();
        let skipped = head.split_inclusive(|&byte| byte == b'\n').take(blank).map(<[u8]>::len).sum();
        let line = head.get(skipped..).unwrap_or_default();
        if line.trim_ascii().is_empty() {
            return Err(fatal("the file is empty", &wanted(expected)));
        }
        let delimiter = delimiter(line, dialect);
        let Some(delimiter) = delimiter else {
            return Err(fatal(
                "the delimiter must be one ASCII character other than the decimal sign",
                "change `csv:`",
            ));
        };
        let row = Row { file, bytes: line, line: 1 + blank, delimiter };
        let row = Row { bytes: line.strip_suffix(b"\n").unwrap_or(line), ..row };
        if let Some(at) = row.bytes.trim_ascii_end().iter().position(|&byte| byte == b'\r') {
            let place = row.place(at..at + 1);
            let diagnostic = Diagnostic::error("the lines end in a lone carriage return").at(place);
            return Err(vec![diagnostic.remedy("save the file with LF or CRLF line ends")]);
        }
        if let Err(error) = std::str::from_utf8(row.bytes) {
            let at = error.valid_up_to();
            let diagnostic = Diagnostic::error("the header is not UTF-8").at(row.place(at..at + 1));
            return Err(vec![diagnostic.remedy("save the file as UTF-8")]);
        }
        if let Some(at) = row.bytes.iter().position(|&byte| byte == 0) {
            let diagnostic =
                Diagnostic::error("a NUL byte stands here; the file is not a text").at(row.place(at..at + 1));
            return Err(vec![diagnostic.remedy("save the file as UTF-8")]);
        }
        if let Some(quote) = row.open_quote() {
            let diagnostic = Diagnostic::error("this quote is not closed on its line").at(row.place(quote..quote + 1));
            return Err(vec![diagnostic.remedy("close it, or remove it")]);
        }
        let titles = titles(line, delimiter);
        if let [only] = titles.as_slice()
            && let Some(other) =
                [b';', b'\t', b','].into_iter().find(|&other| other != delimiter && only.as_bytes().contains(&other))
        {
            let at = row.bytes.iter().position(|&byte| byte == other).unwrap_or_default();
            let found = shown(other);
            let diagnostic = Diagnostic::error(format!("the header is one column; is `{found}` the delimiter?"))
                .at(row.place(at..at + 1));
            return Err(vec![diagnostic.remedy(if dialect.of_campaign {
                format!("declare it: `csv: {{delimiter: \"{found}\"}}`")
            } else {
                "separate all columns by one of `,`, `;` and the tab".to_owned()
            })]);
        }
        let named = |title: &String| {
            expected.iter().any(|column| column.name == *title)
                || rename.values().any(|renamed| renamed.trim() == title)
        };
        let numbers = titles.iter().filter(|title| title.replace(',', ".").parse::<f64>().is_ok()).count();
        if 2 * numbers > titles.len() && !titles.iter().any(named) {
            let diagnostic = Diagnostic::error("the first line must be a header that names the columns, found numbers");
            return Err(vec![diagnostic.at(row.fields_from(0)).remedy(wanted(expected))]);
        }
        let mut header =
            Self { columns: Vec::new(), count: titles.len(), nameless: None, delimiter, faults: Vec::new() };
        header.resolve(&row, &titles, expected, rename, ignore, dialect.of_campaign);
        Ok(header)
    }

    /// Finds each expected column, and what is wrong with the others.
    fn resolve(
        &mut self,
        row: &Row<'_>,
        titles: &[String],
        expected: &[ExpectedColumn],
        rename: &BTreeMap<String, String>,
        ignore: &[String],
        of_campaign: bool,
    ) {
        let mut used = vec![false; titles.len()];
        let ignored = |title: &str| ignore.iter().any(|ignored| ignored.trim() == title);
        for column in expected {
            let renamed = rename.get(&column.name);
            let title = renamed.unwrap_or(&column.name).trim();
            let Some(field) = titles.iter().position(|found| found == title) else {
                if column.required || renamed.is_some() {
                    let known = |title: &str| expected.iter().any(|column| column.name == title);
                    let free = titles.iter().map(String::as_str).filter(|title| !known(title));
                    let near = nearest(title, free).and_then(|near| titles.iter().position(|title| title == near));
                    self.faults.push(missing(
                        column,
                        renamed,
                        near.and_then(|near| Some((near, titles.get(near)?))),
                        row,
                        of_campaign,
                    ));
                    // It is named already; it need not be called unknown too.
                    if let Some(used) = near.and_then(|near| used.get_mut(near)) {
                        *used = true;
                    }
                }
                continue;
            };
            if let Some(used) = used.get_mut(field) {
                *used = true;
            }
            if ignored(title) {
                if column.required {
                    let message = format!("`ignore:` leaves out the column `{title}`, which is needed");
                    let diagnostic = Diagnostic::error(message).at(row.field(field));
                    self.faults.push(diagnostic.remedy("take it out of `ignore:`"));
                }
                continue;
            }
            self.columns.push(Column { name: column.name.clone(), title: title.to_owned(), kind: column.kind, field });
        }
        for ours in rename.keys().filter(|ours| expected.iter().all(|column| column.name != **ours)) {
            let diagnostic = Diagnostic::error(format!("`columns:` renames `{ours}`, which is no column here"))
                .at(row.fields_from(0));
            self.faults.push(diagnostic.suggest(ours, expected.iter().map(|column| column.name.as_str())));
        }
        for (field, title) in titles.iter().enumerate() {
            if title.is_empty() && field + 1 == titles.len() {
                self.nameless = Some(field);
                continue;
            }
            if ignored(title) {
                continue;
            }
            if title.is_empty() {
                let diagnostic = Diagnostic::error(format!("column {} has no name", field + 1)).at(row.field(field));
                self.faults.push(diagnostic.remedy("name it, or remove it"));
                continue;
            }
            if let Some(first) = titles.iter().take(field).position(|other| other == title) {
                let diagnostic = Diagnostic::error(format!("the column `{title}` is given twice")).at(row.field(field));
                let diagnostic = diagnostic.related(Some(row.field(first)), "first given here");
                self.faults.push(diagnostic.remedy("rename or remove one of the two"));
            } else if !used.get(field).copied().unwrap_or(false) {
                let free = expected.iter().map(|column| column.name.as_str());
                let free = free.filter(|name| self.columns.iter().all(|column| column.name != *name));
                let near = nearest(title, free);
                let remedy = match (near, of_campaign) {
                    (Some(ours), true) => format!(
                        "if it is `{ours}`, add `columns: {{{ours}: {title}}}`; else list it under `ignore:`, or rename it under `columns:`"
                    ),
                    (None, true) => "list it under `ignore:`, or rename it under `columns:`".to_owned(),
                    (Some(ours), false) => format!("if it is `{ours}`, rename it; else remove the column"),
                    (None, false) => "remove the column, or rename it".to_owned(),
                };
                self.faults
                    .push(Diagnostic::error(format!("unknown column `{title}`")).at(row.field(field)).remedy(remedy));
            }
        }
    }
}

/// An expected column that the file does not have; `near` is the one of the file's that is most like it.
fn missing(
    column: &ExpectedColumn,
    renamed: Option<&String>,
    near: Option<(usize, &String)>,
    row: &Row<'_>,
    of_campaign: bool,
) -> Diagnostic {
    let name = &column.name;
    let place = near.map_or_else(|| row.fields_from(0), |(field, _)| row.field(field));
    match (renamed, near) {
        (Some(renamed), near) => {
            let message =
                format!("`columns:` says that `{name}` is the column `{renamed}`, which the file does not have");
            let diagnostic = Diagnostic::error(message).at(place);
            match near {
                Some((_, near)) => diagnostic.remedy(format!("did you mean `{near}`?")),
                None => diagnostic.remedy("name a column of the header"),
            }
        }
        (None, Some((_, near))) => {
            let diagnostic = Diagnostic::error(format!("the column `{name}` is missing")).at(place);
            let declare = if of_campaign { format!(" or add `columns: {{{name}: {near}}}`") } else { String::new() };
            diagnostic.remedy(format!("if it is `{near}`, rename it{declare}"))
        }
        (None, None) => {
            let diagnostic = Diagnostic::error(format!("the column `{name}` is missing")).at(place);
            diagnostic.remedy(if of_campaign {
                format!("add it, or name the column that holds it: `columns: {{{name}: ...}}`")
            } else {
                "add it, or rename the column that holds it".to_owned()
            })
        }
    }
}

/// The delimiter declared, or the one the header holds most of; `None` if the declared one cannot be.
fn delimiter(line: &[u8], dialect: &Dialect) -> Option<u8> {
    let decimal = match dialect.decimal {
        Some(decimal) => Some(u8::try_from(decimal).ok().filter(|decimal| matches!(decimal, b'.' | b','))?),
        None => None,
    };
    if let Some(declared) = dialect.delimiter {
        let declared = u8::try_from(declared).ok().filter(u8::is_ascii)?;
        return (Some(declared) != decimal && !matches!(declared, b'\n' | b'\r' | b'"' | 0)).then_some(declared);
    }
    let count = |delimiter: u8| {
        let mut quoted = false;
        let outside = line.iter().filter(|&&byte| {
            quoted ^= byte == b'"';
            byte == delimiter && !quoted
        });
        outside.count()
    };
    let candidates = [b'\t', b';', b','].into_iter().filter(|&delimiter| Some(delimiter) != decimal);
    candidates.max_by_key(|&delimiter| count(delimiter))
}

/// The names in the header line.
fn titles(line: &[u8], delimiter: u8) -> Vec<String> {
    let mut builder = csv::ReaderBuilder::new();
    let mut reader = builder.delimiter(delimiter).has_headers(false).from_reader(line);
    let mut record = csv::ByteRecord::new();
    // Reading from memory does not fail; were it to, the header would be empty and every column missing.
    let _ = reader.read_byte_record(&mut record);
    record.iter().map(|title| unquoted(&String::from_utf8_lossy(title)).to_owned()).collect()
}

impl<R: Read> Source<R> {
    /// Reads up to the end of the first line that is not blank, to be handed out again later.
    pub fn first_line(&mut self) -> io::Result<Vec<u8>> {
        let mut head = Vec::new();
        let mut chunk = [0; 4096];
        loop {
            let read = self.read(&mut chunk)?;
            head.extend_from_slice(chunk.get(..read).unwrap_or_default());
            let text = head.iter().position(|byte| !byte.is_ascii_whitespace());
            if read == 0 || text.is_some_and(|text| head.iter().skip(text).any(|&byte| byte == b'\n')) {
                break;
            }
        }
        let text = head.iter().position(|byte| !byte.is_ascii_whitespace()).unwrap_or(head.len());
        let end = head.iter().skip(text).position(|&byte| byte == b'\n').map_or(head.len(), |end| text + end + 1);
        let line = head.get(..end).unwrap_or_default().to_vec();
        self.hand_back(head);
        Ok(line)
    }
}
