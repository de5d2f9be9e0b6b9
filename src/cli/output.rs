//! What a command hands to the terminal and to files.

use std::path::{Path, PathBuf};

use serde::Serialize;

use crate::Error;
use crate::diagnostic::{Code, Diagnostic};
use crate::plausibility::{forced, refusing, reported_once};

/// What a command found.
#[derive(Default)]
pub struct Output {
    /// For people.
    pub text: String,
    /// For programs.
    pub json: serde_json::Value,
    /// Warnings, shown on the error stream.
    pub diagnostics: Vec<Diagnostic>,
    /// Other files to write, each whole or not at all.
    pub files: Vec<(PathBuf, String)>,
    /// Tables to write with them.
    pub tables: Vec<(PathBuf, Vec<u8>)>,
    /// The outcome is a refusal: exit status 1 although there is something to show.
    pub failed: bool,
    /// An alarm that was asked for: exit status 3.
    pub alarm: bool,
    /// What is printed stays on the screen: `--output` names one of `files`.
    pub written: bool,
    /// The text is a file's, not for reading: it is never laid out for the screen.
    pub verbatim: bool,
    /// The JSON is a list or a schema, and left as it is.
    pub bare: bool,
}

impl Output {
    /// Text and JSON of one result.
    pub fn new(text: String, result: &impl Serialize) -> Result<Self, Error> {
        Ok(Self { text, json: serde_json::to_value(result)?, ..Self::default() })
    }

    /// Of a command that has printed what it found.
    pub fn nothing() -> Self {
        Self::default().verbatim().bare()
    }

    /// A file to write, and the line of the text that names it.
    pub fn file(&mut self, what: &str, path: &Path, content: String) {
        self.text += &format!("{what}: {}\n", path.display());
        self.files.push((path.to_path_buf(), content));
    }

    /// A table to write, and the line of the text that names it.
    pub fn table(&mut self, what: &str, path: &Path, content: Vec<u8>) {
        self.text += &format!("{what}: {}\n", path.display());
        self.tables.push((path.to_path_buf(), content));
    }

    /// The page, where one is written, and the line of the text that names it.
    pub fn page(&mut self, what: &str, path: Option<&Path>, html: String) {
        if let Some(path) = path {
            self.file(what, path, html);
            self.written = true;
        }
    }

    /// The text, with what casts doubt on the figures before them.
    pub fn with_doubts(&self) -> String {
        let is_doubt = |diagnostic: &&Diagnostic| diagnostic.code.is_about_figures();
        let doubts: String = self.diagnostics.iter().filter(is_doubt).map(doubt).collect();
        if doubts.is_empty() { self.text.clone() } else { format!("{doubts}\n{}", self.text) }
    }

    /// Warnings that cast no doubt on the figures, as lines: for a file, where nothing else shows them.
    pub fn notes(&self) -> String {
        let others = self.diagnostics.iter().filter(|diagnostic| !diagnostic.code.is_about_figures());
        let note = |diagnostic: &Diagnostic| {
            let remedy = diagnostic.remedy.as_ref().map_or(String::new(), |remedy| format!("  {remedy}\n"));
            format!("NOTE ({}): {}\n{remedy}", diagnostic.code.name(), diagnostic.message)
        };
        let notes: String = others.map(note).collect();
        if notes.is_empty() { notes } else { format!("\n{notes}") }
    }

    /// The JSON, with the list of diagnostics.
    pub fn with_diagnostics(&self) -> Result<serde_json::Value, Error> {
        let mut json = self.json.clone();
        if let Some(object) = json.as_object_mut().filter(|_| !self.bare) {
            object.insert("diagnostics".into(), serde_json::to_value(&self.diagnostics)?);
        }
        Ok(json)
    }

    /// Refuses, before anything is computed, what a gate found implausible of the inputs, with what reading them reported.
    ///
    /// # Errors
    /// The diagnostics that refuse, then those of the reading.
    pub fn gate(found: &[Diagnostic], force: bool, of_reading: &[Diagnostic]) -> Result<(), Error> {
        match refusing(found.to_vec(), force) {
            Some(refused) => Err(refused.into_iter().chain(of_reading.iter().cloned()).collect::<Vec<_>>().into()),
            None => Ok(()),
        }
    }

    /// With what a gate found: an error of plausibility refuses the result (unless `force`), any other error makes it one
    /// that is not to be used.
    pub fn judged(mut self, found: Vec<Diagnostic>, force: bool) -> Result<Self, Error> {
        let found = reported_once(if force { forced(found) } else { found });
        if let Some(mut refused) = refusing(found.clone(), force) {
            refused.append(&mut self.diagnostics);
            return Err(Error::from(refused));
        }
        self.failed |= found.iter().any(Diagnostic::is_error);
        self.diagnostics.extend(found);
        Ok(self)
    }

    /// The first doubt for which fitted values are not to be written into a description, but for those that are `excepted`; none
    /// where that is forced.
    pub fn doubt_in_values(&self, force: bool, excepted: impl Fn(&Diagnostic) -> bool) -> Option<Code> {
        // What cannot even be read back is not written by force either.
        let is_unreadable = |found: &Diagnostic| found.is_error() && found.code == Code::UnusableResult;
        let forbids =
            |found: &&Diagnostic| !force && found.code.forbids_saving() && !is_unreadable(found) && !excepted(found);
        self.diagnostics.iter().find(forbids).map(|found| found.code)
    }

    /// Says that a file which was asked for is not written, and why; the result is then not to be used as it is.
    pub fn not_written(&mut self, path: &Path, doubt: Option<Code>) {
        let why = doubt.map_or(String::new(), |code| format!(" (doubtful: {}; --force writes it)", code.name()));
        self.text += &format!("not written: {}{why}\n", path.display());
        self.failed = true;
    }

    pub fn verbatim(self) -> Self {
        Self { verbatim: true, ..self }
    }

    pub fn bare(self) -> Self {
        Self { bare: true, ..self }
    }
}

/// A doubt in the text of a result.
fn doubt(diagnostic: &Diagnostic) -> String {
    let remedy = diagnostic.remedy.as_ref().map_or(String::new(), |remedy| format!("  {remedy}\n"));
    format!("DOUBTFUL ({}): {}\n{remedy}", diagnostic.code.name(), diagnostic.message)
}
