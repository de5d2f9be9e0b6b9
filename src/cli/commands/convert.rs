//! `convert`: a description as YAML or URDF.

use std::path::Path;

use super::schema::file_name;
use crate::Error;
use crate::cli::args::{Convert, SchemaOf};
use crate::cli::output::Output;
use crate::cli::session::Session;
use crate::description::raw::RawRobot;
use crate::description::{urdf, yaml};
use crate::diagnostic::Diagnostic;
use crate::files::schema_line;

pub fn run(command: &Convert, session: &Session) -> Result<Output, Error> {
    can_write(&command.to)?;
    let loaded = session.reader.robot(&command.robot)?;
    let (text, diagnostics) = written(&loaded.raw, &command.to)?;
    let warnings = format!("wrote {}\n", command.to.display());
    let mut output = Output::new(warnings, &serde_json::json!({"wrote": command.to.display().to_string()}))?;
    output.diagnostics = loaded.diagnostics.into_iter().chain(diagnostics).collect();
    output.files.push((command.to.clone(), text));
    Ok(output)
}

/// Refuses, before anything is computed, a file that could not be written in the end.
pub fn can_write(to: &Path) -> Result<(), Error> {
    if !matches!(to.extension().and_then(|extension| extension.to_str()), Some("yaml" | "yml" | "urdf" | "xml")) {
        return Err(Error::input(format!("`{}`: format unknown", to.display()), "end the name in .yaml or .urdf"));
    }
    Ok(crate::files::writable(to)?)
}

/// A description as the text of a file, in the format that its name asks for.
pub fn written(raw: &RawRobot, to: &Path) -> Result<(String, Vec<Diagnostic>), Error> {
    match to.extension().and_then(|extension| extension.to_str()) {
        Some("yaml" | "yml") => {
            let line = schema_line(to, file_name(SchemaOf::Robot));
            Ok((line + &yaml::write(raw).map_err(Error::Impossible)?, Vec::new()))
        }
        Some("urdf" | "xml") => Ok(urdf::export(raw)?),
        _ => Err(Error::input(format!("`{}`: format unknown", to.display()), "end the name in .yaml or .urdf")),
    }
}
