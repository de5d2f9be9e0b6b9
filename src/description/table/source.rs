//! The bytes behind a CSV reader, kept as far back as a fault may have to be shown.

use crate::diagnostic::Place;
use std::io::{self, Read};
use std::ops::Range;

/// Longest row, in bytes: more is a quote that was never closed, or no table at all.
pub(super) const LONGEST_ROW: usize = 1 << 20;
/// A file up to this many bytes is kept whole, so that later checks can show its lines too.
const KEPT_WHOLE: usize = 4 << 20;

/// A reader that remembers what it has handed out since the current row began.
pub(super) struct Source<R> {
    inner: R,
    kept: Vec<u8>,
    /// Offset in the file (after the byte-order mark) of the first byte kept.
    base: u64,
    row: u64,
    started: bool,
    /// Bytes read in search of a byte-order mark and not handed out yet.
    ahead: Vec<u8>,
    /// The file starts as UTF-16 does.
    pub wide: bool,
    /// A row longer than [`LONGEST_ROW`] was met.
    pub too_long: bool,
}

impl<R: Read> Source<R> {
    pub fn new(inner: R) -> Self {
        let (kept, ahead) = (Vec::new(), Vec::new());
        Self { inner, kept, base: 0, row: 0, started: false, ahead, wide: false, too_long: false }
    }

    /// Notes where the current row starts; what stands before it may be dropped.
    pub fn row_starts(&mut self, at: u64) {
        self.row = at;
        let gone = usize::try_from(at.saturating_sub(self.base)).unwrap_or(0).min(self.kept.len());
        if self.kept.len() > KEPT_WHOLE && gone > LONGEST_ROW {
            self.kept.drain(..gone);
            self.base += gone as u64;
        }
    }

    /// The bytes kept from an offset on.
    pub fn from(&self, at: u64) -> &[u8] {
        let start = usize::try_from(at.saturating_sub(self.base)).unwrap_or(usize::MAX);
        self.kept.get(start..).unwrap_or_default()
    }

    /// Takes back what was read from the start of the file, to hand it out again.
    pub fn hand_back(&mut self, head: Vec<u8>) {
        self.kept.clear();
        self.ahead = head;
    }

    /// The whole file, if it was small.
    pub fn into_whole(self) -> Option<Vec<u8>> {
        (self.base == 0 && self.kept.len() <= KEPT_WHOLE).then_some(self.kept)
    }

    fn start(&mut self) -> io::Result<()> {
        self.started = true;
        let mut head = Vec::with_capacity(3);
        self.inner.by_ref().take(3).read_to_end(&mut head)?;
        self.wide = head.starts_with(&[0xff, 0xfe])
            || head.starts_with(&[0xfe, 0xff])
            || head.get(..2).is_some_and(|h| h.contains(&0));
        self.ahead = head.strip_prefix(b"\xef\xbb\xbf").unwrap_or(&head).to_vec();
        Ok(())
    }
}

impl<R: Read> Read for Source<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        if !self.started {
            self.start()?;
        }
        let pending = (self.base + self.kept.len() as u64).saturating_sub(self.row);
        if pending > LONGEST_ROW as u64 {
            self.too_long = true;
            return Err(io::Error::other(format!("a row is longer than {LONGEST_ROW} bytes")));
        }
        let read = if self.ahead.is_empty() {
            self.inner.read(buffer)?
        } else {
            let length = self.ahead.len().min(buffer.len());
            for (to, from) in buffer.iter_mut().zip(self.ahead.drain(..length)) {
                *to = from;
            }
            length
        };
        self.kept.extend_from_slice(buffer.get(..read).unwrap_or_default());
        Ok(read)
    }
}

/// One row as it stands in the file: its bytes, without the last line break, and its first line.
pub(super) struct Row<'a> {
    pub file: &'a str,
    pub bytes: &'a [u8],
    pub line: usize,
    pub delimiter: u8,
}

impl<'a> Row<'a> {
    /// The row that starts after the empty lines at `from`; `line` is the line of `from`.
    pub fn at(file: &'a str, from: &'a [u8], line: usize, delimiter: u8) -> Self {
        let empty = from.iter().take_while(|&&byte| byte == b'\n').count();
        let bytes = from.get(empty..).unwrap_or_default();
        let mut row = Self { file, bytes, line: line + empty, delimiter };
        let (end, _) = row.scan(usize::MAX);
        row.bytes = bytes.get(..end.end).unwrap_or(bytes);
        row
    }

    /// The bytes of a field (past the last one: of the end of the row), and the quote that is still open after it.
    fn scan(&self, field: usize) -> (Range<usize>, Option<usize>) {
        let mut start = 0;
        let mut number = 0;
        let mut quote = None;
        for (at, &byte) in self.bytes.iter().enumerate() {
            match byte {
                b'"' if quote.is_some() => quote = None,
                // A quote opens a field, or, doubled, goes on with one.
                b'"' if at == start
                    || (self.bytes.get(start) == Some(&b'"') && self.bytes.get(at - 1) == Some(&b'"')) =>
                {
                    quote = Some(at);
                }
                b'\n' if quote.is_none() => return (if number == field { start..at } else { at..at }, None),
                _ if byte == self.delimiter && quote.is_none() => {
                    if number == field {
                        return (start..at, None);
                    }
                    number += 1;
                    start = at + 1;
                }
                _ => {}
            }
        }
        let end = self.bytes.len();
        (if number == field { start..end } else { end..end }, quote)
    }

    /// Where a quote was opened that the file never closes.
    pub fn open_quote(&self) -> Option<usize> {
        self.scan(usize::MAX).1
    }

    /// The place of a field, without the blanks around it.
    pub fn field(&self, field: usize) -> Place {
        let range = self.scan(field).0;
        let bytes = self.bytes.get(range.clone()).unwrap_or_default();
        let blank = bytes.iter().take_while(|byte| byte.is_ascii_whitespace()).count();
        let length = bytes.trim_ascii().len();
        if length == 0 { self.place(range) } else { self.place(range.start + blank..range.start + blank + length) }
    }

    /// The place of everything from a field to the end of the row.
    pub fn fields_from(&self, field: usize) -> Place {
        self.place(self.scan(field).0.start..self.bytes.len())
    }

    /// The place of some bytes of the row, on the line where they start.
    pub fn place(&self, range: Range<usize>) -> Place {
        let (before, after) = self.bytes.split_at(range.start.min(self.bytes.len()));
        let line_start = before.iter().rposition(|&byte| byte == b'\n').map_or(0, |at| at + 1);
        let line = self.line + before.iter().filter(|&&byte| byte == b'\n').count();
        let mut text = String::from_utf8_lossy(before.get(line_start..).unwrap_or_default()).into_owned();
        let start = text.len();
        let (meant, rest) = after.split_at(range.len().min(after.len()));
        text.push_str(&String::from_utf8_lossy(meant));
        let end = text.len();
        text.push_str(&String::from_utf8_lossy(rest));
        let line_end = text.find('\n').unwrap_or(text.len());
        let text = text.get(..line_end).unwrap_or(&text).trim_end_matches('\r');
        Place::on_line(self.file, line, text, start..end)
    }
}
