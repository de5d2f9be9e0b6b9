//! Titles of columns as files have them: what is often called otherwise, units behind names, and how a title is written in YAML.

/// What instruments and controllers call some of our columns.
const SYNONYMS: [(&str, &str); 12] = [
    ("sequence", "order"),
    ("seq", "order"),
    ("number", "order"),
    ("no", "order"),
    ("nr", "order"),
    ("index", "order"),
    ("timestamp", "time"),
    ("t", "time"),
    ("temp", "temperature"),
    ("name", "pose"),
    ("point", "marker"),
    ("target", "marker"),
];

/// Our column that is often called so.
pub(super) fn synonym(title: &str) -> Option<&'static str> {
    let plain = title.to_lowercase();
    SYNONYMS.iter().find(|(known, _)| *known == plain).map(|(_, ours)| *ours)
}

/// A title without the unit behind it in brackets: `q1` of `q1 [deg]` and `q1 (deg)`.
pub(super) fn without_unit(title: &str) -> &str {
    let bare = [('[', ']'), ('(', ')')].into_iter().find_map(|(open, close)| {
        let (bare, unit) = title.strip_suffix(close)?.split_once(open)?;
        (!unit.is_empty()).then_some(bare.trim_end())
    });
    bare.filter(|bare| !bare.is_empty()).unwrap_or(title)
}

/// A title as it is written in YAML within braces: quoted where it holds signs that mean something there.
pub(super) fn scalar(title: &str) -> String {
    let is_plain = |c: char| c.is_alphanumeric() || matches!(c, '_' | '.' | '-' | ' ' | '/' | '(' | ')');
    match title.chars().all(is_plain) && title.starts_with(char::is_alphabetic) {
        true => title.to_owned(),
        false => format!("\"{}\"", title.replace('\\', "\\\\").replace('"', "\\\"")),
    }
}
