//! `explain`: the page of the docs about a word.

use crate::Error;
use crate::cli::args::Explain;
use crate::cli::output::Output;
use crate::cli::session::Session;
use crate::diagnostic::nearest;

/// The pages, each under a heading of its own that is the word.
const PAGES: [(&str, &str); 3] = [
    ("terms", include_str!("../../../docs/terms.md")),
    ("effects", include_str!("../../../docs/effects.md")),
    ("diagnostics", include_str!("../../../docs/diagnostics.md")),
];

pub fn run(command: &Explain, session: &Session) -> Result<Output, Error> {
    let all = PAGES.map(|(name, text)| (name, cut(text)));
    let Some(asked) = &command.term else { return list(&all) };
    let wanted = asked.trim().to_lowercase().replace([' ', '_'], "-");
    let entries = || all.iter().flat_map(|(page, entries)| entries.iter().map(move |entry| (*page, entry)));
    let Some((page, (term, text))) = entries().find(|(_, (term, _))| *term == wanted) else {
        let remedy = match nearest(&wanted, entries().map(|(_, (term, _))| *term)) {
            Some(near) => format!("did you mean `{near}`?"),
            None => "`elastogeo explain` lists all words".into(),
        };
        return Err(Error::input(format!("`{asked}` is not explained"), remedy));
    };
    let shown = if session.terminal.screen.columns().is_some() { joined(text) } else { (*text).into() };
    let json = serde_json::json!({"term": term, "page": format!("docs/{page}.md"), "text": text});
    Output::new(format!("{term}\n\n{}\n", shown.trim()), &json)
}

/// Words and their texts: a page cut at its second-level headings.
fn cut(page: &str) -> Vec<(&str, &str)> {
    let parts = page.split("\n## ").skip(1);
    parts.filter_map(|part| part.split_once('\n')).map(|(head, text)| (head.trim_matches(['`', ' ']), text)).collect()
}

fn list(all: &[(&str, Vec<(&str, &str)>)]) -> Result<Output, Error> {
    let mut text = String::new();
    let mut json = serde_json::Map::new();
    for (page, entries) in all {
        let words: Vec<&str> = entries.iter().map(|(term, _)| *term).collect();
        text += &format!("{page}: {}\n", words.join(", "));
        json.insert((*page).into(), serde_json::json!(words));
    }
    Output::new(text, &json)
}

/// Paragraphs and list items on one line each, so that the screen can break them; code as it stands.
fn joined(text: &str) -> String {
    let mut out = String::new();
    let mut code = false;
    for line in text.trim().lines() {
        let fence = line.starts_with("```");
        let own = code || fence || line.trim().is_empty() || line.starts_with(['*', '|', '#']);
        code ^= fence;
        if !own && !out.is_empty() && !out.ends_with("\n\n") && !out.ends_with("```\n") {
            out.truncate(out.trim_end().len());
            out.push(' ');
            out += line.trim();
        } else {
            out += line;
        }
        out.push('\n');
    }
    out
}
