//! A result as a page, with its data as JSON or XML beside it.

use std::path::PathBuf;

use serde::Serialize;

use crate::Error;
use crate::cli::args::Report as Asked;
use crate::cli::output::Output;
use crate::cli::session::Session;
use crate::diagnostic::Diagnostic;
use crate::plausibility::forced;
use crate::render::xml::xml;

/// What a page is written with.
pub(super) struct Delivery<'a> {
    pub command: &'a Asked,
    pub session: &'a Session<'a>,
    /// Where the page goes.
    pub page: Option<PathBuf>,
    /// What is said of the files.
    pub diagnostics: Vec<Diagnostic>,
    /// What is said of their content, and of the result.
    pub judged: Vec<Diagnostic>,
}

impl Delivery<'_> {
    /// What the page shows of it.
    pub fn shown(&self) -> Vec<Diagnostic> {
        let force = self.session.arguments.force;
        let judged = if force { forced(self.judged.clone()) } else { self.judged.clone() };
        self.diagnostics.iter().cloned().chain(judged).collect()
    }

    /// The page, its data as JSON and XML where they are asked for, and the text of a result.
    ///
    /// # Errors
    /// A result that cannot be written as JSON.
    pub fn finish(
        self,
        what: &str,
        result: &impl Serialize,
        text: String,
        html: String,
        is_converged: bool,
    ) -> Result<Output, Error> {
        let mut output = Output::new(text, result)?;
        output.diagnostics = self.diagnostics;
        let mut output = output.judged(self.judged, self.session.arguments.force)?;
        output.failed |= !is_converged;
        if let Some(path) = &self.command.json {
            output.file("\nits data", path, serde_json::to_string_pretty(&output.with_diagnostics()?)? + "\n");
        }
        if let Some(path) = &self.command.xml {
            output.file("\nits data", path, xml(what, &output.with_diagnostics()?));
        }
        output.page(&format!("\n{what}"), self.page.as_deref(), html);
        Ok(output)
    }
}
