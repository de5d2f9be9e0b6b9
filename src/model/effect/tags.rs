//! Effects in files of versions up to 0.1, whose alternatives were written as numbers, in today's names.
//!
//! `changes_at: 0` meant the side of approach, `of_wrench: 1` a mis-stated wrench, `jump_at: -1` a steady drift. This is
//! the only place that knows.

use crate::description::raw::{RawAmount, RawEffect};

/// The entry with its alternatives named; an entry that names them already is returned as it is.
pub(super) fn named_choices(entry: &RawEffect) -> RawEffect {
    let mut named = entry.clone();
    // The number of a tag, where the word that replaced it is not given.
    let tag = |key: &str, word: &str| match named.parameters.get(key) {
        Some(RawAmount::Number(value)) if !named.parameters.contains_key(word) => Some(*value),
        _ => None,
    };
    let (word, choice, obsolete) = match entry.effect.as_deref() {
        Some("backlash") => match tag("changes_at", "by") {
            Some(0.0) => ("by", "approach", Some("changes_at")),
            Some(_) => ("by", "load", None),
            None => return named,
        },
        Some("payload") => match tag("of_wrench", "misstated") {
            Some(1.0) => ("misstated", "wrench", Some("of_wrench")),
            Some(_) => ("misstated", "mass", Some("of_wrench")),
            None => return named,
        },
        Some("frame-drift") => match tag("jump_at", "course") {
            Some(at) if at < 0.0 => ("course", "steady", Some("jump_at")),
            Some(_) => ("course", "jump", None),
            None => return named,
        },
        _ => return named,
    };
    if let Some(key) = obsolete {
        named.parameters.shift_remove(key);
    }
    named.parameters.insert(word.into(), choice.into());
    named
}
