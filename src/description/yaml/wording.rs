//! Errors of the YAML crate as diagnostics.

use super::index::{Index, Kind, Node};
use crate::diagnostic::{Code, Diagnostic, Place};
use serde_yaml::{Error, MessageFormatter, UserMessageFormatter};
use std::ops::Range;

/// What a fault is about, which decides what has to be left out to read on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum About {
    /// The key that stands there.
    Key,
    /// The value that stands there.
    Value,
    /// The mapping or list there, as a whole.
    Whole,
    /// The text: nothing can be read on.
    Text,
}

/// A typed error of the YAML crate.
#[derive(Debug)]
pub(super) struct Fault {
    pub about: About,
    /// Offset in bytes.
    pub at: usize,
    pub diagnostic: Diagnostic,
    /// The field that is missing, if that is the fault.
    pub missing: Option<&'static str>,
}

/// An error of the YAML crate at its place in the text.
struct Subject<'a> {
    text: &'a str,
    index: &'a Index,
    /// The value that starts where the error is.
    value: Option<usize>,
    /// The entry whose key starts there.
    keyed: Option<usize>,
    /// What the error is about.
    node: Option<usize>,
    /// Its path, quoted.
    name: String,
}

/// Words a typed error, at its place.
pub(super) fn fault(file: &str, text: &str, index: &Index, error: &Error) -> Fault {
    let error = error.without_snippet();
    let offset = error.location().and_then(|location| location.span().byte_offset());
    let at = offset.and_then(|at| usize::try_from(at).ok()).unwrap_or(0).min(text.len());
    let mut related = None;
    let mut inner = error;
    while let Error::AliasError { error, locations, .. } = inner {
        let defined = locations.defined_location.span().byte_offset().and_then(|at| usize::try_from(at).ok());
        related = related.or(defined);
        inner = error.without_snippet();
    }
    let value =
        index.nodes.iter().position(|node| node.parent.is_some() && node.value.start == at && !starts_at(node, at));
    let keyed = index.nodes.iter().position(|node| starts_at(node, at));
    let node = value.or(keyed).or_else(|| innermost(index, at));
    let name = node.map(|node| index.path(node)).filter(|path| !path.is_empty());
    let name = name.map_or_else(|| "the file".to_owned(), |path| format!("`{path}`"));
    let (about, diagnostic) = Subject { text, index, value, keyed, node, name }.words(inner);
    let missing = if let Error::SerdeMissingField { field, .. } = inner { Some(*field) } else { None };
    let place = |at| Place::in_text(file, text, span(index, at));
    let diagnostic = diagnostic
        .at(place(at))
        .related(related.filter(|&first| first != at).map(place), "what is repeated stands here");
    Fault { about, at, diagnostic, missing }
}

impl Subject<'_> {
    fn must_be(&self, expected: &str) -> Diagnostic {
        let found = found(self.text, self.index.nodes.get(self.node.unwrap_or(0)));
        Diagnostic::error(format!("{} must be {}, found {found}", self.name, plain(expected)))
    }

    /// What is wrong, and what of the text it is about.
    fn words(&self, error: &Error) -> (About, Diagnostic) {
        let name = &self.name;
        match error {
            Error::SerdeUnknownField { field, expected, .. } => (About::Key, self.unknown_key(field, expected)),
            Error::SerdeUnknownVariant { variant, expected, .. } => {
                (About::Whole, self.unknown_choice(variant, expected))
            }
            Error::SerdeMissingField { field, .. } => {
                let name = self.owner().unwrap_or_else(|| name.clone());
                let diagnostic = Diagnostic::error(format!("{name} lacks `{field}`")).code(Code::Missing);
                (About::Whole, diagnostic.remedy(format!("add `{field}: ...`")))
            }
            Error::SerdeInvalidLength { len, expected, .. } => {
                let message = format!("{name} holds {len} values, expected {}", plain(expected));
                (About::Whole, Diagnostic::error(message))
            }
            _ if self.is_key(error) => {
                let key = self.keyed.and_then(|node| self.text.get(self.index.nodes.get(node)?.key.clone()?));
                let message =
                    format!("a key must be a text or a whole number, found `{}`", clip(key.unwrap_or_default()));
                let remedy = "where a text such as `null` or `~` is meant, quote it";
                (About::Key, Diagnostic::error(message).remedy(remedy))
            }
            Error::InvalidScalar { ty, .. } => {
                let node = self.value.and_then(|node| self.index.nodes.get(node));
                let remedy = number_remedy(self.text, node, ty);
                (About::Value, Diagnostic { remedy, ..self.must_be(ty) })
            }
            Error::InvalidBooleanStrict { .. } => (About::Value, self.must_be("boolean")),
            // The crate says so of numbers too.
            Error::Unexpected { expected: "string scalar", .. } => (About::Value, self.must_be("a single value")),
            Error::Unexpected { expected, .. } => (About::Value, self.must_be(expected)),
            Error::SerdeInvalidType { expected, .. } | Error::SerdeInvalidValue { expected, .. } => {
                (About::Value, self.must_be(expected))
            }
            Error::NullIntoString { .. } => {
                let remedy = "write the text; where the text is `null` or `~`, quote it";
                (About::Value, self.must_be("string scalar").remedy(remedy))
            }
            Error::ExpectedStringKeyForExternallyTaggedEnum { .. }
            | Error::ExternallyTaggedEnumExpectedScalarOrMapping { .. }
            | Error::UnexpectedValueForUnitEnumVariant { .. }
            | Error::ExpectedMappingEndAfterEnumVariantValue { .. } => {
                (About::Whole, self.must_be("one choice: its name, or `name: {...}`"))
            }
            Error::DuplicateMappingKey { .. } => {
                let diagnostic = Diagnostic::error(format!("{name} is given twice")).code(Code::Duplicate);
                (About::Key, diagnostic.remedy("keep one of the two"))
            }
            Error::UnsupportedTag { tag, .. } => {
                let diagnostic = Diagnostic::error(format!("the tag `{}` means nothing here", clip(tag)));
                (About::Value, diagnostic.remedy("remove it"))
            }
            Error::Message { msg, .. } => (About::Value, Diagnostic::error(format!("{name}: {msg}"))),
            other => {
                let message = UserMessageFormatter.format_message(other).into_owned();
                (About::Text, Diagnostic::error(message).code(Code::Syntax))
            }
        }
    }

    /// The mapping whose first key stands there, quoted: where the crate places what is missing in it.
    fn owner(&self) -> Option<String> {
        let parent = self.index.nodes.get(self.keyed?)?.parent?;
        let path = self.index.path(parent);
        Some(if path.is_empty() { "the file".to_owned() } else { format!("`{path}`") })
    }

    /// Whether the error is about a key itself, which is neither a text nor a number.
    fn is_key(&self, error: &Error) -> bool {
        match error {
            Error::NullIntoString { .. } => self.keyed.is_some(),
            Error::InvalidScalar { .. } | Error::Unexpected { .. } => self.keyed.is_some() && self.value.is_none(),
            _ => false,
        }
    }

    fn unknown_key(&self, field: &str, expected: &[&str]) -> Diagnostic {
        let parent = self.keyed.and_then(|node| self.index.nodes.get(node)?.parent);
        let path = parent.map(|parent| self.index.path(parent)).filter(|path| !path.is_empty());
        let within = path.map_or_else(String::new, |path| format!(" in `{path}`"));
        let diagnostic = Diagnostic::error(format!("unknown key `{}`{within}", clip(field)));
        if !field.is_empty() && field.chars().all(|c| c.is_ascii_digit()) && !expected.contains(&field) {
            let remedy = "a comma separates entries here: write decimals with a point";
            return diagnostic.code(Code::Unknown).remedy(remedy);
        }
        diagnostic.suggest(field, expected.iter().copied())
    }

    fn unknown_choice(&self, variant: &str, expected: &[&str]) -> Diagnostic {
        let diagnostic = Diagnostic::error(format!("{}: unknown choice `{}`", self.name, clip(variant)));
        // The nearest name of a unit is another unit.
        if self.node.is_some_and(|node| self.index.path(node).starts_with("units")) {
            let valid: Vec<String> = expected.iter().map(|unit| format!("`{unit}`")).collect();
            return diagnostic.code(Code::Unknown).remedy(format!("valid here: {}", valid.join(", ")));
        }
        diagnostic.suggest(variant, expected.iter().copied())
    }
}

/// The innermost entry or element around an offset.
pub(super) fn innermost(index: &Index, at: usize) -> Option<usize> {
    index.nodes.iter().rposition(|node| node.parent.is_some() && node.extent().contains(&at))
}

/// Whether the entry's key starts there.
pub(super) fn starts_at(node: &Node, at: usize) -> bool {
    node.key.as_ref().is_some_and(|key| key.start == at)
}

/// The key or value that starts at an offset, the key first.
fn span(index: &Index, at: usize) -> Range<usize> {
    let key = index.nodes.iter().filter_map(|node| node.key.clone()).find(|key| key.start == at);
    key.or_else(|| Some(index.nodes.iter().find(|node| node.value.start == at)?.value.clone())).unwrap_or(at..at + 1)
}

/// What stands there, in words.
fn found(text: &str, node: Option<&Node>) -> String {
    let Some(node) = node else { return "something else".to_owned() };
    match node.kind {
        Kind::Mapping => "a mapping".to_owned(),
        Kind::Sequence => "a list".to_owned(),
        Kind::Alias(_) | Kind::Scalar => match text.get(node.value.clone()).unwrap_or_default().trim() {
            "" | ":" => "nothing".to_owned(),
            written => format!("`{}`", clip(written)),
        },
    }
}

/// A found text, short enough for a message.
fn clip(text: &str) -> String {
    let line = text.lines().next().unwrap_or_default();
    match line.char_indices().nth(60) {
        Some((end, _)) => format!("{}...", line.get(..end).unwrap_or_default()),
        None => line.to_owned(),
    }
}

/// What Rust's types are called outside Rust.
fn plain(expected: &str) -> String {
    let words = match expected {
        "floating point" | "f64" | "f32" => "a number",
        "boolean" | "a boolean" => "`true` or `false`",
        "string scalar" | "a string" | "string" | "str" => "a text",
        "mapping start" | "map" | "a map" => "a mapping (`key: value` pairs)",
        "sequence start" | "a sequence" | "seq" => "a list",
        "null" | "unit" => "left empty",
        _ if expected.starts_with("struct ") => "a mapping (`key: value` pairs)",
        _ if expected.starts_with("enum ") => "one of the choices",
        _ if number(expected, 'u') => "a whole number, not below 0",
        _ if number(expected, 'i') => "a whole number",
        _ => {
            let array = expected.strip_prefix("an array of length ").or(expected.strip_prefix("a tuple of size "));
            return array.map_or_else(|| expected.to_owned(), |length| format!("{length} values"));
        }
    };
    words.to_owned()
}

/// Whether a type is `u8`, `i64` and the like.
fn number(ty: &str, sign: char) -> bool {
    ty.strip_prefix(sign).is_some_and(|bits| bits == "size" || bits.parse::<u8>().is_ok())
}

/// What to do about a text that is no number.
fn number_remedy(text: &str, node: Option<&Node>, ty: &str) -> Option<String> {
    let written = text.get(node?.value.clone())?.trim();
    let is_number = |text: &str| text.parse::<f64>().is_ok_and(f64::is_finite);
    let whole = number(ty, 'u') || number(ty, 'i');
    if whole && is_number(written) {
        return None;
    }
    let lower = written.to_lowercase();
    if written.contains(',') && is_number(&written.replace(',', ".")) {
        return Some(format!("write `{}`", written.replace(',', ".")));
    }
    if written.contains(['_', '\'', ' ']) && is_number(&written.replace(['_', '\'', ' '], "")) {
        return Some(format!("write `{}`", written.replace(['_', '\'', ' '], "")));
    }
    if matches!(lower.as_str(), "inf" | "+inf" | "-inf" | "infinity" | "-infinity" | "nan") {
        let sign = if lower.starts_with('-') { "-" } else { "" };
        return Some(format!("write `{sign}.{}`", if lower == "nan" { "nan" } else { "inf" }));
    }
    if let Some(digits) = lower.strip_prefix("0x") {
        let value = u64::from_str_radix(digits, 16).ok();
        return value.map(|value| format!("numbers are decimal here; `{written}` is {value}"));
    }
    if written.contains(':') && written.split(':').all(is_number) {
        return Some(
            "write one decimal number in the unit of the file, not degrees:minutes or minutes:seconds".to_owned(),
        );
    }
    if written.parse::<f64>().is_ok() {
        return Some("the number is too large; write `.inf` if infinite is meant".to_owned());
    }
    let digits = written.find(|c: char| c.is_alphabetic() || c == '%' || c == '\u{b0}')?;
    let (value, unit) = written.split_at(digits);
    is_number(value.trim())
        .then(|| format!("write the number alone (`{}`); `units:` says the unit, not `{unit}`", value.trim()))
}
