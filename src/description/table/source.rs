//! The bytes behind a CSV reader, kept as far back as a fault may have to be shown, and handed on line by line: lines of
//! comment and of dialect as blank ones, runs of blanks between fields as one delimiter. Every line keeps its length, so
//! that offsets are those of the file.

use super::row::Delimiter;
use std::io::{self, BufRead, BufReader, Read};

/// Longest row, in bytes: more is a quote that was never closed, or no table at all.
pub(super) const LONGEST_ROW: usize = 1 << 20;
/// A file up to this many bytes is kept whole, so that later checks can show its lines too.
const KEPT_WHOLE: usize = 4 << 20;

/// A reader that remembers what it has read since the current row began.
pub(super) struct Source<R> {
    inner: BufReader<R>,
    /// As it stands in the file.
    kept: Vec<u8>,
    /// Offset in the file (after the byte-order mark) of the first byte kept.
    base: u64,
    row: u64,
    started: bool,
    /// Bytes read already that are to be read again.
    ahead: Vec<u8>,
    /// A line to hand out, and how much of it has been.
    line: (Vec<u8>, usize),
    /// Whether lines were read.
    first: bool,
    /// A quote is open where the next line begins.
    quoted: bool,
    /// What separates fields, once it is known.
    pub delimiter: Option<Delimiter>,
    /// A list of points, where more lines are comments.
    pub points: bool,
    /// The file starts as UTF-16 does.
    pub wide: bool,
    /// The delimiter that a first line `sep=;` declares.
    pub declared: Option<u8>,
    /// A row longer than [`LONGEST_ROW`] was met.
    pub too_long: bool,
}

/// Whether a line is a comment: `#` (unless it is the name of a column) or `//`; in a list of points `;` too.
pub(super) fn is_comment(line: &[u8], points: bool) -> bool {
    match line.trim_ascii_start() {
        [b'#', after @ ..] => points || !after.first().is_some_and(|next| b",;\t".contains(next)),
        [b'/', b'/', ..] => true,
        [b';', ..] => points,
        _ => false,
    }
}

impl<R: Read> Source<R> {
    pub fn new(inner: R, points: bool) -> Self {
        let (kept, ahead, line) = (Vec::new(), Vec::new(), (Vec::new(), 0));
        let (base, row, started, first, quoted) = (0, 0, false, true, false);
        let (delimiter, wide, declared, too_long) = (None, false, None, false);
        let inner = BufReader::with_capacity(1 << 16, inner);
        Self {
            inner,
            kept,
            base,
            row,
            started,
            ahead,
            line,
            first,
            quoted,
            delimiter,
            points,
            wide,
            declared,
            too_long,
        }
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

    /// The whole file, if it was small.
    pub fn into_whole(self) -> Option<Vec<u8>> {
        (self.base == 0 && self.kept.len() <= KEPT_WHOLE).then_some(self.kept)
    }

    /// Reads up to the end of the first line that is not blank, to be read again later: that line, and its number.
    pub fn first_line(&mut self) -> io::Result<(Vec<u8>, usize)> {
        let (mut line, mut number) = (Vec::new(), 0);
        while line.trim_ascii().is_empty() {
            line.clear();
            number += 1;
            self.next_line()?;
            if self.line.0.is_empty() {
                break;
            }
            line.append(&mut self.line.0);
        }
        // What was read in search of a byte-order mark may reach beyond that line.
        let beyond = std::mem::replace(&mut self.ahead, std::mem::take(&mut self.kept));
        self.ahead.extend(beyond);
        (self.line, self.first, self.quoted) = ((Vec::new(), 0), true, false);
        Ok((line, number))
    }

    /// The comment that stands last before a line, without its mark, and its number.
    pub fn comment_before(&self, line: usize) -> Option<(&[u8], usize)> {
        let lines = self.ahead.split(|&byte| byte == b'\n').zip(1..).take(line.saturating_sub(1));
        lines.filter(|(line, _)| is_comment(line, self.points)).last()
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

    /// Reads the next line, as it is handed out; of a file's end nothing.
    fn next_line(&mut self) -> io::Result<()> {
        if !self.started {
            self.start()?;
        }
        let (line, handed) = &mut self.line;
        line.clear();
        *handed = 0;
        let end = self.ahead.iter().position(|&byte| byte == b'\n').map_or(self.ahead.len(), |end| end + 1);
        line.extend(self.ahead.drain(..end));
        if line.last() != Some(&b'\n') {
            self.inner.by_ref().take(LONGEST_ROW as u64 + 2).read_until(b'\n', line)?;
        }
        self.kept.extend_from_slice(line);
        let pending = (self.base + self.kept.len() as u64).saturating_sub(self.row);
        if pending > LONGEST_ROW as u64 + 1 {
            line.clear();
            self.too_long = true;
            return Err(io::Error::other(format!("a row is longer than {LONGEST_ROW} bytes")));
        }
        self.rewrite();
        Ok(())
    }

    /// Makes of the line what is handed out.
    fn rewrite(&mut self) {
        let line = &mut self.line.0;
        if std::mem::take(&mut self.first)
            && let Some([b's' | b'S', b'e' | b'E', b'p' | b'P', b'=', declared, ..]) = bare(line).get(..5)
        {
            self.declared = Some(*declared).filter(|byte| !byte.is_ascii_control() || *byte == b'\t');
            return blank(line);
        }
        if !self.quoted && is_comment(line, self.points) {
            return blank(line);
        }
        match self.delimiter {
            Some(Delimiter::Blanks) => separate(line),
            delimiter if self.quoted || line.contains(&b'"') => {
                let byte = delimiter.map(Delimiter::byte);
                self.quoted = ends_in_quotes(line, self.quoted, byte);
            }
            _ => {}
        }
    }
}

/// A line without the quote before it.
fn bare(line: &[u8]) -> &[u8] {
    line.strip_prefix(b"\"").unwrap_or(line)
}

/// Blanks in place of all but the line break.
fn blank(line: &mut [u8]) {
    line.iter_mut().filter(|byte| **byte != b'\n').for_each(|byte| *byte = b' ');
}

/// Of each run of blanks between two fields the first becomes the delimiter.
pub(super) fn separate(line: &mut [u8]) {
    let (mut before, mut quoted) = (b' ', false);
    for byte in line.iter_mut() {
        let here = *byte;
        let is_blank = |byte: u8| byte == b' ' || byte == b'\t';
        match here {
            b'"' => quoted = !quoted && is_blank(before),
            _ if is_blank(here) && !quoted => *byte = if is_blank(before) { b' ' } else { b'\t' },
            _ => {}
        }
        before = here;
    }
}

/// Whether a quote is open after a line; `None`: any usual delimiter ends a field.
fn ends_in_quotes(line: &[u8], mut quoted: bool, delimiter: Option<u8>) -> bool {
    let ends_field = |byte: u8| delimiter.map_or(b",;\t".contains(&byte), |delimiter| byte == delimiter);
    let mut field_starts = !quoted;
    let mut bytes = line.iter().peekable();
    while let Some(&byte) = bytes.next() {
        if quoted && byte == b'"' {
            // Doubled, it is a character of the text.
            quoted = bytes.next_if(|next| **next == b'"').is_some();
        } else if byte == b'"' && field_starts {
            quoted = true;
        }
        field_starts = !quoted && ends_field(byte);
    }
    quoted
}

impl<R: Read> Read for Source<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        if self.line.1 >= self.line.0.len() {
            self.next_line()?;
        }
        let (line, handed) = &mut self.line;
        let rest = line.get(*handed..).unwrap_or_default();
        let read = rest.len().min(buffer.len());
        buffer.iter_mut().zip(rest).for_each(|(to, from)| *to = *from);
        *handed += read;
        Ok(read)
    }
}
