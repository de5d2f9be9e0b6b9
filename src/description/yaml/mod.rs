//! YAML texts: read with every fault located, and written back.
//!
//! The only module that knows the YAML crate. A text is walked twice: once for the place of each key and value
//! ([`Document`]), once for the typed value ([`read`]). Where the typed reading stumbles, the entry at fault is blanked out
//! and the text read again, so that one run finds all the faults.

mod index;
mod wording;

use crate::diagnostic::{Diagnostic, Place};
use index::{Index, Kind, MOST_VALUES};
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::ops::Range;
use wording::{About, Fault, starts_at};

/// What is said of a text that holds nothing.
pub const EMPTY: &str = "the file is empty";
/// Most faults shown of one text.
const MOST_FAULTS: usize = 100;
/// A text longer than this (bytes) is read until its first fault only.
const LONG_TEXT: usize = 1 << 20;
/// Most bytes read again in search of further faults.
const MOST_READ: usize = 32 << 20;

/// A parsed text that can say where each path stands.
///
/// A path holds the keys from the top of the file; elements of a list are `"0"`, `"1"`, ... Aliases and merge keys are seen
/// through.
#[derive(Debug, Clone, Default)]
pub struct Document {
    name: String,
    text: String,
    /// Where each line starts.
    lines: Vec<usize>,
    index: Index,
    blanked: Vec<usize>,
}

impl Document {
    /// Display name of the file.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Whether the text holds a value at `path`, sound or not.
    pub fn has(&self, path: &[&str]) -> bool {
        self.index.find(path).is_some()
    }

    /// Whether the value at `path` was set aside as faulty, itself or as a part of something: it is in the text, but
    /// not in the value that [`read`] returns.
    pub fn is_faulty(&self, path: &[&str]) -> bool {
        let mut at = self.index.find(path);
        while let Some(node) = at {
            if self.blanked.contains(&node) {
                return true;
            }
            at = self.index.nodes.get(node).and_then(|node| node.parent);
        }
        false
    }

    /// Whether something at `path`, around it or within it was set aside as faulty.
    pub fn holds_fault(&self, path: &[&str]) -> bool {
        let Some(holder) = self.index.find(path) else { return self.explains_absence(path) };
        let within = |mut at: usize| loop {
            if at == holder {
                break true;
            }
            match self.index.nodes.get(at).and_then(|node| node.parent) {
                Some(parent) => at = parent,
                None => break false,
            }
        };
        self.is_faulty(path) || self.blanked.iter().any(|&node| within(node))
    }

    /// Whether the absence of `path` may be no more than the echo of a fault already told: the value itself was set
    /// aside, or an entry beside it whose key reads like a misspelling of it.
    pub fn explains_absence(&self, path: &[&str]) -> bool {
        if self.is_faulty(path) {
            return true;
        }
        let Some((wanted, around)) = path.split_last() else { return false };
        if self.is_faulty(around) {
            return true;
        }
        let Some(parent) = self.index.find(around) else { return false };
        self.blanked.iter().any(|&gone| {
            let Some(node) = self.index.nodes.get(gone).filter(|node| node.parent == Some(parent)) else {
                return false;
            };
            // A second entry of the same key stands in for nothing.
            let mut path = around.to_vec();
            path.push(&node.name);
            self.index.find(&path) == Some(gone) && crate::diagnostic::nearest(&node.name, [*wanted]).is_some()
        })
    }

    /// Where the value at `path` stands; if there is none, the key of its nearest existing ancestor.
    ///
    /// `None` only when nothing of the text could be parsed.
    pub fn place_of_value(&self, path: &[&str]) -> Option<Place> {
        let (node, rest) = self.index.nearest(path)?;
        let value = self.index.nodes.get(node)?;
        match &value.key {
            Some(key) if !rest.is_empty() || value.value.start <= key.end => self.place(key.clone()),
            _ => self.place(value.value.clone()),
        }
    }

    /// Where the key at `path` stands (for an element of a list, the element); if there is none, the key of its nearest
    /// existing ancestor.
    ///
    /// `None` only when nothing of the text could be parsed.
    pub fn place_of_key(&self, path: &[&str]) -> Option<Place> {
        let (node, _) = self.index.nearest(path)?;
        let node = self.index.nodes.get(node)?;
        self.place(node.key.clone().unwrap_or_else(|| node.value.clone()))
    }

    fn place(&self, at: Range<usize>) -> Option<Place> {
        let line = self.lines.partition_point(|&start| start <= at.start).checked_sub(1)?;
        let start = *self.lines.get(line)?;
        let end = self.lines.get(line + 1).copied().unwrap_or(self.text.len());
        let text = self.text.get(start..end)?.trim_end_matches(['\n', '\r']);
        Some(Place::on_line(&self.name, line + 1, text, at.start - start..at.end.saturating_sub(start)))
    }
}

/// The text of a file: UTF-8, with or without a byte-order mark.
///
/// # Errors
///
/// A located diagnostic when the bytes are not UTF-8 (with the remedy when they are UTF-16) or hold a NUL.
pub fn text_of(name: &str, bytes: &[u8]) -> Result<String, Diagnostic> {
    let start = Place { file: name.to_owned(), line: 1, column: 1, excerpt: String::new(), highlight: 0..0 };
    let wide = bytes.starts_with(&[0xff, 0xfe]) || bytes.starts_with(&[0xfe, 0xff]);
    let wide = wide || (bytes.len() > 1 && (bytes.starts_with(&[0]) || bytes.get(1) == Some(&0)));
    if wide {
        let diagnostic = Diagnostic::error("the file is in UTF-16, expected UTF-8").at(start);
        return Err(diagnostic.remedy("save it as UTF-8"));
    }
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let bad = match std::str::from_utf8(bytes) {
        Ok(text) => match text.find('\0') {
            None => return Ok(text.to_owned()),
            Some(at) => (at, 1, "a NUL byte stands here; the file is not a text".to_owned()),
        },
        Err(error) => {
            let at = error.valid_up_to();
            let byte = bytes.get(at).copied().unwrap_or_default();
            (at, error.error_len().unwrap_or(1), format!("the byte 0x{byte:02x} is not UTF-8"))
        }
    };
    let (at, length, message) = bad;
    let (before, after) = bytes.split_at(at.min(bytes.len()));
    let mut text = String::from_utf8_lossy(before).into_owned();
    let highlight = text.len();
    let line_end = after.iter().skip(length).position(|&byte| byte == b'\n').map_or(after.len(), |end| end + length);
    text.push_str(&String::from_utf8_lossy(after.get(..line_end.min(4096)).unwrap_or(after)));
    let mark = text.get(highlight..).and_then(|rest| rest.chars().next()).map_or(0, char::len_utf8);
    let diagnostic = Diagnostic::error(message).at(Place::in_text(name, &text, highlight..highlight + mark));
    Err(diagnostic.remedy("save the file as UTF-8"))
}

/// Reads a `T`, with every structural fault of the text.
///
/// The value is what the text says apart from the entries at fault, so that further checks can run in the same go; it must
/// not be used when the diagnostics hold an error. It is `None` when nothing sound remains. For the faults not to cascade, each
/// field of `T` is optional or has a default.
pub fn read<T: DeserializeOwned>(name: &str, text: &str) -> (Option<T>, Document, Vec<Diagnostic>) {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let starts = std::iter::once(0).chain(text.match_indices('\n').map(|(at, _)| at + 1));
    let lines = starts.collect();
    let mut document = Document { name: name.to_owned(), text: text.to_owned(), lines, ..Document::default() };
    let duplicates = match Index::of(name, text) {
        Ok((index, duplicates)) => {
            document.index = index;
            duplicates
        }
        Err(diagnostic) => return (None, document, vec![diagnostic]),
    };
    if let Some(node) = document.index.bomb() {
        let place = document.index.nodes.get(node).and_then(|node| document.place(node.extent()));
        let diagnostic =
            Diagnostic::error(format!("with its aliases written out, the file holds more than {MOST_VALUES} values"));
        return (None, document, vec![diagnostic.at(place).remedy("repeat less through aliases")]);
    }
    let mut search = Search { text: text.to_owned(), document, diagnostics: Vec::new(), read: 0, stopped: false };
    for (node, diagnostic) in duplicates {
        search.blank(node);
        search.diagnostics.push(diagnostic);
    }
    let value = search.run();
    search.finish();
    (value, search.document, search.diagnostics)
}

/// Writes a value as YAML, so that [`read`] gives it back: floats in their shortest exact form, texts quoted where needed.
///
/// # Errors
///
/// The words of the value's own `Serialize`, when it fails.
pub fn write<T: Serialize>(value: &T) -> Result<String, String> {
    serde_yaml::to_string(value).map_err(|error| error.to_string())
}

/// One typed reading.
fn parse<T: DeserializeOwned>(text: &str) -> Result<T, Box<serde_yaml::Error>> {
    let budget = serde_yaml::budget! {
        max_depth: index::DEEPEST,
        max_nodes: 2 * MOST_VALUES,
        max_events: 4 * MOST_VALUES,
        max_aliases: MOST_VALUES,
        max_anchors: MOST_VALUES,
        enforce_alias_anchor_ratio: false,
    };
    let options = serde_yaml::options! {
        budget: budget,
        strict_booleans: true,
        reject_unsupported_tags: true,
        non_finite_float_policy: serde_yaml::options::NonFiniteFloatPolicy::PassThrough,
        with_snippet: false,
    };
    serde_yaml::from_str_with_options(text, options).map_err(Box::new)
}

/// The search for every fault of a text.
struct Search {
    /// The text, with what is at fault blanked out byte by byte.
    text: String,
    document: Document,
    diagnostics: Vec<Diagnostic>,
    /// Bytes read so far.
    read: usize,
    /// Whether the search was given up before its end.
    stopped: bool,
}

impl Search {
    fn run<T: DeserializeOwned>(&mut self) -> Option<T> {
        let mut outcome = self.parse();
        loop {
            let fault = match outcome {
                Ok(value) => return Some(value),
                Err(fault) => fault,
            };
            if !self.follows(&fault) {
                self.diagnostics.push(fault.diagnostic.clone());
            }
            if fault.about == About::Text {
                return None;
            }
            if self.spent() {
                self.stopped = true;
                return None;
            }
            outcome = self.read_on(&fault)?;
        }
    }

    fn parse<T: DeserializeOwned>(&mut self) -> Result<T, Fault> {
        self.read += self.text.len();
        let document = &self.document;
        parse(&self.text).map_err(|error| wording::fault(&document.name, &document.text, &document.index, &error))
    }

    fn spent(&self) -> bool {
        let long = self.text.len() > LONG_TEXT;
        self.diagnostics.len() >= MOST_FAULTS || self.read > MOST_READ || (long && !self.diagnostics.is_empty())
    }

    /// Blanks the least that gets past the fault and reads again; `None` when nothing does.
    fn read_on<T: DeserializeOwned>(&mut self, fault: &Fault) -> Option<Result<T, Fault>> {
        for node in self.suspects(fault) {
            let before = (self.text.clone(), self.document.blanked.clone());
            self.blank(node);
            if self.text == before.0 || self.text.trim().is_empty() {
                (self.text, self.document.blanked) = before;
                continue;
            }
            let outcome = self.parse();
            let stuck = match &outcome {
                Ok(_) => false,
                Err(next) => next.about == About::Text || (next.at, &next.diagnostic) == (fault.at, &fault.diagnostic),
            };
            if !stuck {
                return Some(outcome);
            }
            (self.text, self.document.blanked) = before;
            if self.read > MOST_READ {
                self.stopped = true;
                break;
            }
        }
        None
    }

    /// The entries whose absence may mend a fault, the smallest first.
    fn suspects(&self, fault: &Fault) -> Vec<usize> {
        let nodes = &self.document.index.nodes;
        let keyed = nodes.iter().position(|node| starts_at(node, fault.at));
        let whole =
            |node: &index::Node| node.value.start == fault.at && matches!(node.kind, Kind::Mapping | Kind::Sequence);
        let owner = nodes.iter().position(|node| whole(node) && node.parent.is_some());
        let within = nodes.iter().rposition(|node| {
            let extent = node.extent();
            node.key.is_some() && (extent.contains(&fault.at) || extent.end == fault.at && extent.is_empty())
        });
        let null = nodes.iter().position(|node| node.value.start == fault.at && node.key.is_some());
        let first = match fault.about {
            About::Key => [keyed, within],
            About::Whole => [owner.or_else(|| keyed.and_then(|node| nodes.get(node)?.parent)), keyed],
            About::Value | About::Text => [owner.or(null), within],
        };
        let mut suspects = Vec::new();
        for start in first.into_iter().flatten().chain(keyed).chain(within) {
            let mut at = Some(start);
            while let Some(number) = at {
                let Some(node) = nodes.get(number) else { break };
                if node.key.is_some() && !suspects.contains(&number) {
                    suspects.push(number);
                }
                at = node.parent;
            }
        }
        suspects.sort_by_key(|&node| {
            let head = first.iter().flatten().position(|&first| first == node).unwrap_or(2);
            (head, nodes.get(node).map_or(0, |node| node.extent().len()))
        });
        suspects
    }

    /// Whether a fault is only there because of what has been blanked.
    fn follows(&self, fault: &Fault) -> bool {
        let nodes = &self.document.index.nodes;
        let around = wording::innermost(&self.document.index, fault.at);
        self.document.blanked.iter().filter_map(|&node| nodes.get(node)).any(|gone| {
            let Some(parent) = gone.parent else { return false };
            let at_parent =
                nodes.get(parent).is_some_and(|node| node.value.start == fault.at || starts_at(node, fault.at));
            match fault.missing {
                Some(field) => at_parent && gone.name == field,
                None => fault.about == About::Whole && (at_parent || around == Some(parent)),
            }
        })
    }

    /// Overwrites an entry with spaces, its comma too, keeping line breaks.
    fn blank(&mut self, node: usize) {
        let Some(entry) = self.document.index.nodes.get(node) else { return };
        let mut extent = entry.extent();
        if entry.flow {
            let after = self.text.get(extent.end..).unwrap_or_default();
            let blanks = after.len() - after.trim_start().len();
            if after.get(blanks..).is_some_and(|rest| rest.starts_with(',')) {
                extent.end += blanks + 1;
            }
        }
        let keep = |byte: u8| if byte == b'\n' || byte == b'\r' { byte } else { b' ' };
        let bytes = self.text.bytes().enumerate();
        let blanked = bytes.map(|(at, byte)| if extent.contains(&at) { keep(byte) } else { byte }).collect();
        // Extents lie on character boundaries, so the text stays UTF-8; were they not to, nothing is blanked.
        if let Ok(text) = String::from_utf8(blanked) {
            self.text = text;
            self.document.blanked.push(node);
        }
    }

    /// Puts the diagnostics in the order of the text, and says when there may be more.
    fn finish(&mut self) {
        let position = |diagnostic: &Diagnostic| diagnostic.place.as_ref().map(|place| (place.line, place.column));
        self.diagnostics.sort_by_key(position);
        if self.stopped || self.diagnostics.len() > MOST_FAULTS {
            self.diagnostics.truncate(MOST_FAULTS);
            let place = self.diagnostics.last().and_then(|diagnostic| diagnostic.place.clone());
            self.diagnostics.push(Diagnostic::warning("the search stopped here: there may be more faults").at(place));
        }
    }
}
