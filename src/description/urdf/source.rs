//! The text of a file, its places, and the diagnostics made on it.

use std::ops::Range;

use crate::diagnostic::{Diagnostic, Place};

/// Errors shown of one file; the others are only counted.
const MOST: usize = 100;
/// Lines longer than this many bytes are shown around the place only.
const LONG: usize = 600;

/// A file's text with the starts of its lines.
pub(super) struct Source<'a> {
    file: &'a str,
    text: &'a str,
    starts: Vec<usize>,
}

impl<'a> Source<'a> {
    pub(super) fn new(file: &'a str, text: &'a str) -> Self {
        let starts = std::iter::once(0).chain(text.match_indices('\n').map(|(at, _)| at + 1)).collect();
        Self { file, text, starts }
    }

    pub(super) fn text(&self) -> &'a str {
        self.text
    }

    /// The place of these bytes; of several lines the first is shown.
    pub(super) fn place(&self, range: Range<usize>) -> Place {
        let start = self.boundary(range.start);
        let line = self.starts.partition_point(|&first| first <= start).max(1) - 1;
        let first = self.starts.get(line).copied().unwrap_or(0);
        let rest = self.text.get(first..).unwrap_or("");
        let whole = rest.split('\n').next().unwrap_or("").trim_end_matches('\r');
        let end = self.boundary(range.end).clamp(start, (first + whole.len()).max(start));
        let column = self.text.get(first..start).map_or(0, |before| before.chars().count()) + 1;
        let (from, to) = if whole.len() > LONG {
            (self.boundary(start.saturating_sub(LONG / 4)).max(first), self.boundary(end + LONG / 4))
        } else {
            (first, first + whole.len())
        };
        let to = to.clamp(from, (first + whole.len()).max(from));
        let excerpt = self.text.get(from..to).unwrap_or("").to_owned();
        let low = (start - from).min(excerpt.len());
        let high = (end - from).clamp(low, excerpt.len());
        Place { file: self.file.to_owned(), line: line + 1, column, excerpt, highlight: low..high }
    }

    /// The place of a line and column as `roxmltree` counts them: from 1, in characters.
    pub(super) fn place_at(&self, row: u32, column: u32) -> Place {
        let start = self.starts.get((row as usize).saturating_sub(1)).copied().unwrap_or(self.text.len());
        let rest = self.text.get(start..).unwrap_or("");
        let mut ahead = rest.char_indices().skip((column as usize).saturating_sub(1)).map(|(at, _)| start + at);
        let at = ahead.next().unwrap_or(self.text.len());
        self.place(at..ahead.next().unwrap_or(self.text.len()))
    }

    /// The place of the name in an opening tag that starts at this byte, with the bracket before it.
    pub(super) fn tag(&self, start: usize) -> Place {
        let rest = self.text.get(start..).unwrap_or("");
        let length = rest.find(|c: char| c.is_whitespace() || c == '/' || c == '>').unwrap_or(rest.len());
        self.place(start..start + length)
    }

    fn boundary(&self, at: usize) -> usize {
        let at = at.min(self.text.len());
        (0..=at).rev().find(|&at| self.text.is_char_boundary(at)).unwrap_or(0)
    }
}

/// The diagnostics on a file so far.
#[derive(Default)]
pub(super) struct Diagnostics {
    list: Vec<Diagnostic>,
    errors: usize,
}

impl Diagnostics {
    pub(super) fn push(&mut self, diagnostic: Diagnostic) {
        self.errors += usize::from(diagnostic.is_error());
        if self.list.len() < MOST {
            self.list.push(diagnostic);
        } else if diagnostic.is_error() && self.errors == 1 {
            // The one error among a crowd of warnings must not be lost.
            self.list.insert(0, diagnostic);
        }
    }

    /// Whether more diagnostics would not be shown: spares the search for suggestions.
    pub(super) fn full(&self) -> bool {
        self.list.len() >= MOST && self.errors > 0
    }

    pub(super) fn has_error(&self) -> bool {
        self.errors > 0
    }

    /// All diagnostics, errors first, and how many more there were.
    pub(super) fn finish(mut self) -> Vec<Diagnostic> {
        self.list.sort_by_key(|diagnostic| std::cmp::Reverse(diagnostic.severity));
        let shown = self.list.iter().filter(|diagnostic| diagnostic.is_error()).count();
        if self.errors > shown {
            self.list.push(Diagnostic::error(format!("{} more errors are not shown", self.errors - shown)));
        }
        self.list
    }
}
