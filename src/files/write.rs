//! Files written whole or not at all.

use std::io::Write;
use std::path::Path;

use tempfile::NamedTempFile;

use crate::Error;
use crate::diagnostic::Diagnostic;

/// Whether a file can be written there, as far as can be reported without writing.
///
/// # Errors
/// Why it cannot.
pub fn writable(path: &Path) -> Result<(), Diagnostic> {
    let shown = path.display();
    if path.is_dir() {
        return Err(
            Diagnostic::error(format!("`{shown}` cannot be written: it is a folder")).remedy("give a file's name")
        );
    }
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() && !folder.is_dir() => {
            let folder = folder.display();
            Err(Diagnostic::error(format!("`{shown}` cannot be written: there is no folder `{folder}`"))
                .remedy("make the folder, or give another"))
        }
        _ => Ok(()),
    }
}

/// Whether a table can be written there: as CSV, or as a workbook where the name ends in `.xlsx`.
///
/// # Errors
/// Why it cannot.
pub fn writable_table(path: &Path) -> Result<(), Diagnostic> {
    let end = path.extension().and_then(|end| end.to_str()).unwrap_or_default().to_lowercase();
    if ["xls", "xlsb", "xlsm", "ods"].contains(&end.as_str()) {
        let message = format!("`{}`: tables are not written as .{end}", path.display());
        return Err(Diagnostic::error(message).remedy("give a name that ends in .xlsx, or in .csv"));
    }
    if !cfg!(feature = "xlsx") && end == "xlsx" {
        let message = format!("`{}`: this program is built without workbooks (feature `xlsx`)", path.display());
        return Err(Diagnostic::error(message).remedy("give a name that ends in .csv"));
    }
    writable(path)
}

/// Writes files, all of them whole or none at all: each next to its target first, then in its place.
///
/// # Errors
/// What the system reported, and of which file.
pub fn write_whole(files: &[(&Path, &[u8])]) -> Result<(), Error> {
    let failed =
        |path: &Path, error: std::io::Error| Error::from(error).at(format!("`{}` cannot be written", path.display()));
    // What is not moved into its place is removed when it is dropped.
    let mut parts: Vec<(NamedTempFile, &Path)> = Vec::new();
    for (path, content) in files {
        // A device or a pipe is written as it is: nothing can be moved into its place.
        if std::fs::metadata(path).is_ok_and(|known| !known.is_file()) {
            std::fs::write(path, content).map_err(|error| failed(path, error))?;
            continue;
        }
        let part = part_of(path).and_then(|mut part| part.write_all(content).map(|()| part));
        parts.push((part.map_err(|error| failed(path, error))?, path));
    }
    for (part, path) in parts {
        part.persist(path).map_err(|error| failed(path, error.error))?;
    }
    Ok(())
}

/// An empty file next to another, with the rights that new files have.
fn part_of(path: &Path) -> std::io::Result<NamedTempFile> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut builder = tempfile::Builder::new();
    builder.prefix(".elastogeo-").suffix(".part");
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    builder.tempfile_in(folder)
}
