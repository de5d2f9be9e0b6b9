//! A located complaint, as data: what is wrong, where, what was expected and how to mend it.
//!
//! Readers collect every remark of a file instead of stopping at the first; `report::remarks` words and draws them.

use std::ops::Range;

/// How grave a [`Remark`] is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// Worth knowing; the file is still usable.
    Warning,
    /// The file cannot be used.
    Error,
}

/// A stretch of a file, with the lines around it, so that it can be shown without the file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Place {
    /// Display name of the file.
    pub file: String,
    /// Line of the first highlighted character, counted from 1.
    pub line: usize,
    /// Column of the first highlighted character, in characters, counted from 1.
    pub column: usize,
    /// The whole line or lines that hold the stretch.
    pub excerpt: String,
    /// Bytes of `excerpt` that are meant.
    pub highlight: Range<usize>,
}

/// One complaint about an input.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Remark {
    /// How grave it is.
    pub severity: Severity,
    /// What is wrong, with the value found and the rule it breaks.
    pub message: String,
    /// Where; `None` when it concerns the whole input or a flag.
    pub place: Option<Place>,
    /// Other places that matter (the first of two definitions), each with a word on why.
    pub related: Vec<(Place, String)>,
    /// What to do about it.
    pub remedy: Option<String>,
}

impl Remark {
    /// An error without a place; see [`Remark::at`] and [`Remark::remedy`].
    pub fn error(message: impl Into<String>) -> Self {
        Self { severity: Severity::Error, message: message.into(), place: None, related: Vec::new(), remedy: None }
    }

    /// A warning without a place.
    pub fn warning(message: impl Into<String>) -> Self {
        Self { severity: Severity::Warning, ..Self::error(message) }
    }

    /// Adds the place.
    #[must_use]
    pub fn at(mut self, place: impl Into<Option<Place>>) -> Self {
        self.place = place.into();
        self
    }

    /// Adds another place that matters.
    #[must_use]
    pub fn related(mut self, place: Option<Place>, why: impl Into<String>) -> Self {
        self.related.extend(place.map(|place| (place, why.into())));
        self
    }

    /// Adds what to do about it.
    #[must_use]
    pub fn remedy(mut self, remedy: impl Into<String>) -> Self {
        self.remedy = Some(remedy.into());
        self
    }

    /// Adds "did you mean ...?" when one of `valid` is near `found`, else lists what is valid.
    #[must_use]
    pub fn suggest<'a>(self, found: &str, valid: impl IntoIterator<Item = &'a str>) -> Self {
        let valid: Vec<&str> = valid.into_iter().collect();
        match nearest(found, valid.iter().copied()) {
            Some(name) => self.remedy(format!("did you mean `{name}`?")),
            None if valid.is_empty() => self,
            None => {
                let shown: Vec<String> = valid.iter().take(12).map(|name| format!("`{name}`")).collect();
                let more = if valid.len() > 12 { ", ..." } else { "" };
                self.remedy(format!("valid here: {}{more}", shown.join(", ")))
            }
        }
    }

    /// Whether it is an error.
    pub fn is_error(&self) -> bool {
        self.severity == Severity::Error
    }
}

/// The valid name most like `found`, if any is like it at all.
pub fn nearest<'a>(found: &str, valid: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    valid
        .into_iter()
        .map(|name| (name, strsim::damerau_levenshtein(&found.to_lowercase(), &name.to_lowercase())))
        .filter(|&(name, distance)| distance <= 1 + name.chars().count().max(found.chars().count()) / 4)
        .min_by_key(|&(_, distance)| distance)
        .map(|(name, _)| name)
}
