//! A located diagnostic, as data: what is wrong, where, what was expected and how to mend it.
//!
//! Readers collect every diagnostic of a file instead of stopping at the first; `render::diagnostics` words and draws them.

use std::ops::Range;

/// How grave a [`Diagnostic`] is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// Worth knowing; the file is still usable.
    Warning,
    /// The file cannot be used.
    Error,
}

/// A stretch of a file, with the lines around it, so that it can be shown without the file.
#[derive(Debug, Clone, PartialEq, Eq)]
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
}

/// Lines longer than this many characters are cut around their highlight.
const LONGEST_LINE: usize = 200;

impl Place {
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
        Self { file: file.to_owned(), line, column, excerpt, highlight }
    }
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

/// One diagnostic about an input.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Diagnostic {
    /// How grave it is.
    pub severity: Severity,
    /// What is wrong, with the value found and the rule it breaks.
    pub message: String,
    /// Where; `None` when it concerns the whole input or a flag.
    pub place: Option<Place>,
    /// Other places that matter (the first of two definitions), each with a word on why.
    pub related: Vec<(Place, String)>,
    /// What to do about it.
    pub remedy: Option<String>,
}

impl Diagnostic {
    /// An error without a place; see [`Diagnostic::at`] and [`Diagnostic::remedy`].
    pub fn error(message: impl Into<String>) -> Self {
        Self { severity: Severity::Error, message: message.into(), place: None, related: Vec::new(), remedy: None }
    }

    /// A warning without a place.
    pub fn warning(message: impl Into<String>) -> Self {
        Self { severity: Severity::Warning, ..Self::error(message) }
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

    /// Adds "did you mean ...?" when one of `valid` is near `found`, else lists what is valid.
    #[must_use]
    pub fn suggest<'a>(self, found: &str, valid: impl IntoIterator<Item = &'a str>) -> Self {
        let valid: Vec<&str> = valid.into_iter().collect();
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

/// Everything found wrong with an input, as one error: what readers of descriptions, campaigns and tables return.
///
/// It derefs to the slice of its [`Diagnostic`]s. [`std::fmt::Display`] gives each as one line with its file, line and column
/// and a line of help; the feature `cli` draws them with the lines of the file (`render::diagnostics`).
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Diagnostics(pub Vec<Diagnostic>);

impl std::fmt::Display for Diagnostics {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        for (k, diagnostic) in self.0.iter().enumerate() {
            if k > 0 {
                writeln!(f)?;
            }
            if let Some(place) = &diagnostic.place {
                write!(f, "{}:{}:{}: ", place.file, place.line, place.column)?;
            }
            let severity = if diagnostic.is_error() { "error" } else { "warning" };
            write!(f, "{severity}: {}", diagnostic.message)?;
            if let Some(remedy) = &diagnostic.remedy {
                write!(f, "\n  help: {remedy}")?;
            }
        }
        Ok(())
    }
}

impl std::error::Error for Diagnostics {}

impl From<Vec<Diagnostic>> for Diagnostics {
    fn from(all: Vec<Diagnostic>) -> Self {
        Self(all)
    }
}

impl From<Diagnostic> for Diagnostics {
    fn from(one: Diagnostic) -> Self {
        Self(vec![one])
    }
}

impl std::ops::Deref for Diagnostics {
    type Target = [Diagnostic];

    fn deref(&self) -> &[Diagnostic] {
        &self.0
    }
}

impl IntoIterator for Diagnostics {
    type Item = Diagnostic;
    type IntoIter = std::vec::IntoIter<Diagnostic>;

    fn into_iter(self) -> Self::IntoIter {
        self.0.into_iter()
    }
}

/// The valid name most like `found`, if any is like it at all; two names of which every letter differs never are.
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
