//! Before anything is built of a file: its size and nesting, then its XML.

use roxmltree::{Document, Error, ParsingOptions};

use super::locate::xacro;
use super::source::Source;
use crate::diagnostic::Diagnostic;

/// Largest file read, bytes.
const LARGEST: usize = 20_000_000;
/// Deepest nesting of elements; a robot needs about six.
const DEEPEST: usize = 64;
/// Most attributes of one element; a robot needs about six.
const MOST_ATTRIBUTES: usize = 256;
/// Most elements, texts and comments.
const MOST_NODES: u32 = 2_000_000;

/// Looks over the nesting and the tags without building anything: what follows is safe on a small stack and in time.
pub(super) fn outline(source: &Source) -> Result<(), Box<Diagnostic>> {
    let text = source.text();
    if text.len() > LARGEST {
        let found = text.len() as f64 / 1e6;
        let message = format!("the file holds {found:.1} MB; a URDF of at most {} MB is read", LARGEST / 1_000_000);
        return Err(Box::new(Diagnostic::error(message).remedy("leave meshes in files of their own")));
    }
    let bytes = text.as_bytes();
    let (mut at, mut depth) = (0, 0_usize);
    while let Some(open) = text.get(at..).and_then(|rest| rest.find('<')).map(|found| at + found) {
        let rest = text.get(open..).unwrap_or("");
        let skip = |end: &str| rest.find(end).map_or(text.len(), |found| open + found + end.len());
        if rest.starts_with("<!--") {
            at = skip("-->");
            continue;
        }
        if rest.starts_with("<![CDATA[") {
            at = skip("]]>");
            continue;
        }
        if rest.starts_with("<?") {
            at = skip("?>");
            continue;
        }
        let (mut quote, mut attributes, mut close) = (None, 0, open + 1);
        while let Some(&byte) = bytes.get(close) {
            match quote {
                Some(mark) if mark == byte => quote = None,
                Some(_) => {}
                None if byte == b'"' || byte == b'\'' => {
                    quote = Some(byte);
                    attributes += 1;
                }
                None if byte == b'>' => break,
                None => {}
            }
            close += 1;
        }
        if attributes > MOST_ATTRIBUTES {
            let message = format!("an element has {attributes} attributes; at most {MOST_ATTRIBUTES} are read");
            return Err(Box::new(Diagnostic::error(message).at(source.tag(open))));
        }
        if rest.starts_with("</") {
            depth = depth.saturating_sub(1);
        } else if !rest.starts_with("<!") && bytes.get(close.wrapping_sub(1)) != Some(&b'/') {
            depth += 1;
        }
        if depth > DEEPEST {
            let message = format!("elements are nested more than {DEEPEST} deep");
            let diagnostic = Diagnostic::error(message).at(source.tag(open));
            return Err(Box::new(diagnostic.remedy("a URDF nests about 6 deep: is a tag not closed?")));
        }
        at = close;
    }
    Ok(())
}

/// Reads the XML.
pub(super) fn parse<'a>(source: &Source<'a>) -> Result<Document<'a>, Box<Diagnostic>> {
    let options = ParsingOptions { nodes_limit: MOST_NODES, ..ParsingOptions::default() };
    Document::parse_with_options(source.text(), options).map_err(|error| {
        if matches!(&error, Error::UnknownNamespace(prefix, _) if prefix == "xacro") {
            let pos = error.pos();
            return Box::new(xacro(source.place_at(pos.row, pos.col)));
        }
        let whole = matches!(error, Error::NoRootNode | Error::DtdDetected | Error::NodesLimitReached);
        let pos = error.pos();
        let reason = error.to_string();
        let reason = reason.strip_suffix(&format!(" at {pos}")).unwrap_or(&reason);
        let diagnostic = Diagnostic::error(format!("this is not well-formed XML: {reason}"));
        Box::new(diagnostic.at((!whole).then(|| source.place_at(pos.row, pos.col))))
    })
}
