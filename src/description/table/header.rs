//! The first line of a table: the delimiter, and which field is which column.

use super::columns::{ColumnKind, Dialect, ExpectedColumn, Layout};
use super::source::{Row, Source};
use crate::diagnostic::{Code, Diagnostic, Place, nearest};
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
        layout: &Layout,
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
            return Err(fatal("the file is empty", &wanted(layout.expected)));
        }
        let Some(delimiter) = delimiter(line, layout.dialect) else {
            return Err(fatal(
                "the delimiter must be one ASCII character other than the decimal sign",
                "change `csv:`",
            ));
        };
        let row = Row { file, bytes: line.strip_suffix(b"\n").unwrap_or(line), line: 1 + blank, delimiter };
        let titles = titles(line, delimiter);
        if let Some(fault) = not_text(&row).or_else(|| no_header(&row, &titles, layout)) {
            return Err(vec![fault]);
        }
        let (columns, count, faults) = (Vec::new(), titles.len(), Vec::new());
        let mut header = Self { columns, count, nameless: None, delimiter, faults };
        let used = header.find(&row, &titles, layout);
        for ours in layout.rename.keys().filter(|ours| !layout.expects(ours)) {
            let diagnostic = Diagnostic::error(format!("`columns:` renames `{ours}`, which is no column here"))
                .at(row.fields_from(0));
            header.faults.push(diagnostic.suggest(ours, layout.expected.iter().map(|column| column.name.as_str())));
        }
        for (field, used) in used.into_iter().enumerate() {
            header.check_title(&row, &titles, field, used, layout);
        }
        Ok(header)
    }

    /// Finds each expected column; says which fields are accounted for.
    fn find(&mut self, row: &Row<'_>, titles: &[String], layout: &Layout) -> Vec<bool> {
        let mut used = vec![false; titles.len()];
        for column in layout.expected {
            let renamed = layout.rename.get(&column.name);
            let title = renamed.unwrap_or(&column.name).trim();
            let Some(field) = titles.iter().position(|found| found == title) else {
                if column.required || renamed.is_some() {
                    let free = titles.iter().map(String::as_str).filter(|title| !layout.expects(title));
                    let near = nearest(title, free).and_then(|near| titles.iter().position(|title| title == near));
                    let alike = near.map(|near| (near, &titles[near]));
                    self.faults.push(missing(column, renamed, alike, row, layout.dialect.of_campaign));
                    // It is named already; it need not be called unknown too.
                    near.into_iter().for_each(|near| used[near] = true);
                }
                continue;
            };
            used[field] = true;
            if !layout.ignores(title) {
                let (name, title, kind) = (column.name.clone(), title.to_owned(), column.kind);
                self.columns.push(Column { name, title, kind, field });
            } else if column.required {
                let message = format!("`ignore:` leaves out the column `{title}`, which is needed");
                let diagnostic = Diagnostic::error(message).at(row.field(field));
                self.faults.push(diagnostic.remedy("take it out of `ignore:`"));
            }
        }
        used
    }

    /// What is wrong with the name of a field.
    fn check_title(&mut self, row: &Row<'_>, titles: &[String], field: usize, used: bool, layout: &Layout) {
        let title = &titles[field];
        if title.is_empty() && field + 1 == titles.len() {
            self.nameless = Some(field);
        } else if layout.ignores(title) {
        } else if title.is_empty() {
            let diagnostic = Diagnostic::error(format!("column {} has no name", field + 1)).at(row.field(field));
            self.faults.push(diagnostic.remedy("name it, or remove it"));
        } else if let Some(first) = titles.iter().take(field).position(|other| other == title) {
            let diagnostic = Diagnostic::error(format!("the column `{title}` is given twice")).at(row.field(field));
            let diagnostic = diagnostic.code(Code::Duplicate).related(Some(row.field(first)), "first given here");
            self.faults.push(diagnostic.remedy("rename or remove one of the two"));
        } else if !used {
            let free = layout.expected.iter().map(|column| column.name.as_str());
            let free = free.filter(|name| self.columns.iter().all(|column| column.name != *name));
            let remedy = match (nearest(title, free), layout.dialect.of_campaign) {
                (Some(ours), true) => format!(
                    "if it is `{ours}`, add `columns: {{{ours}: {title}}}`; else list it under `ignore:`, or rename it under `columns:`"
                ),
                (None, true) => "list it under `ignore:`, or rename it under `columns:`".to_owned(),
                (Some(ours), false) => format!("if it is `{ours}`, rename it; else remove the column"),
                (None, false) => "remove the column, or rename it".to_owned(),
            };
            let diagnostic = Diagnostic::error(format!("unknown column `{title}`")).code(Code::Unknown);
            self.faults.push(diagnostic.at(row.field(field)).remedy(remedy));
        }
    }
}

/// Why the header line is no line of text.
fn not_text(row: &Row) -> Option<Diagnostic> {
    if let Some(at) = row.bytes.trim_ascii_end().iter().position(|&byte| byte == b'\r') {
        let diagnostic = Diagnostic::error("the lines end in a lone carriage return").at(row.place(at..at + 1));
        return Some(diagnostic.remedy("save the file with LF or CRLF line ends"));
    }
    if let Err(error) = std::str::from_utf8(row.bytes) {
        let at = error.valid_up_to();
        let diagnostic = Diagnostic::error("the header is not UTF-8").at(row.place(at..at + 1));
        return Some(diagnostic.remedy("save the file as UTF-8"));
    }
    if let Some(at) = row.bytes.iter().position(|&byte| byte == 0) {
        let diagnostic = Diagnostic::error("a NUL byte stands here; the file is not a text").at(row.place(at..at + 1));
        return Some(diagnostic.remedy("save the file as UTF-8"));
    }
    let quote = row.open_quote()?;
    let diagnostic = Diagnostic::error("this quote is not closed on its line").at(row.place(quote..quote + 1));
    Some(diagnostic.remedy("close it, or remove it"))
}

/// Why the line is no header: one column by a wrong delimiter, or numbers.
fn no_header(row: &Row, titles: &[String], layout: &Layout) -> Option<Diagnostic> {
    if let [only] = titles
        && let Some(other) =
            [b';', b'\t', b','].into_iter().find(|&other| other != row.delimiter && only.as_bytes().contains(&other))
    {
        let at = row.bytes.iter().position(|&byte| byte == other).unwrap_or_default();
        let found = shown(other);
        let diagnostic = Diagnostic::error(format!("the header is one column; is `{found}` the delimiter?"));
        return Some(diagnostic.at(row.place(at..at + 1)).remedy(if layout.dialect.of_campaign {
            format!("declare it: `csv: {{delimiter: \"{found}\"}}`")
        } else {
            "separate all columns by one of `,`, `;` and the tab".to_owned()
        }));
    }
    let numbers = titles.iter().filter(|title| title.replace(',', ".").parse::<f64>().is_ok()).count();
    if 2 * numbers > titles.len() && !titles.iter().any(|title| layout.names(title)) {
        let diagnostic = Diagnostic::error("the first line must be a header that names the columns, found numbers");
        return Some(diagnostic.at(row.fields_from(0)).remedy(wanted(layout.expected)));
    }
    None
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
