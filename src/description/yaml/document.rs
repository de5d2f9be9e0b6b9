//! A text and where each of its paths stands.

use std::ops::Range;

use super::index::Index;
use crate::diagnostic::{Diagnostic, Place};

/// A parsed text that can say where each path stands.
///
/// A path holds the keys from the top of the file; elements of a list are `"0"`, `"1"`, ... Aliases and merge keys are seen
/// through.
#[derive(Debug, Clone, Default)]
pub struct Document {
    pub(super) name: String,
    pub(super) text: String,
    /// Where each line starts.
    lines: Vec<usize>,
    pub(super) index: Index,
    /// Nodes that were left out as faulty.
    pub(super) blanked: Vec<usize>,
}

impl Document {
    /// A text of which nothing is known yet.
    pub(super) fn new(name: &str, text: &str) -> Self {
        let lines = std::iter::once(0).chain(text.match_indices('\n').map(|(at, _)| at + 1)).collect();
        Self { name: name.to_owned(), text: text.to_owned(), lines, ..Self::default() }
    }

    /// Display name of the file.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Whether the text holds a value at `path`, sound or not.
    pub fn has(&self, path: &[&str]) -> bool {
        self.index.find(path).is_some()
    }

    /// Whether the value at `path` was left out as faulty, itself or as a part of something: it is in the text, but
    /// not in the value that [`super::read`] returns.
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

    /// Whether something at `path`, around it or within it was left out as faulty.
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

    /// Whether the absence of `path` may be no more than the consequence of a fault already reported: the value itself was
    /// left out, or an entry next to it whose key reads like a misspelling of it.
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

    pub(super) fn place(&self, at: Range<usize>) -> Option<Place> {
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
    let start = Place::line_of(name, 1);
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
