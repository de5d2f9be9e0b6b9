//! The schema that a YAML file should follow: the line by which editors find it, and the remedy for an empty file.

use std::path::Path;

use crate::diagnostic::{Code, Diagnostic};

/// Folders above a file in which its schema is sought.
const HIGHEST: usize = 4;

/// The first line of a YAML file at `to` that names the schema `file` (`robot.schema.json`, ..), where that lies next to the
/// file, above it, or in a folder `schemas` there; else nothing.
pub fn schema_line(to: &Path, file: &str) -> String {
    let folder = to.parent().unwrap_or(Path::new(""));
    for up in 0..=HIGHEST {
        let above = if up == 0 { "./".into() } else { "../".repeat(up) };
        for place in [format!("{above}{file}"), format!("{above}schemas/{file}")] {
            if folder.join(&place).is_file() {
                return format!("# yaml-language-server: $schema={place}\n");
            }
        }
    }
    String::new()
}

/// Adds to the diagnostic of an empty file which schema it should follow.
pub(super) fn name_schema(diagnostics: &mut [Diagnostic], kind: &str) {
    for diagnostic in diagnostics.iter_mut().filter(|diagnostic| diagnostic.code == Code::Empty) {
        diagnostic.remedy =
            Some(format!("write `key: value` pairs; `elastogeo schema {kind}` prints what is expected"));
    }
}
