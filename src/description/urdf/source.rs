//! The text of a URDF: its XML, the places in it, and what has been found wrong with it.

use std::ops::Range;

use roxmltree::{Document, Error, Node, ParsingOptions};

use crate::diagnostic::{Diagnostic, Place};

/// Largest file read, bytes.
const LARGEST: usize = 20_000_000;
/// Longest tag, bytes; a robot needs a few hundred. The XML reader takes a time that grows with the square of a tag's attributes.
const LONGEST_TAG: usize = 8_192;
/// Most elements, texts and comments.
const MOST_NODES: u32 = 2_000_000;
/// Errors shown of one file, and warnings; of errors the others are counted.
const MOST: usize = 100;

/// A file's text, and the diagnostics on it so far.
pub(super) struct Source<'a> {
    file: &'a str,
    text: &'a str,
    /// Bytes before the first that is XML: a byte order mark, blank lines.
    skipped: usize,
    /// Where each line starts.
    lines: Vec<usize>,
    errors: Vec<Diagnostic>,
    error_count: usize,
    warnings: Vec<Diagnostic>,
}

impl<'a> Source<'a> {
    pub(super) fn new(file: &'a str, text: &'a str) -> Self {
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        let lines = std::iter::once(0).chain(text.match_indices('\n').map(|(at, _)| at + 1)).collect();
        let skipped = text.len() - text.trim_start().len();
        Self { file, text, skipped, lines, errors: Vec::new(), error_count: 0, warnings: Vec::new() }
    }

    /// The text from its first element or declaration: what ranges count from.
    pub(super) fn xml(&self) -> &'a str {
        self.text.get(self.skipped..).unwrap_or("")
    }

    /// Reads the XML; `None` after an error.
    pub(super) fn parse(&mut self) -> Option<Document<'a>> {
        if self.text.len() > LARGEST {
            let found = self.text.len() as f64 / 1e6;
            let message = format!("the file holds {found:.1} MB; a URDF of at most {} MB is read", LARGEST / 1_000_000);
            self.report(|_| Diagnostic::error(message).remedy("leave meshes in files of their own"));
            return None;
        }
        let xml = self.xml();
        let mut at = 0;
        for piece in xml.split_inclusive('<') {
            let tag = piece.find('>').unwrap_or(piece.len());
            if tag > LONGEST_TAG && !piece.starts_with(['!', '?']) && at > 0 {
                let message = format!(
                    "a tag of {tag} bytes (too many attributes, or not closed); at most {LONGEST_TAG} are read"
                );
                self.error(at - 1..at, message, "");
                return None;
            }
            at += piece.len();
        }
        let options = ParsingOptions { nodes_limit: MOST_NODES, ..ParsingOptions::default() };
        Document::parse_with_options(xml, options).map_err(|error| self.malformed(&error)).ok()
    }

    fn malformed(&mut self, error: &Error) {
        let at = (!matches!(error, Error::NoRootNode | Error::DtdDetected | Error::NodesLimitReached)).then(|| {
            // Rows and columns count from 1, columns in characters.
            let row = error.pos().row as usize - 1 + self.lines.partition_point(|&line| line <= self.skipped) - 1;
            let start = self.lines.get(row).copied().unwrap_or(self.text.len()).max(self.skipped);
            let mut ahead = self.text.get(start..).unwrap_or("").char_indices().skip(error.pos().col as usize - 1);
            let at = start + ahead.next().map_or(self.text.len() - start, |(at, _)| at);
            at - self.skipped..ahead.next().map_or(self.text.len(), |(at, _)| start + at) - self.skipped
        });
        if let (Error::UnknownNamespace(prefix, _), Some(at)) = (error, &at)
            && prefix == "xacro"
        {
            return self.xacro(at.clone());
        }
        let reason = error.to_string();
        let reason = reason.strip_suffix(&format!(" at {}", error.pos())).unwrap_or(&reason);
        let message = format!("this is not well-formed XML: {reason}");
        let remedy = "give a URDF: an XML file whose root is `<robot name=\"..\">`";
        self.report(|source| Diagnostic::error(message).at(at.map(|at| source.place(at))).remedy(remedy));
    }

    pub(super) fn xacro(&mut self, at: Range<usize>) {
        let name = self.file.rsplit(['/', '\\']).next().unwrap_or(self.file);
        let stem = name.trim_end_matches(".xacro").trim_end_matches(".urdf");
        let from = if name.ends_with(".xacro") { name.to_owned() } else { format!("{stem}.xacro") };
        let remedy = format!("run xacro first, and give what it writes: `xacro {from} > {stem}.urdf`");
        self.error(at, "this is a xacro file, not yet a URDF", remedy);
    }

    /// The place of these bytes of the XML; of several lines the first is shown.
    pub(super) fn place(&self, at: Range<usize>) -> Place {
        let (start, end) = (at.start + self.skipped, at.end + self.skipped);
        let line = self.lines.partition_point(|&first| first <= start).max(1);
        let first = self.lines.get(line - 1).copied().unwrap_or(0);
        let whole = self.text.get(first..).unwrap_or("").split('\n').next().unwrap_or("");
        let whole = whole.strip_suffix('\r').unwrap_or(whole);
        Place::on_line(self.file, line, whole, start - first..end.min(first + whole.len()).saturating_sub(first))
    }

    /// An error about these bytes; no remedy where it is empty.
    pub(super) fn error(&mut self, at: Range<usize>, message: impl Into<String>, remedy: impl Into<String>) {
        self.report(|source| remedied(Diagnostic::error(message), remedy.into()).at(source.place(at)));
    }

    /// An error that is made only where it will be shown.
    pub(super) fn report(&mut self, make: impl FnOnce(&Self) -> Diagnostic) {
        self.error_count += 1;
        if self.errors.len() < MOST {
            let diagnostic = make(self);
            self.errors.push(diagnostic);
        }
    }

    pub(super) fn warn(&mut self, at: Range<usize>, message: impl Into<String>, remedy: impl Into<String>) {
        self.doubt(|source| remedied(Diagnostic::warning(message), remedy.into()).at(source.place(at)));
    }

    /// A warning that is made only where it will be shown.
    pub(super) fn doubt(&mut self, make: impl FnOnce(&Self) -> Diagnostic) {
        if self.warnings.len() < MOST {
            let diagnostic = make(self);
            self.warnings.push(diagnostic);
        }
    }

    /// How many errors there are.
    pub(super) fn count(&self) -> usize {
        self.error_count
    }

    /// All diagnostics, errors first, and how many more of them there were.
    pub(super) fn finish(self) -> Vec<Diagnostic> {
        let more = self.error_count - self.errors.len();
        let more = (more > 0).then(|| Diagnostic::error(format!("{more} more errors are not shown")));
        self.errors.into_iter().chain(more).chain(self.warnings).collect()
    }
}

fn remedied(diagnostic: Diagnostic, remedy: String) -> Diagnostic {
    if remedy.is_empty() { diagnostic } else { diagnostic.remedy(remedy) }
}

/// The bracket and the name of an opening tag.
pub(super) fn tag(node: Node) -> Range<usize> {
    let at = node.range();
    let text = node.document().input_text().get(at.clone()).unwrap_or("");
    let length = text.find(|c: char| c.is_whitespace() || c == '/' || c == '>').unwrap_or(text.len());
    at.start..at.start + length
}
