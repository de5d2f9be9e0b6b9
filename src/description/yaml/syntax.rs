//! Syntax errors of YAML, in words that say how to mend them.

use serde_yaml::granit_parser::{ErrorKind, ScanError};

use crate::diagnostic::{Code, Diagnostic, Place};

/// Deepest nesting of mappings and sequences.
pub(super) const DEEPEST: usize = 64;

/// A syntax error, where the parser stopped.
pub(super) fn syntax(file: &str, text: &str, error: &ScanError) -> Diagnostic {
    let at = error.marker().byte_offset().unwrap_or(text.len()).min(text.len());
    let (message, remedy) = words(error.kind());
    let indent = matches!(error.kind(), ErrorKind::InvalidQuotedScalarIndent);
    let opened = text.get(..at).filter(|_| indent).and_then(|before| before.rfind(['\'', '"']));
    let end = at + text.get(at..).and_then(|rest| rest.chars().next()).map_or(0, char::len_utf8);
    let opened = opened.map(|quote| Place::in_text(file, text, quote..quote + 1));
    let diagnostic = Diagnostic::error(message)
        .code(Code::Syntax)
        .at(Place::in_text(file, text, at..end))
        .related(opened, "perhaps opened here");
    if remedy.is_empty() { diagnostic } else { diagnostic.remedy(remedy) }
}

/// What is wrong, and what to do about it.
fn words(kind: &ErrorKind) -> (String, &'static str) {
    use ErrorKind as E;
    let tab = "indent with spaces; YAML allows no tab there";
    let quote = "close the quote, or write the quote within double quotes (\"3'\")";
    match kind {
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
    }
}
