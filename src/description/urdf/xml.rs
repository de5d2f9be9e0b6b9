//! Numbers and names as a URDF spells them.

use std::fmt::Write;

use nalgebra::Vector3;

/// Writing to a string cannot fail.
pub(super) fn put(out: &mut String, text: std::fmt::Arguments) {
    out.write_fmt(text).unwrap_or_default();
}

pub(super) fn triple(vector: &Vector3<f64>) -> String {
    format!("{} {} {}", number(vector.x), number(vector.y), number(vector.z))
}

/// The shortest text that reads back as the same number.
pub(super) fn number(value: f64) -> String {
    let text = format!("{:?}", value + 0.0);
    text.strip_suffix(".0").map_or(text.clone(), str::to_owned)
}

/// Whether XML 1.0 can hold the character.
pub(super) fn allowed(c: char) -> bool {
    matches!(c, '\t' | '\n' | '\r') || (c >= ' ' && !matches!(c, '\u{fffe}' | '\u{ffff}'))
}

/// Text as it stands in XML or HTML, within a quoted attribute too.
pub(crate) fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\t' => out.push_str("&#9;"),
            '\n' => out.push_str("&#10;"),
            '\r' => out.push_str("&#13;"),
            _ => out.push(c),
        }
    }
    out
}
