//! A located diagnostic, as data: what is wrong, where, what was expected and how to mend it.
//!
//! Readers collect every diagnostic of a file instead of stopping at the first. [`Diagnostics`] is the error type of
//! everything that reads files, so that `?` works in a program; `render::diagnostics` draws them for a terminal. The
//! model is that of compilers (`rustc`'s JSON messages: code, severity, spans, children).

mod code;

pub use code::{Code, Severity};

use std::collections::BTreeMap;
use std::fmt;
use std::ops::{Deref, Range};

use serde::Serialize;

/// A stretch of a file, with the lines around it, so that it can be shown without the file.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Place {
    /// Display name of the file.
    pub file: String,
    /// Line of the first highlighted character, counted from 1.
    pub line: usize,
    /// Column of the first highlighted character, in characters, counted from 1.
    pub column: usize,
    /// The whole line or lines that hold the stretch; a very long line is cut around it. Empty if unknown.
    pub excerpt: String,
    /// Bytes of `excerpt` that are meant.
    pub highlight: Range<usize>,
    /// Whether it is a cell of a workbook: `line` is then the sheet's row, and `column` its column, both counted from 1.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub in_sheet: bool,
}

/// Lines longer than this many characters are cut around their highlight.
const LONGEST_LINE: usize = 200;

impl Place {
    /// A line of a file that cannot be shown.
    pub fn line_of(file: &str, line: usize) -> Self {
        Self { file: file.to_owned(), line, column: 1, excerpt: String::new(), highlight: 0..0, in_sheet: false }
    }

    /// The stretch `highlight` (bytes) of `text`, cut off at the end of its first line.
    ///
    /// A range that is out of the text, or within a character, is moved to the nearest boundary.
    pub fn in_text(file: &str, text: &str, highlight: Range<usize>) -> Self {
        let start = floor(text, highlight.start);
        let before = text.get(..start).unwrap_or_default();
        let line_start = before.rfind('\n').map_or(0, |at| at + 1);
        let line = 1 + before.bytes().filter(|&byte| byte == b'\n').count();
        let rest = text.get(line_start..).unwrap_or_default();
        let whole = rest.split('\n').next().unwrap_or_default();
        let whole = whole.strip_suffix('\r').unwrap_or(whole);
        Self::on_line(file, line, whole, start - line_start..highlight.end.saturating_sub(line_start))
    }

    /// The stretch `highlight` (bytes) of one line, given without its line break; `line` counts from 1.
    ///
    /// A very long line is cut around the highlight; the column stays that of the whole line.
    pub fn on_line(file: &str, line: usize, text: &str, highlight: Range<usize>) -> Self {
        let start = floor(text, highlight.start);
        let end = floor(text, highlight.end).max(start);
        let column = 1 + text.get(..start).unwrap_or_default().chars().count();
        let (excerpt, highlight) = cut(text, start..end);
        Self { file: file.to_owned(), line, column, excerpt, highlight, in_sheet: false }
    }
}

impl Place {
    /// Where it is, in one word: `robot.yaml:3:5`, or of a workbook `readings.xlsx#Sheet1!C7`.
    pub fn address(&self) -> String {
        if self.in_sheet {
            format!("{}!{}{}", self.file, letters(self.column), self.line)
        } else {
            format!("{}:{}:{}", self.file, self.line, self.column)
        }
    }
}

/// Letters of a column of a sheet, counted from 1: A, B, .., Z, AA, ..
fn letters(mut column: usize) -> String {
    let mut letters = Vec::new();
    while let Some(rest) = column.checked_sub(1) {
        letters.push(char::from(b'A' + u8::try_from(rest % 26).unwrap_or_default()));
        column = rest / 26;
    }
    letters.into_iter().rev().collect()
}

/// The character boundary at or before `at`.
fn floor(text: &str, at: usize) -> usize {
    (0..=at.min(text.len())).rev().find(|&at| text.is_char_boundary(at)).unwrap_or_default()
}

/// A line no longer than a screen shows, around its highlight (bytes on character boundaries).
pub(crate) fn cut(line: &str, highlight: Range<usize>) -> (String, Range<usize>) {
    const BEFORE: usize = 60;
    const MARK: &str = "...";
    let (before, rest) = line.split_at(floor(line, highlight.start));
    if line.len() <= LONGEST_LINE || line.chars().nth(LONGEST_LINE).is_none() {
        return (line.to_owned(), highlight);
    }
    let from = before.char_indices().rev().nth(BEFORE - 1).map_or(0, |(at, _)| at);
    let to = rest.char_indices().nth(LONGEST_LINE - BEFORE).map_or(rest.len(), |(at, _)| at);
    let mut text = if from > 0 { MARK.to_owned() } else { String::new() };
    text.push_str(before.get(from..).unwrap_or_default());
    let start = text.len();
    text.push_str(rest.get(..to).unwrap_or_default());
    let end = text.len().min(start + (highlight.end - highlight.start));
    if to < rest.len() {
        text.push_str(MARK);
    }
    (text, start..end)
}

/// Says where a path of a file stands (keys from the top, list positions as numbers).
pub type Locate<'a> = &'a dyn Fn(&[&str]) -> Option<Place>;

/// Says whether what is missing at a path of a file is missing because of a fault that has been reported already.
pub type Explained<'a> = &'a dyn Fn(&[&str]) -> bool;

/// Another place that matters for a [`Diagnostic`].
pub type Related = (Place, String);

/// One diagnostic about an input or a result. As JSON: `code`, `severity`, `message`, `remedy`, `at`, `related`, `figures`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Diagnostic {
    /// What kind of fault it is.
    pub code: Code,
    /// How grave it is.
    pub severity: Severity,
    /// What is wrong, with the value found and the rule it breaks.
    pub message: String,
    /// Where; `None` when it concerns the whole input or a flag.
    #[serde(rename = "at")]
    pub place: Option<Place>,
    /// Other places that matter (the first of two definitions), each with a word on why.
    pub related: Vec<Related>,
    /// What to do about it.
    pub remedy: Option<String>,
    /// The figures of the message, by name; the name says the unit.
    pub figures: BTreeMap<String, f64>,
}

impl Diagnostic {
    /// An error without a place; see [`Diagnostic::at`] and [`Diagnostic::remedy`].
    pub fn error(message: impl Into<String>) -> Self {
        let (code, severity, message) = (Code::Invalid, Severity::Error, message.into());
        Self { code, severity, message, place: None, related: Vec::new(), remedy: None, figures: BTreeMap::new() }
    }

    /// A warning without a place.
    pub fn warning(message: impl Into<String>) -> Self {
        Self { code: Code::Doubtful, severity: Severity::Warning, ..Self::error(message) }
    }

    /// Says what kind of fault it is, where that is neither [`Code::Invalid`] nor [`Code::Doubtful`].
    #[must_use]
    pub fn code(mut self, code: Code) -> Self {
        self.code = code;
        self
    }

    /// Adds the place.
    #[must_use]
    pub fn at(mut self, place: impl Into<Option<Place>>) -> Self {
        self.place = place.into();
        self
    }

    /// Adds another place that matters.
    #[must_use]
    pub fn related(mut self, place: Option<Place>, why: impl Into<String>) -> Self {
        self.related.extend(place.map(|place| (place, why.into())));
        self
    }

    /// Adds what to do about it.
    #[must_use]
    pub fn remedy(mut self, remedy: impl Into<String>) -> Self {
        self.remedy = Some(remedy.into());
        self
    }

    /// Adds a figure of the message; what is not finite is left out.
    #[must_use]
    pub fn figure(mut self, name: &str, value: f64) -> Self {
        if value.is_finite() {
            self.figures.insert(name.to_owned(), value);
        }
        self
    }

    /// Makes it one about an unknown name: adds "did you mean ...?" when one of `valid` is near `found`, else lists what
    /// is valid.
    #[must_use]
    pub fn suggest<'a>(mut self, found: &str, valid: impl IntoIterator<Item = &'a str>) -> Self {
        self.code = Code::Unknown;
        let mut valid: Vec<&str> = valid.into_iter().collect();
        let mut known = std::collections::HashSet::new();
        valid.retain(|name| known.insert(*name));
        match nearest(found, valid.iter().copied()) {
            Some(name) => self.remedy(format!("did you mean `{name}`?")),
            None if valid.is_empty() => self,
            None => {
                let shown: Vec<String> = valid.iter().take(12).map(|name| format!("`{name}`")).collect();
                let more = if valid.len() > 12 { ", ..." } else { "" };
                self.remedy(format!("valid here: {}{more}", shown.join(", ")))
            }
        }
    }

    /// Whether it is an error.
    pub fn is_error(&self) -> bool {
        self.severity == Severity::Error
    }
}

impl fmt::Display for Diagnostic {
    /// One line: `robot.yaml:3:5: error: message (remedy)`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(place) = &self.place {
            write!(f, "{}: ", place.address())?;
        }
        f.write_str(if self.is_error() { "error: " } else { "warning: " })?;
        f.write_str(&self.message)?;
        self.remedy.as_ref().map_or(Ok(()), |remedy| write!(f, " ({remedy})"))
    }
}

/// What reading a file reported: every fault found, in the order of reading. As an error it holds at least one
/// [`Severity::Error`].
///
/// It reads like a list of [`Diagnostic`], displays as one line each, and serialises as a JSON list.
///
/// ```
/// use elastogeo::diagnostic::{Code, Diagnostic, Diagnostics};
///
/// fn read() -> Result<(), Box<dyn std::error::Error>> {
///     let diagnostics = Diagnostics::from(Diagnostic::error("unknown frame `33`").suggest("33", ["1", "2", "3"]));
///     diagnostics.into_result()?;
///     Ok(())
/// }
///
/// let error = read().unwrap_err();
/// assert_eq!(error.to_string(), "error: unknown frame `33` (did you mean `3`?)");
/// let diagnostics = error.downcast_ref::<Diagnostics>().unwrap();
/// assert_eq!(diagnostics[0].code, Code::Unknown);
/// ```
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
#[serde(transparent)]
pub struct Diagnostics(Vec<Diagnostic>);

impl Diagnostics {
    /// No diagnostics.
    pub const fn new() -> Self {
        Self(Vec::new())
    }

    /// Adds one.
    pub fn push(&mut self, diagnostic: Diagnostic) {
        self.0.push(diagnostic);
    }

    /// Whether one of them is an error.
    pub fn has_error(&self) -> bool {
        self.0.iter().any(Diagnostic::is_error)
    }

    /// Itself as the error of a computation, if one of them is an error.
    ///
    /// # Errors
    /// All of them, if one is an error.
    pub fn into_result(self) -> Result<Self, Self> {
        if self.has_error() { Err(self) } else { Ok(self) }
    }
}

impl fmt::Display for Diagnostics {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (k, diagnostic) in self.0.iter().enumerate() {
            write!(f, "{}{diagnostic}", if k > 0 { "\n" } else { "" })?;
        }
        Ok(())
    }
}

impl std::error::Error for Diagnostics {}

impl Deref for Diagnostics {
    type Target = [Diagnostic];
    fn deref(&self) -> &[Diagnostic] {
        &self.0
    }
}

impl From<Diagnostic> for Diagnostics {
    fn from(diagnostic: Diagnostic) -> Self {
        Self(vec![diagnostic])
    }
}

impl From<Vec<Diagnostic>> for Diagnostics {
    fn from(diagnostics: Vec<Diagnostic>) -> Self {
        Self(diagnostics)
    }
}

impl From<Diagnostics> for Vec<Diagnostic> {
    fn from(diagnostics: Diagnostics) -> Self {
        diagnostics.0
    }
}

impl FromIterator<Diagnostic> for Diagnostics {
    fn from_iter<I: IntoIterator<Item = Diagnostic>>(diagnostics: I) -> Self {
        Self(diagnostics.into_iter().collect())
    }
}

impl Extend<Diagnostic> for Diagnostics {
    fn extend<I: IntoIterator<Item = Diagnostic>>(&mut self, diagnostics: I) {
        self.0.extend(diagnostics);
    }
}

impl IntoIterator for Diagnostics {
    type Item = Diagnostic;
    type IntoIter = std::vec::IntoIter<Diagnostic>;
    fn into_iter(self) -> Self::IntoIter {
        self.0.into_iter()
    }
}

impl<'a> IntoIterator for &'a Diagnostics {
    type Item = &'a Diagnostic;
    type IntoIter = std::slice::Iter<'a, Diagnostic>;
    fn into_iter(self) -> Self::IntoIter {
        self.0.iter()
    }
}

/// The valid name most like `found`, if any is like it at all; two names of which every letter differs never are.
///
/// ```
/// assert_eq!(elastogeo::diagnostic::nearest("antecdent", ["antecedent", "actuator"]), Some("antecedent"));
/// ```
pub fn nearest<'a>(found: &str, valid: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    valid
        .into_iter()
        .map(|name| (name, strsim::damerau_levenshtein(&found.to_lowercase(), &name.to_lowercase())))
        .filter(|&(name, distance)| {
            let longest = name.chars().count().max(found.chars().count());
            distance <= 1 + longest / 4 && (distance < longest || distance == 0)
        })
        .min_by_key(|&(_, distance)| distance)
        .map(|(name, _)| name)
}
