//! A line of a table taken apart: its delimiter, its fields.

use super::row::Delimiter;
use super::source::separate;

/// A cell without the blanks and quotes around it.
pub(super) fn unquoted(cell: &str) -> &str {
    let cell = cell.trim();
    cell.strip_prefix('"').and_then(|cell| cell.strip_suffix('"')).map_or(cell, str::trim)
}

/// The delimiter declared, or the one the header holds most of; `None` if the declared one cannot be.
pub(super) fn delimiter(line: &[u8], declared: Option<char>, decimal: Option<char>) -> Option<Delimiter> {
    let decimal = match decimal {
        Some(decimal) => Some(u8::try_from(decimal).ok().filter(|decimal| matches!(decimal, b'.' | b','))?),
        None => None,
    };
    if let Some(declared) = declared {
        let declared = u8::try_from(declared).ok().filter(u8::is_ascii)?;
        let can_be = Some(declared) != decimal && !matches!(declared, b'\n' | b'\r' | b'"' | 0);
        let delimiter = if declared == b' ' { Delimiter::Blanks } else { Delimiter::Byte(declared) };
        return can_be.then_some(delimiter);
    }
    let count = |delimiter: u8| {
        let mut quoted = false;
        let outside = line.iter().filter(|&&byte| {
            quoted ^= byte == b'"';
            byte == delimiter && !quoted
        });
        outside.count()
    };
    // Of equally many commas and others the commas are decimal signs, of a line of numbers that begins with a name.
    let candidates = [b',', b';', b'\t'].into_iter().filter(|&delimiter| Some(delimiter) != decimal);
    let most = candidates.max_by_key(|&delimiter| count(delimiter))?;
    let by_blanks = count(most) == 0 && titles(line, Delimiter::Blanks).len() > 1;
    Some(if by_blanks { Delimiter::Blanks } else { Delimiter::Byte(most) })
}

/// The names in the header line.
pub(super) fn titles(line: &[u8], delimiter: Delimiter) -> Vec<String> {
    let mut line = line.to_vec();
    if delimiter == Delimiter::Blanks {
        separate(&mut line);
        line.truncate(line.trim_ascii_end().len());
    }
    let mut reader = reader(delimiter).from_reader(line.as_slice());
    let mut record = csv::ByteRecord::new();
    // Reading from memory does not fail; were it to, the header would be empty and every column missing.
    let _ = reader.read_byte_record(&mut record);
    record.iter().map(|title| unquoted(&String::from_utf8_lossy(title)).to_owned()).collect()
}

/// A reader of rows that are written so.
pub(super) fn reader(delimiter: Delimiter) -> csv::ReaderBuilder {
    let mut builder = csv::ReaderBuilder::new();
    builder.delimiter(delimiter.byte()).has_headers(false).flexible(true).terminator(csv::Terminator::Any(b'\n'));
    builder.quoting(delimiter != Delimiter::Blanks);
    builder
}
