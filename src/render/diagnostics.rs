//! Diagnostics drawn as a compiler draws them: the place, the lines, what is meant in them, and what to do.

use crate::diagnostic::{Diagnostic, Place, Severity, cut};
use annotate_snippets::{Annotation, AnnotationKind, Group, Level, Origin, Renderer, Snippet};
use std::fmt::Write as _;

/// All diagnostics as text, each with its place, lines, related places and remedy, and a last line with their number.
///
/// Control characters of a file reach neither the terminal nor a log. No diagnostics, no text.
pub fn render(diagnostics: &[Diagnostic], color: bool) -> String {
    if diagnostics.is_empty() {
        return String::new();
    }
    let renderer = if color { Renderer::styled() } else { Renderer::plain() };
    let mut text = String::new();
    for diagnostic in diagnostics {
        let level = match diagnostic.severity {
            Severity::Error => Level::ERROR,
            Severity::Warning => Level::WARNING,
        };
        let mut group = level.primary_title(inert(&diagnostic.message)).elements(None::<Origin<'_>>);
        if let Some(place) = &diagnostic.place {
            group = draw(group, place, AnnotationKind::Primary, None);
        }
        for (place, why) in &diagnostic.related {
            group = draw(group, place, AnnotationKind::Context, Some(inert(why)));
        }
        if let Some(remedy) = &diagnostic.remedy {
            group = group.element(Level::HELP.message(inert(remedy)));
        }
        let mut drawn = renderer.render(&[group]);
        for place in diagnostic.place.iter().chain(diagnostic.related.iter().map(|(place, _)| place)) {
            if let Some((of_cut, of_file)) = headers(place) {
                drawn = drawn.replacen(&of_cut, &of_file, 1);
            }
        }
        // Writing to a String cannot fail.
        let _ = writeln!(text, "{drawn}\n");
    }
    let errors = diagnostics.iter().filter(|diagnostic| diagnostic.is_error()).count();
    let _ = writeln!(text, "{}, {}", count(errors, "error"), count(diagnostics.len() - errors, "warning"));
    text
}

/// Adds one place: its origin line, then its lines, where there are any.
fn draw<'a>(group: Group<'a>, place: &Place, kind: AnnotationKind, label: Option<String>) -> Group<'a> {
    if place.excerpt.is_empty() {
        let group = group.element(Origin::path(inert(&place.file)).line(place.line).char_column(place.column));
        return match label {
            Some(label) => group.element(Level::NOTE.message(label)),
            None => group,
        };
    }
    let (excerpt, highlight) = lines(place);
    let snippet: Snippet<'_, Annotation<'_>> = Snippet::source(excerpt).path(inert(&place.file)).line_start(place.line);
    group.element(snippet.fold(false).annotation(kind.span(highlight).label(label)))
}

/// The header that the renderer counts out of a cut line, and the one that is true of the file; `None` if they agree.
fn headers(place: &Place) -> Option<(String, String)> {
    if place.excerpt.is_empty() {
        return None;
    }
    let (excerpt, highlight) = lines(place);
    let before = excerpt.get(..highlight.start)?;
    let column = 1 + before.rsplit('\n').next()?.chars().count();
    let header = |line: usize, column: usize| format!("{}:{line}:{column}", inert(&place.file));
    let line = place.line + before.matches('\n').count();
    let differs = (line, column) != (place.line, place.column) || place.in_sheet;
    differs.then(|| (header(line, column), inert(&place.address())))
}

/// The excerpt, long lines cut, and the highlight on character boundaries.
fn lines(place: &Place) -> (String, std::ops::Range<usize>) {
    let text = &place.excerpt;
    let boundary = |at: usize| (0..=at.min(text.len())).rev().find(|&at| text.is_char_boundary(at)).unwrap_or_default();
    let start = boundary(place.highlight.start);
    let end = boundary(place.highlight.end).max(start);
    let mut drawn = String::new();
    let (mut from, mut to) = (0, 0);
    let mut offset = 0;
    for line in text.split_inclusive('\n') {
        let bare = line.trim_end_matches(['\n', '\r']);
        let within = |at: usize| at.saturating_sub(offset).min(bare.len());
        let (cut, highlight) = cut(bare, within(start)..within(end));
        if (offset..=offset + bare.len()).contains(&start) && to == 0 {
            from = drawn.len() + highlight.start;
        }
        if end >= offset {
            to = drawn.len() + highlight.end;
        }
        drawn.push_str(&cut);
        drawn.push('\n');
        offset += line.len();
    }
    drawn.truncate(drawn.trim_end_matches('\n').len());
    let end = drawn.len();
    (drawn, from.min(end)..to.clamp(from.min(end), end))
}

/// The text with control characters written out, and those that turn the order of letters.
fn inert(text: &str) -> String {
    inert_but(text, &[])
}

/// The same for a text of several lines: titles and names come from files, and a terminal would do what they say.
pub fn inert_lines(text: &str) -> String {
    inert_but(text, &['\n', '\t'])
}

fn inert_but(text: &str, kept: &[char]) -> String {
    let mut inert = String::with_capacity(text.len());
    for char in text.chars() {
        if is_active(char) && !kept.contains(&char) { inert.extend(char.escape_debug()) } else { inert.push(char) }
    }
    inert
}

/// Whether a character is no letter but does something.
pub fn is_active(char: char) -> bool {
    char.is_control()
        || matches!(char, '\u{200b}'..='\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2060}'..='\u{2069}' | '\u{feff}')
}

fn count(number: usize, what: &str) -> String {
    format!("{number} {what}{}", if number == 1 { "" } else { "s" })
}
