//! What keeps a description from being compiled.

use crate::diagnostic::Diagnostic;

/// What keeps a description from being compiled.
#[derive(Debug, Clone, PartialEq)]
pub struct Fault {
    /// Where in the description the culprit stands: keys from the top, such as `["loops", name]`.
    pub path: Vec<String>,
    /// What is wrong, without a place.
    pub diagnostic: Diagnostic,
}

impl Fault {
    pub(super) fn new(path: &[&str], diagnostic: Diagnostic) -> Self {
        Self { path: path.iter().map(ToString::to_string).collect(), diagnostic }
    }

    /// The same fault, its path starting further up.
    pub(super) fn within(mut self, above: &[&str]) -> Self {
        self.path.splice(0..0, above.iter().map(ToString::to_string));
        self
    }
}
