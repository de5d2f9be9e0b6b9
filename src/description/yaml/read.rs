//! A typed value from a text, with every fault found: where the typed reading stumbles, the entry at fault is blanked out
//! and the text read again.

use serde::de::DeserializeOwned;

use super::document::Document;
use super::index::{Index, Kind, MOST_VALUES, Node};
use super::syntax::DEEPEST;
use super::wording::{self, About, Fault, starts_at};
use crate::diagnostic::Diagnostic;

/// Most faults shown of one text.
const MOST_FAULTS: usize = 100;
/// A text longer than this (bytes) is read until its first fault only.
const LONG_TEXT: usize = 1 << 20;
/// Most bytes read again in search of further faults.
const MOST_READ: usize = 32 << 20;

/// Reads a `T`, with every structural fault of the text.
///
/// The value is what the text says apart from the entries at fault, so that further checks can run in the same go; it must
/// not be used when the diagnostics hold an error. It is `None` when nothing sound remains. For the faults not to cascade, each
/// field of `T` is optional or has a default.
pub fn read<T: DeserializeOwned>(name: &str, text: &str) -> (Option<T>, Document, Vec<Diagnostic>) {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let mut document = Document::new(name, text);
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

/// One typed reading.
fn parse<T: DeserializeOwned>(text: &str) -> Result<T, Box<serde_yaml::Error>> {
    let budget = serde_yaml::budget! {
        max_depth: DEEPEST,
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
        let whole = |node: &Node| node.value.start == fault.at && matches!(node.kind, Kind::Mapping | Kind::Sequence);
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
