//! Files written whole or not at all.

use std::path::{Path, PathBuf};

use crate::remark::Remark;

/// Whether a file can be written there, as far as can be said without writing.
///
/// # Errors
/// Why it cannot.
pub fn writable(path: &Path) -> Result<(), Remark> {
    let shown = path.display();
    if path.is_dir() {
        return Err(Remark::error(format!("`{shown}` cannot be written: it is a folder")).remedy("give a file's name"));
    }
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() && !folder.is_dir() => {
            let folder = folder.display();
            Err(Remark::error(format!("`{shown}` cannot be written: there is no folder `{folder}`"))
                .remedy("make the folder, or give another"))
        }
        _ => Ok(()),
    }
}

/// Writes files, all of them whole or none at all: each beside its target first, then in its place.
///
/// # Errors
/// What the system said, and of which file.
pub fn write_whole(files: &[(&Path, &str)]) -> Result<(), String> {
    let mut beside: Vec<(PathBuf, &Path)> = Vec::new();
    let mut outcome = Ok(());
    for (path, text) in files {
        let mut part = path.as_os_str().to_owned();
        part.push(format!(".{}.part", std::process::id()));
        let part = PathBuf::from(part);
        // A device or a pipe is written as it is: nothing can be moved into its place.
        let special = std::fs::metadata(path).is_ok_and(|known| !known.is_file());
        let written = if special { std::fs::write(path, text) } else { std::fs::write(&part, text) };
        if !special {
            beside.push((part, path));
        }
        if let Err(error) = written {
            outcome = Err(format!("`{}` cannot be written: {error}", path.display()));
            break;
        }
    }
    for (part, path) in &beside {
        if outcome.is_ok()
            && let Err(error) = std::fs::rename(part, path)
        {
            outcome = Err(format!("`{}` cannot be written: {error}", path.display()));
        }
    }
    if outcome.is_err() {
        for (part, _) in &beside {
            // It may have been moved already, or never made.
            let _ = std::fs::remove_file(part);
        }
    }
    outcome
}
