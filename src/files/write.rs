//! Files written whole or not at all.

use std::fs::File;
use std::io::Write;
use std::path::Path;

use tempfile::{NamedTempFile, TempPath};

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

/// Writes files, all of them whole or none at all: each next to its target first, then in its place. Where one cannot be put
/// in its place, those before it are put back as they were. Two processes that write to one folder take turns.
///
/// # Errors
/// What the system reported, and of which file.
pub fn write_whole(files: &[(&Path, &[u8])]) -> Result<(), Error> {
    let failed =
        |path: &Path, error: std::io::Error| Error::from(error).at(format!("`{}` cannot be written", path.display()));
    let _turns = turns(files);
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
    let mut placed: Vec<(Option<TempPath>, &Path)> = Vec::new();
    for (part, path) in parts {
        let put = aside(path).and_then(|old| part.persist(path).map(|_| old).map_err(|error| error.error));
        match put {
            Ok(old) => placed.push((old, path)),
            Err(error) => {
                placed.into_iter().rev().for_each(|(old, path)| put_back(old, path));
                return Err(failed(path, error));
            }
        }
    }
    Ok(())
}

/// Waits for other processes that write to the same folders, and removes what those that were killed have left. The turn ends
/// with the values returned; where a system cannot lock folders there are no turns.
fn turns(files: &[(&Path, &[u8])]) -> Vec<File> {
    let mut folders: Vec<&Path> = files.iter().map(|(path, _)| folder_of(path)).collect();
    // In one order, so that no two processes wait for each other.
    folders.sort_unstable();
    folders.dedup();
    let turn = |folder: &&Path| {
        let locked = File::open(folder).and_then(|opened| opened.lock().map(|()| opened)).ok()?;
        let left = std::fs::read_dir(folder).into_iter().flatten().flatten().filter(|entry| {
            let name = entry.file_name();
            name.to_str().is_some_and(|name| name.starts_with(PREFIX) && name.ends_with(PART))
        });
        // What cannot be removed is no harm.
        left.for_each(|entry| drop(std::fs::remove_file(entry.path())));
        Some(locked)
    };
    folders.iter().filter_map(turn).collect()
}

/// Names of files on their way.
const PREFIX: &str = ".elastogeo-";
const PART: &str = ".part";

fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// A second name of a file that is to be replaced, or a copy where the disk knows no second names; removed when dropped.
fn aside(path: &Path) -> std::io::Result<Option<TempPath>> {
    if !path.exists() {
        return Ok(None);
    }
    let mut builder = tempfile::Builder::new();
    builder.prefix(PREFIX).suffix(".old");
    let made = builder.make_in(folder_of(path), |name| {
        std::fs::hard_link(path, name).or_else(|_| std::fs::copy(path, name).map(drop))
    });
    made.map(|old| Some(old.into_temp_path()))
}

/// What stood there before: the old file, or none. What cannot be put back stays beside its place.
fn put_back(old: Option<TempPath>, path: &Path) {
    match old {
        Some(old) => {
            if let Err(error) = old.persist(path) {
                drop(error.path.keep());
            }
        }
        None => drop(std::fs::remove_file(path)),
    }
}

/// An empty file next to another, with the rights that new files have.
fn part_of(path: &Path) -> std::io::Result<NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(PREFIX).suffix(PART);
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    builder.tempfile_in(folder_of(path))
}
