//! The first line of a table: the delimiter, and which field is which column.

use super::columns::{ColumnKind, ExpectedColumn, Layout};
use super::line::{delimiter, titles, unquoted};
use super::orientation::{NUMBERED, Orientation, VECTOR, also_written, undeclared};
use super::points;
use super::row::{Delimiter, Row, Writing};
use super::source::Source;
use super::titles::{scalar, synonym, without_unit};
use crate::diagnostic::{Code, Diagnostic, Place, nearest};
use std::io::Read;

/// A column to read.
pub(super) struct Column {
    /// Our name.
    pub name: String,
    /// The file's name.
    pub title: String,
    pub kind: ColumnKind,
    /// As [`ExpectedColumn`] has it.
    pub or_none: bool,
    pub field: usize,
}

/// What the first line says.
pub(super) struct Header {
    pub columns: Vec<Column>,
    /// All that the line names.
    pub titles: Vec<String>,
    /// Number of fields in a row.
    pub count: usize,
    /// A last field without a name, as a delimiter at the end of each line makes it.
    pub nameless: Option<usize>,
    /// Whether it stands in the file, and is not only known.
    pub is_line: bool,
    pub writing: Writing,
    pub faults: Vec<Diagnostic>,
    /// Columns that hold an orientation of which is not declared how it is written, as the file or `columns:` names them.
    undeclared: &'static [&'static str],
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

/// How a file writes orientations.
struct Written {
    /// As q0 to q3.
    is_numbered: bool,
    /// Columns that are missing because it writes them otherwise, which is said already.
    unclear: &'static [&'static str],
}

impl Written {
    fn explains(&self, column: &str) -> bool {
        self.unclear.contains(&column)
    }
}

impl Header {
    /// Reads the header: `line` of that number, the first that is not blank.
    ///
    /// Faults that leave the rows readable are in the header; the others are the error.
    pub fn read<R: Read>(
        file: &str,
        line: &[u8],
        number: usize,
        source: &Source<R>,
        layout: &Layout,
    ) -> Result<Self, Vec<Diagnostic>> {
        let fatal = |message: &str, remedy: &str| {
            Err(vec![Diagnostic::error(message).at(Place::line_of(file, 1)).remedy(remedy)])
        };
        if source.wide {
            return fatal("the file is in UTF-16, expected UTF-8", "save it as UTF-8 (\"CSV UTF-8\" in a spreadsheet)");
        }
        if line.trim_ascii().is_empty() {
            return fatal("the file is empty", &wanted(layout.expected));
        }
        let (own, declared) = (source.declared.map(char::from), layout.dialect.delimiter);
        if let (Some(own), Some(declared)) = (own, declared)
            && own != declared
        {
            let message =
                format!("the first line says `sep={own}`, and the campaign `csv: {{delimiter: \"{declared}\"}}`");
            return fatal(&message, "leave `delimiter` out of `csv:`, or correct one of the two");
        }
        let delimiter = delimiter(line, own.or(declared), layout.dialect.decimal);
        let Some(delimiter) = delimiter else {
            let shown = |sign: Option<char>| sign.map_or("none".to_string(), |sign| format!("`{sign}`"));
            let message = format!(
                "the delimiter must be one ASCII character other than the decimal sign; the campaign's `csv:` says {} and {}",
                shown(own.or(declared)),
                shown(layout.dialect.decimal)
            );
            return fatal(&message, "change `delimiter` or `decimal` under `csv:` in the campaign");
        };
        let writing = Writing { delimiter, sheet: layout.sheet };
        let row = Row { file, bytes: line.strip_suffix(b"\n").unwrap_or(line), line: number, writing };
        let titles = titles(line, delimiter);
        if let Some(fault) = not_text(&row) {
            return Err(vec![fault]);
        }
        let (titles, is_line) = match &layout.dialect.points {
            Some(points) => points::titles(points, &titles, &row).map_err(|fault| vec![fault])?,
            None => match no_header(&row, &titles, own, layout) {
                Some(fault) => return Err(vec![with_comment(fault, source, &row, layout)]),
                None => (titles, true),
            },
        };
        let (columns, count, faults) = (Vec::new(), titles.len(), Vec::new());
        let mut header =
            Self { columns, titles: titles.clone(), count, nameless: None, is_line, writing, faults, undeclared: &[] };
        let used = header.find(&row, &titles, layout);
        let is_reported = |ours: &String| header.undeclared.contains(&ours.as_str());
        let unknown = layout.rename.keys().filter(|ours| !layout.dialect.is_shared && !layout.expects(ours));
        for ours in unknown.filter(|ours| !is_reported(ours)).collect::<Vec<_>>() {
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
        let orientation = self.orientation(row, titles, layout, &mut used);
        for column in layout.expected {
            let renamed = layout.rename.get(&column.name);
            let has = |title: &str| titles.iter().any(|found| found == title);
            let renamed =
                renamed.filter(|renamed| !layout.dialect.is_shared || has(renamed.trim()) || !has(&column.name));
            let title = renamed.unwrap_or(&column.name).trim();
            let title =
                layout.dialect.orientation.other_title(title).filter(|_| orientation.is_numbered).unwrap_or(title);
            let Some(field) = titles.iter().position(|found| found == title) else {
                let may_lack = layout.dialect.points.is_some() || layout.dialect.is_shared;
                let is_missing = column.required || (renamed.is_some() && !may_lack);
                if is_missing && !orientation.explains(&column.name) {
                    let free = titles.iter().map(String::as_str).filter(|title| !layout.expects(title));
                    let same = |found: &&str| without_unit(found) == title;
                    let near = free.clone().find(same).or_else(|| nearest(title, free));
                    let near = near.and_then(|near| titles.iter().position(|title| title == near));
                    let alike = near.map(|near| (near, &titles[near]));
                    let fault = missing(column, renamed, alike, row, layout.dialect.of_campaign);
                    let declared = declared_otherwise(&column.name, titles, layout).filter(|_| renamed.is_none());
                    self.faults.push(match declared {
                        Some(remedy) => fault.remedy(remedy),
                        None => fault,
                    });
                    // It is named already; it need not be called unknown too.
                    near.into_iter().for_each(|near| used[near] = true);
                }
                continue;
            };
            used[field] = true;
            if !layout.ignores(title) {
                let (name, title) = (column.name.clone(), title.to_owned());
                self.columns.push(Column { name, title, kind: column.kind, or_none: column.or_none, field });
            } else if column.required {
                let message = format!("`ignore:` leaves out the column `{title}`, which is needed");
                let diagnostic = Diagnostic::error(message).at(row.field(field));
                self.faults.push(diagnostic.remedy("take it out of `ignore:`"));
            }
        }
        used
    }

    /// How the file writes orientations; faults where it cannot be told, or is not as declared.
    fn orientation(&mut self, row: &Row<'_>, titles: &[String], layout: &Layout, used: &mut [bool]) -> Written {
        let has_all = |names: &[&str]| names.iter().all(|name| titles.iter().any(|title| title == name));
        let is_declared = layout.dialect.orientation.other_title("qx").is_some();
        let is_numbered = is_declared && has_all(&NUMBERED) && !NUMBERED.iter().any(|name| layout.expects(name));
        let wanted = layout.dialect.orientation.columns();
        let is_wanted = wanted.iter().all(|name| layout.expects(name)) && !wanted.iter().any(|name| has_all(&[name]));
        // As `columns:` calls them.
        let ours = |title: &String| {
            layout
                .rename
                .iter()
                .find(|(_, renamed)| renamed.trim() == title)
                .map_or_else(|| title.clone(), |(ours, _)| ours.clone())
        };
        let called: Vec<String> = titles.iter().map(ours).collect();
        let undeclared = undeclared(&called)
            .filter(|(names, _)| is_wanted && !is_numbered && !names.iter().any(|name| layout.expects(name)));
        // Components that are called as joints are: nobody can say which is which.
        let is_renamed = NUMBERED.iter().any(|name| layout.rename.contains_key(*name));
        let is_declared_whole = wanted.iter().all(|name| layout.rename.contains_key(*name));
        let clash = is_wanted
            && !is_declared_whole
            && has_all(&NUMBERED)
            && (wanted == VECTOR && twice(titles, &NUMBERED[1..]) || (wanted == VECTOR || is_declared) && is_renamed);
        if let Some(field) = titles.iter().position(|title| title == NUMBERED[0]).filter(|_| clash) {
            let message = "the columns q0, q1, q2, q3 look like a quaternion, and joints are called so too";
            let remedy = "name its components qx, qy, qz and qw in the file, and declare `orientation: {quaternion: xyzw}` or \
                          `{quaternion: wxyz}`";
            self.faults.push(Diagnostic::error(message).at(row.field(field)).remedy(remedy));
            used[field] = true;
            if is_renamed {
                used.iter_mut().zip(titles).for_each(|(used, title)| *used |= NUMBERED.contains(&title.as_str()));
            }
        }
        if let Some((names, declare)) = undeclared {
            let declared = match wanted == VECTOR {
                true => "how is not declared".to_owned(),
                false => format!("the declared one has the columns {}", wanted.join(", ")),
            };
            let message = format!("the columns {} hold an orientation, and {declared}", names.join(", "));
            self.undeclared = names;
            let field = called.iter().position(|title| title == names[0]).map(|field| row.field(field));
            let remedy = match layout.dialect.of_campaign {
                true => format!("declare {declare}"),
                false => by_option(declare),
            };
            self.faults.push(Diagnostic::error(message).at(field).remedy(remedy));
            used.iter_mut().zip(&called).for_each(|(used, title)| *used = names.contains(&title.as_str()));
        }
        let unclear = if undeclared.is_some() || clash { wanted } else { &[] };
        Written { is_numbered, unclear }
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
            let is_component = NUMBERED.iter().all(|name| titles.iter().any(|title| title == name));
            self.faults.push(diagnostic.remedy(if is_component && NUMBERED.contains(&title.as_str()) {
                "joints are called so: name the components of the quaternion qx, qy, qz and qw in the file, and declare `orientation: {quaternion: ..}`"
            } else {
                "rename or remove one of the two"
            }));
        } else if !used {
            let free = layout.expected.iter().map(|column| column.name.as_str());
            let free = free.filter(|name| self.columns.iter().all(|column| column.name != *name));
            let meant = synonym(title).filter(|meant| free.clone().any(|name| name == *meant));
            let second = second_way(titles, title, layout.dialect.orientation);
            // Of single letters no other is a misspelling: a longer name is another column.
            let bare = without_unit(title);
            let same = free.clone().find(|ours| *ours == bare);
            let alike = same
                .or_else(|| nearest(title, free))
                .filter(|ours| title.chars().count() > 1 || ours.chars().count() == 1);
            let remedy = match (meant.or(alike), layout.dialect.of_campaign) {
                (_, true) if second.is_some() => second.unwrap_or_default(),
                (Some(ours), true) => format!(
                    "if it is `{ours}`, add `columns: {{{ours}: {}}}`; else list it under `ignore:`, or rename it under `columns:`",
                    scalar(title)
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

/// Whether each of these stands twice.
fn twice(titles: &[String], names: &[&str]) -> bool {
    names.iter().all(|name| titles.iter().filter(|title| title == name).count() > 1)
}

/// What to do about a column of an orientation that the file writes in two ways.
fn second_way(titles: &[String], title: &str, declared: Orientation) -> Option<String> {
    let (names, declare) = also_written(titles, title)?;
    let ours = declared.columns();
    let has_ours = ours.iter().all(|name| titles.iter().any(|title| title == name));
    has_ours.then(|| {
        let (names, ours) = (names.join(", "), ours.join(", "));
        format!("the orientation is read from {ours}: list {names} under `ignore:`; or {declare} and list {ours} there")
    })
}

/// Why the header line is no line of text.
fn not_text(row: &Row) -> Option<Diagnostic> {
    // How a ZIP archive begins, which a workbook is; and how one of the older kind does.
    if row.bytes.starts_with(b"PK\x03\x04") || row.bytes.starts_with(b"\xd0\xcf\x11\xe0") {
        let diagnostic = Diagnostic::error("the file is a workbook or an archive, and no text");
        let remedy = "save it with the ending .xlsx, which is read; or export the sheet as CSV";
        return Some(diagnostic.at(Place::line_of(row.file, 1)).remedy(remedy));
    }
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
fn no_header(row: &Row, titles: &[String], own: Option<char>, layout: &Layout) -> Option<Diagnostic> {
    if let [only] = titles
        && let Some(other) = [b';', b'\t', b',']
            .into_iter()
            .find(|&other| Delimiter::Byte(other) != row.writing.delimiter && only.as_bytes().contains(&other))
    {
        let at = row.bytes.iter().position(|&byte| byte == other).unwrap_or_default();
        let found = Delimiter::Byte(other).shown();
        let diagnostic = Diagnostic::error(format!("the header is one column; is `{found}` the delimiter?"));
        return Some(diagnostic.at(row.place(at..at + 1)).remedy(if own.is_some() {
            "correct the first line, `sep=..`".to_owned()
        } else if layout.dialect.of_campaign {
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
            let declare = match of_campaign {
                true => format!(" or add `columns: {{{name}: {}}}`", scalar(near)),
                false => String::new(),
            };
            let units = match without_unit(near) == near {
                false if of_campaign => "; its unit is what `units:` declares",
                _ => "",
            };
            diagnostic.remedy(format!("if it is `{near}`, rename it{declare}{units}"))
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

/// What to declare where a missing column stands there with the word before it that says which of several it is.
fn declared_otherwise(name: &str, titles: &[String], layout: &Layout) -> Option<String> {
    if !layout.dialect.of_campaign {
        return None;
    }
    let before = |sign: char| titles.iter().filter_map(move |title| title.strip_suffix(name)?.strip_suffix(sign));
    let sources: Vec<&str> = before('.').filter(|source| ["commanded", "recorded"].contains(source)).collect();
    if let Some(first) = sources.first() {
        let found = sources.iter().map(|source| format!("`{source}.{name}`")).collect::<Vec<_>>().join(" and ");
        return Some(format!("the file has {found}: declare which the model uses, as in `joints: {first}`"));
    }
    let is_joint = layout.expects(&format!("commanded.{name}"));
    let markers: Vec<&str> = before('_').filter(|marker| !marker.is_empty() && !is_joint).collect();
    (!markers.is_empty()).then(|| {
        let markers = markers.join(", ");
        format!("where a row holds the readings of several markers, name these: `measurements: {{file: .., markers: [{markers}]}}`")
    })
}

/// What declares an orientation in a campaign, as the option of a command that reads a path.
fn by_option(declare: &str) -> String {
    let option =
        declare.replace("{quaternion: ", "quaternion-").replace("}`", "`").replace("`orientation: ", "`--orientation ");
    format!("say {option}, or convert it into rotation vectors rx, ry, rz")
}

/// The fault of a line that is no header, with the comment before it as the remedy where that names columns.
fn with_comment<R: Read>(fault: Diagnostic, source: &Source<R>, row: &Row, layout: &Layout) -> Diagnostic {
    let Some((comment, line)) = source.comment_before(row.line) else { return fault };
    let text = String::from_utf8_lossy(comment);
    let words = text.trim().trim_start_matches(['#', '/']).split([',', ';', '\t', ' ']);
    if !words.into_iter().any(|word| layout.names(unquoted(word))) {
        return fault;
    }
    let place = Row { file: row.file, bytes: comment, line, writing: row.writing }.fields_from(0);
    let fault = fault.related(Some(place), "a comment");
    fault.remedy("if that comment names the columns, remove its mark; else start the file with a header line")
}
