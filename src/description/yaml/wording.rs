//! The diagnostics of the YAML crate in plain words.

use super::index::{DEEPEST, Index, Kind, Node};
use crate::diagnostic::{Diagnostic, Place};
use serde_yaml::granit_parser::{ErrorKind, ScanError};
use serde_yaml::{Error, MessageFormatter, UserMessageFormatter};
use std::ops::Range;

/// A syntax error, where the parser stopped.
pub(super) fn syntax(file: &str, text: &str, error: &ScanError) -> Diagnostic {
    use ErrorKind as E;
    let at = error.marker().byte_offset().unwrap_or(text.len()).min(text.len());
    let tab = "indent with spaces; YAML allows no tab there";
    let quote = "close the quote, or write the quote within double quotes (\"3'\")";
    let (message, remedy) = match error.kind() {
        E::TabNotAllowed
        | E::TabInBlockIndentation
        | E::TabInIndentation
        | E::TabAtBlockScalarStart
        | E::TabInPlainScalar
        | E::InvalidBlockEntryWhitespace
        | E::InvalidMappingValueWhitespace => ("a tab stands where only spaces may".to_owned(), tab),
        E::UnclosedQuotedScalar | E::DocumentIndicatorInQuotedScalar => {
            ("this quote is never closed".to_owned(), quote)
        }
        E::InvalidTrailingSingleQuotedScalar | E::InvalidTrailingDoubleQuotedScalar => {
            ("text follows a closed quote".to_owned(), "put the whole text within the quotes")
        }
        E::UnclosedFlowCollection { open } => (format!("this `{open}` is never closed"), "close it"),
        E::MismatchedFlowCollectionEnd { open, close } => {
            (format!("`{open}` is closed by `{close}`"), "close each bracket by its own kind")
        }
        E::MisplacedFlowCollectionEnd => {
            ("this bracket closes nothing".to_owned(), "remove it, or add the one that opens")
        }
        E::RecursionLimitExceeded => (format!("nested more than {DEEPEST} levels deep"), "flatten the file"),
        E::UnknownAnchor => (
            "this alias repeats an anchor that is not defined above it".to_owned(),
            "a text that starts with `*` needs quotes",
        ),
        E::MappingValueNotAllowed | E::InvalidColonPlacement => (
            "a `:` stands where no key can".to_owned(),
            "one `key: value` a line; a text that holds `: ` needs quotes; check the indentation",
        ),
        E::SimpleKeyExpected | E::ExpectedBlockMappingKey | E::InvalidSimpleKey => {
            ("expected `key: value` here".to_owned(), "check the indentation and that a `:` and a space follow the key")
        }
        E::InvalidQuotedScalarIndent => ("a quote is still open where this line starts".to_owned(), quote),
        E::ExpectedDocumentStart
        | E::InvalidIndentation
        | E::ExpectedBlockSequenceEntry
        | E::InvalidFlowScalarIndent => {
            ("the indentation fits nothing above".to_owned(), "entries of one mapping or list start in one column")
        }
        E::UnexpectedCharacter { character } => {
            (format!("a value cannot start with `{}`", character.escape_debug()), "put the text in quotes")
        }
        E::ExpectedFlowMappingSeparator | E::UnexpectedEofFlowMapping => {
            ("expected `,` or `}` here".to_owned(), "separate entries by commas and close with `}`")
        }
        E::ExpectedFlowSequenceSeparator | E::UnexpectedEofFlowSequence => {
            ("expected `,` or `]` here".to_owned(), "separate elements by commas and close with `]`")
        }
        E::UnknownQuotedScalarEscape | E::InvalidQuotedScalarHexEscape => {
            ("unknown escape in a double-quoted text".to_owned(), "write `\\\\` for a backslash, or use single quotes")
        }
        kind => (format!("not valid YAML: {kind}"), ""),
    };
    let indent = matches!(error.kind(), E::InvalidQuotedScalarIndent);
    let opened = text.get(..at).filter(|_| indent).and_then(|before| before.rfind(['\'', '"']));
    let end = at + text.get(at..).and_then(|rest| rest.chars().next()).map_or(0, char::len_utf8);
    let opened = opened.map(|quote| Place::in_text(file, text, quote..quote + 1));
    let diagnostic =
        Diagnostic::error(message).at(Place::in_text(file, text, at..end)).related(opened, "perhaps opened here");
    if remedy.is_empty() { diagnostic } else { diagnostic.remedy(remedy) }
}

/// What a fault is about, which decides what has to be set aside to read on.
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

/// Words a typed error; the place is left to the caller's choice of `at`.
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
    let found = found(text, index.nodes.get(node.unwrap_or(0)));
    let must_be = |expected: &str| format!("{name} must be {}, found {found}", plain(expected));
    let error_of = |message: String| Diagnostic::error(message);
    let key_itself = match inner {
        Error::NullIntoString { .. } => keyed.is_some(),
        Error::InvalidScalar { .. } | Error::Unexpected { .. } => keyed.is_some() && value.is_none(),
        _ => false,
    };
    let mut missing = None;
    let (about, diagnostic) = match inner {
        Error::SerdeUnknownField { field, expected, .. } => {
            let parent = keyed.and_then(|node| index.nodes.get(node)?.parent).map(|parent| index.path(parent));
            let within =
                parent.filter(|path| !path.is_empty()).map_or_else(String::new, |path| format!(" in `{path}`"));
            let diagnostic =
                error_of(format!("unknown key `{}`{within}", clip(field))).suggest(field, expected.iter().copied());
            (About::Key, diagnostic)
        }
        Error::SerdeUnknownVariant { variant, expected, .. } => {
            let diagnostic = error_of(format!("{name}: unknown choice `{}`", clip(variant)));
            // The nearest name of a unit is another unit.
            let is_unit = node.is_some_and(|node| index.path(node).starts_with("units"));
            let valid = || expected.iter().map(|unit| format!("`{unit}`")).collect::<Vec<_>>().join(", ");
            let diagnostic = if is_unit {
                diagnostic.remedy(format!("valid here: {}", valid()))
            } else {
                diagnostic.suggest(variant, expected.iter().copied())
            };
            (About::Whole, diagnostic)
        }
        Error::SerdeMissingField { field, .. } => {
            missing = Some(*field);
            (About::Whole, error_of(format!("{name} lacks `{field}`")).remedy(format!("add `{field}: ...`")))
        }
        Error::SerdeInvalidLength { len, expected, .. } => {
            (About::Whole, error_of(format!("{name} holds {len} values, expected {}", plain(expected))))
        }
        _ if key_itself => {
            let key = keyed.and_then(|node| text.get(index.nodes.get(node)?.key.clone()?)).unwrap_or_default();
            let diagnostic = error_of(format!("a key must be a text or a whole number, found `{}`", clip(key)));
            (About::Key, diagnostic.remedy("where a text such as `null` or `~` is meant, quote it"))
        }
        Error::InvalidScalar { ty, .. } => {
            let diagnostic = error_of(must_be(ty));
            let remedy = number_remedy(text, value.and_then(|node| index.nodes.get(node)), ty);
            (About::Value, if let Some(remedy) = remedy { diagnostic.remedy(remedy) } else { diagnostic })
        }
        Error::InvalidBooleanStrict { .. } => (About::Value, error_of(must_be("boolean"))),
        // The crate says so of numbers too.
        Error::Unexpected { expected: "string scalar", .. } => {
            (About::Value, error_of(format!("{name} must be a single value, found {found}")))
        }
        Error::Unexpected { expected, .. } => (About::Value, error_of(must_be(expected))),
        Error::SerdeInvalidType { expected, .. } | Error::SerdeInvalidValue { expected, .. } => {
            (About::Value, error_of(must_be(expected)))
        }
        Error::NullIntoString { .. } => {
            let diagnostic = error_of(must_be("string scalar"));
            (About::Value, diagnostic.remedy("write the text; where the text is `null` or `~`, quote it"))
        }
        Error::ExpectedStringKeyForExternallyTaggedEnum { .. }
        | Error::ExternallyTaggedEnumExpectedScalarOrMapping { .. }
        | Error::UnexpectedValueForUnitEnumVariant { .. }
        | Error::ExpectedMappingEndAfterEnumVariantValue { .. } => {
            (About::Whole, error_of(format!("{name} must be one choice: its name, or `name: {{...}}`, found {found}")))
        }
        Error::DuplicateMappingKey { .. } => {
            (About::Key, error_of(format!("{name} is given twice")).remedy("keep one of the two"))
        }
        Error::UnsupportedTag { tag, .. } => {
            (About::Value, error_of(format!("the tag `{}` means nothing here", clip(tag))).remedy("remove it"))
        }
        Error::Message { msg, .. } => (About::Value, error_of(format!("{name}: {}", message(msg)))),
        other => (About::Text, error_of(UserMessageFormatter.format_message(other).into_owned())),
    };
    let place = |at| Place::in_text(file, text, span(index, at));
    let diagnostic = diagnostic
        .at(place(at))
        .related(related.filter(|&first| first != at).map(place), "what is repeated stands here");
    Fault { about, at, diagnostic, missing }
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
    if written.parse::<f64>().is_ok() {
        return Some("the number is too large; write `.inf` if infinite is meant".to_owned());
    }
    let digits = written.find(|c: char| c.is_alphabetic() || c == '%' || c == '\u{b0}')?;
    let (value, unit) = written.split_at(digits);
    is_number(value.trim())
        .then(|| format!("write the number alone (`{}`); `units:` says the unit, not `{unit}`", value.trim()))
}

/// A message that a type of ours, or serde for it, has worded.
fn message(text: &str) -> String {
    if text.starts_with("data did not match any variant of untagged enum") {
        return "the value fits none of the forms that are accepted here".to_owned();
    }
    text.to_owned()
}
