//! `explain`: the page of the docs about a word.

use crate::Error;
use crate::cli::args::Explain;
use crate::cli::output::Output;
use crate::cli::session::Session;
use crate::diagnostic::nearest;

/// The pages, each entry under a heading of its own that is the word, or several with commas between.
const PAGES: [(&str, &str); 4] = [
    ("terms", include_str!("../../../docs/terms.md")),
    ("effects", include_str!("../../../docs/effects.md")),
    ("columns", include_str!("../../../docs/columns.md")),
    ("diagnostics", include_str!("../../../docs/diagnostics.md")),
];

pub fn run(command: &Explain, session: &Session) -> Result<Output, Error> {
    let all = PAGES.map(|(name, text)| (name, cut(text)));
    let Some(asked) = &command.term else { return list(&all) };
    let plain = |word: &str| word.trim().to_lowercase().replace([' ', '_'], "-");
    let wanted = plain(asked);
    // A column of one joint is explained as that of all.
    let stem = wanted.split('.').next().unwrap_or_default();
    let entries = || all.iter().flat_map(|(page, entries)| entries.iter().map(move |entry| (*page, entry)));
    let named = |word: &str| entries().find(|(_, (term, _))| term.split(',').any(|own| plain(own) == word));
    let Some((page, (term, text))) = named(&wanted).or_else(|| named(stem)) else {
        let words = entries().flat_map(|(_, (term, _))| term.split(',').map(str::trim));
        let remedy = match nearest(&wanted, words) {
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
