//! One row as it stands in a file, and where its fields are.

use crate::diagnostic::Place;
use std::ops::Range;

/// What stands between two fields.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Delimiter {
    /// One character.
    Byte(u8),
    /// Blanks and tabs, as many as there are.
    Blanks,
}

impl Default for Delimiter {
    fn default() -> Self {
        Self::Byte(b',')
    }
}

impl Delimiter {
    /// The character that separates fields in what is handed to the CSV reader.
    pub fn byte(self) -> u8 {
        match self {
            Self::Byte(byte) => byte,
            Self::Blanks => b'\t',
        }
    }

    /// As it is named in messages: a tab is written, not shown.
    pub fn shown(self) -> &'static str {
        match self {
            Self::Byte(b'\t') => "\\t",
            Self::Byte(b';') => ";",
            Self::Byte(_) => ",",
            Self::Blanks => " ",
        }
    }
}

/// How rows are written: what separates their fields, and whether they are rows of a sheet.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Writing {
    pub delimiter: Delimiter,
    /// Of a sheet of a workbook: the number of empty columns left of its first.
    pub sheet: Option<usize>,
}

/// One row as it stands in the file: its bytes, without the last line break, and its first line.
pub(super) struct Row<'a> {
    pub file: &'a str,
    pub bytes: &'a [u8],
    pub line: usize,
    pub writing: Writing,
}

impl<'a> Row<'a> {
    /// The row that starts after the empty lines at `from`; `line` is the line of `from`.
    pub fn at(file: &'a str, from: &'a [u8], line: usize, writing: Writing) -> Self {
        let empty = from.iter().take_while(|&&byte| byte == b'\n').count();
        let bytes = from.get(empty..).unwrap_or_default();
        let mut row = Self { file, bytes, line: line + empty, writing };
        let (end, _) = row.scan(usize::MAX);
        row.bytes = bytes.get(..end.end).unwrap_or(bytes);
        row
    }

    /// The bytes of a field (past the last one: of the end of the row), and the quote that is still open after it.
    fn scan(&self, field: usize) -> (Range<usize>, Option<usize>) {
        let by_blanks = self.writing.delimiter == Delimiter::Blanks;
        let mut start = 0;
        let mut number = 0;
        let mut quote = None;
        // Nothing but blanks since the field began.
        let mut blank = true;
        for (at, &byte) in self.bytes.iter().enumerate() {
            match byte {
                b'"' if quote.is_some() => quote = None,
                // A quote opens a field, or, doubled, goes on with one.
                b'"' if at == start
                    || (by_blanks && blank)
                    || (self.bytes.get(start) == Some(&b'"') && self.bytes.get(at - 1) == Some(&b'"')) =>
                {
                    quote = Some(at);
                }
                b'\n' if quote.is_none() || by_blanks => {
                    return (if number == field { start..at } else { at..at }, quote);
                }
                _ if quote.is_none() && self.ends_field(byte, blank) => {
                    if number == field {
                        return (start..at, None);
                    }
                    number += 1;
                    start = at + 1;
                    blank = true;
                    continue;
                }
                _ => {}
            }
            blank &= byte == b' ' || byte == b'\t';
        }
        let end = self.bytes.len();
        (if number == field { start..end } else { end..end }, quote)
    }

    /// Whether a byte outside quotes ends its field; `blank`: nothing but blanks stands before it.
    fn ends_field(&self, byte: u8, blank: bool) -> bool {
        match self.writing.delimiter {
            Delimiter::Byte(delimiter) => byte == delimiter,
            Delimiter::Blanks => !blank && (byte == b' ' || byte == b'\t'),
        }
    }

    /// Number of fields.
    pub fn count(&self) -> usize {
        (0..).take_while(|field| self.scan(*field).0.start < self.bytes.len()).count()
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
        let meant = range.start + blank..range.start + blank + length;
        let place = if length == 0 { self.place(range) } else { self.place(meant) };
        self.in_sheet(place, field)
    }

    /// The place of everything from a field to the end of the row.
    pub fn fields_from(&self, field: usize) -> Place {
        self.in_sheet(self.place(self.scan(field).0.start..self.bytes.len()), field)
    }

    /// The place of a field as that of a cell, where the row is one of a sheet.
    fn in_sheet(&self, place: Place, field: usize) -> Place {
        match self.writing.sheet {
            Some(left) => Place { column: left + field + 1, in_sheet: true, ..place },
            None => place,
        }
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
