//! What a command hands to the terminal and to files.

use std::path::PathBuf;

use serde::Serialize;

use crate::Error;
use crate::diagnostic::Diagnostic;

/// What a command found.
pub struct Output {
    /// For people.
    pub text: String,
    /// For programs.
    pub json: serde_json::Value,
    /// Warnings, shown on the error stream.
    pub diagnostics: Vec<Diagnostic>,
    /// Other files to write, each whole or not at all.
    pub files: Vec<(PathBuf, String)>,
    /// The outcome is a refusal: exit status 1 although there is something to show.
    pub failed: bool,
    /// What is printed stays on the screen: `--output` names one of `files`.
    pub written: bool,
    /// The text is a file's, not for reading: it is never laid out for the screen.
    pub verbatim: bool,
}

impl Output {
    /// Text and JSON of one result.
    pub fn new(text: String, result: &impl Serialize) -> Result<Self, Error> {
        let json = serde_json::to_value(result)?;
        let (diagnostics, files) = (Vec::new(), Vec::new());
        Ok(Self { text, json, diagnostics, files, failed: false, written: false, verbatim: false })
    }

    pub fn verbatim(self) -> Self {
        Self { verbatim: true, ..self }
    }
}
