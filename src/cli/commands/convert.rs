//! `convert`: a description as YAML or URDF.

use std::path::Path;

use super::schema::file_name;
use crate::cli::args::{Convert, SchemaOf};
use crate::cli::{Failure, Output};
use crate::description::raw::RawRobot;
use crate::description::{urdf, yaml};
use crate::diagnostic::Diagnostic;
use crate::files::{load_robot, schema_line};

pub fn run(command: &Convert) -> Result<Output, Failure> {
    can_write(&command.to)?;
    let loaded = load_robot(&command.robot)?;
    let (text, diagnostics) = written(&loaded.raw, &command.to)?;
    let said = format!("wrote {}\n", command.to.display());
    let mut output = Output::new(said, serde_json::json!({"wrote": command.to.display().to_string()}));
    output.diagnostics = loaded.diagnostics.into_iter().chain(diagnostics).collect();
    output.files.push((command.to.clone(), text));
    Ok(output)
}

/// Refuses, before anything is computed, a file that could not be written in the end.
pub fn can_write(to: &Path) -> Result<(), Failure> {
    if !matches!(to.extension().and_then(|extension| extension.to_str()), Some("yaml" | "yml" | "urdf" | "xml")) {
        return Err(Failure::input(format!("`{}`: format unknown", to.display()), "end the name in .yaml or .urdf"));
    }
    crate::files::writable(to).map_err(|diagnostic| Failure::Input(vec![diagnostic]))
}

/// A description as the text of a file, in the format that its name asks for.
pub fn written(raw: &RawRobot, to: &Path) -> Result<(String, Vec<Diagnostic>), Failure> {
    match to.extension().and_then(|extension| extension.to_str()) {
        Some("yaml" | "yml") => {
            let line = schema_line(to, file_name(SchemaOf::Robot));
            Ok((line + &yaml::write(raw).map_err(Failure::Computation)?, Vec::new()))
        }
        Some("urdf" | "xml") => Ok(urdf::export(raw)?),
        _ => Err(Failure::input(format!("`{}`: format unknown", to.display()), "end the name in .yaml or .urdf")),
    }
}
