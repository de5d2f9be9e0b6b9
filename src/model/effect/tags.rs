//! Entries of effects as they may be written, in the names of their parameters: free curves, and files of versions up to 0.1,
//! whose alternatives were written as numbers.
//!
//! `changes_at: 0` meant the side of approach, `of_wrench: 1` a mis-stated wrench, `jump_at: -1` a steady drift. This is
//! the only place that says.

use crate::description::raw::{RawAmount, RawCurve, RawEffect};

/// The entry with a free curve as parameters: `at`, and the amounts `k1`, `k2` and so on.
pub(super) fn with_curve(entry: &RawEffect) -> RawEffect {
    let mut named = entry.clone();
    if let Some(follows) = named.follows.take() {
        named.parameters.insert("follows".into(), RawAmount::Name(follows));
    }
    if let Some(curve) = named.curve.take() {
        named.parameters.insert("at".into(), RawAmount::Numbers(curve.at));
        let amounts = curve.amount.into_iter().zip(1..).map(|(amount, k)| (format!("k{k}"), RawAmount::Number(amount)));
        named.parameters.extend(amounts);
    }
    named
}

/// A free curve of a joint in place of its parameters; any other entry as it is.
pub(super) fn as_curve(mut entry: RawEffect) -> RawEffect {
    let Some(RawAmount::Numbers(at)) = entry.parameters.get("at").cloned() else { return entry };
    let amount = |k: usize| entry.parameters.get(&format!("k{k}")).and_then(RawAmount::number);
    if (1..=at.len()).all(|k| amount(k).is_none()) {
        return entry;
    }
    // An amount that is not given is zero.
    let amount = (1..=at.len()).map(|k| amount(k).unwrap_or_default()).collect();
    entry.follows = match entry.parameters.get("follows") {
        Some(RawAmount::Name(follows)) => Some(follows.clone()),
        _ => None,
    };
    entry.parameters.clear();
    entry.curve = Some(RawCurve { at, amount });
    entry
}

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
