//! What keeps a description from being compiled.

use crate::diagnostic::Diagnostic;

/// What keeps a description from being compiled.
#[derive(Debug, Clone, PartialEq)]
pub struct Fault {
    /// Where in the description the culprit stands: keys from the top, such as `["loops", name]`.
    pub path: Vec<String>,
    /// What is wrong, without a place.
    pub diagnostic: Diagnostic,
    /// What else is wrong with the same entry.
    pub more: Vec<Fault>,
}

impl Fault {
    pub(super) fn new(path: &[&str], diagnostic: Diagnostic) -> Self {
        Self { path: path.iter().map(ToString::to_string).collect(), diagnostic, more: Vec::new() }
    }

    /// Several faults of one entry as one; `None` where there are none.
    pub(super) fn of_all(faults: Vec<Self>) -> Option<Self> {
        let mut all = faults.into_iter();
        let mut first = all.next()?;
        first.more.extend(all);
        Some(first)
    }

    /// The fault and what else is wrong with the entry, each by itself.
    pub fn each(mut self) -> impl Iterator<Item = Self> {
        let more = std::mem::take(&mut self.more);
        std::iter::once(self).chain(more)
    }

    /// The same fault, its path starting further up.
    pub(super) fn within(mut self, above: &[&str]) -> Self {
        for fault in std::iter::once(&mut self.path).chain(self.more.iter_mut().map(|fault| &mut fault.path)) {
            fault.splice(0..0, above.iter().map(ToString::to_string));
        }
        self
    }
}
