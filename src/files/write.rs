//! Files written whole or not at all.

use std::collections::BTreeSet;
use std::fs::File;
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};

use tempfile::{NamedTempFile, TempPath};

use super::journal::{self, Entry, Journal, PREFIX};
use super::signals::Deferred;
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
    if ["yaml", "yml", "urdf", "xml", "json", "html", "htm", "pdf"].contains(&end.as_str()) {
        let message = format!("`{}`: a table is written", path.display());
        return Err(Diagnostic::error(message).remedy("give a name that ends in .csv, or in .xlsx"));
    }
    if !cfg!(feature = "xlsx") && end == "xlsx" {
        let message = format!("`{}`: this program is built without workbooks (feature `xlsx`)", path.display());
        return Err(Diagnostic::error(message).remedy("give a name that ends in .csv"));
    }
    writable(path)
}

/// Whether there is something at a path that is no file: a device or a pipe, or a folder.
pub fn is_device(path: &Path) -> bool {
    std::fs::metadata(path).is_ok_and(|known| !known.is_file())
}

/// The first file that is named again, in whatever way. Devices and pipes take all that comes.
pub fn named_twice<'a>(paths: &[&'a Path]) -> Option<&'a Path> {
    let new = |path: &Path| Some(folder_of(path).canonicalize().ok()?.join(path.file_name()?));
    let place = |path: &Path| path.canonicalize().ok().or_else(|| new(path)).unwrap_or_else(|| path.to_path_buf());
    let mut seen = BTreeSet::new();
    paths.iter().copied().filter(|path| !is_device(path)).find(|path| !seen.insert(place(path)))
}

/// Writes files, all of them whole or none at all: each next to its target first, then in its place. Where one cannot be put
/// in its place, those before it are put back as they were; where the program is killed, whoever reads or writes there next
/// puts them back. Two processes that write to one folder take turns, and a signal to end waits until the files stand.
///
/// # Errors
/// What the system reported, and of which file.
pub fn write_whole(files: &[(&Path, &[u8])]) -> Result<(), Error> {
    let failed =
        |path: &Path, error: std::io::Error| Error::from(error).at(format!("`{}` cannot be written", path.display()));
    // A device or a pipe is written as it is, and first: nothing can be moved into its place, and its reader may let it wait.
    let (devices, files): (Vec<_>, Vec<_>) = files.iter().partition(|(path, _)| is_device(path));
    for (path, content) in devices {
        std::fs::write(path, content).map_err(|error| failed(path, error))?;
    }
    let Some((first, _)) = files.first() else { return Ok(()) };
    let folders: Result<BTreeSet<PathBuf>, Error> =
        files.iter().map(|(path, _)| folder_of(path).canonicalize().map_err(|error| failed(path, error))).collect();
    let folders = folders?;
    let Some(top) = above_all(&folders) else { return Err(failed(first, ErrorKind::NotFound.into())) };
    let _turns = turns(&top, &folders).map_err(|error| failed(first, error))?;
    let _signals = Deferred::new();
    // What is not moved into its place is removed when it is dropped.
    let mut parts: Vec<(TempPath, &Path)> = Vec::new();
    for (path, content) in &files {
        let part = part_of(path).and_then(|mut part| part.write_all(content).map(|()| part));
        // Closed: there may be more files than a process may have open.
        parts.push((part.map_err(|error| failed(path, error))?.into_temp_path(), path));
    }
    if parts.len() == 1 {
        return parts.into_iter().try_for_each(|(part, path)| part.persist(path).map_err(|e| failed(path, e.error)));
    }
    let mut kept = Vec::new();
    let mut journal = Journal::default();
    for (path, content) in &files {
        let old = renamed_away(path).map_err(|error| failed(path, error))?;
        journal.files.extend(entry(&top, path, content, old.as_deref()));
        kept.extend(old);
    }
    begin(&top, &journal);
    for (part, path) in parts {
        if let Err(error) = part.persist(path) {
            match journal.undo(&top) {
                Ok(()) => end(&top),
                // It stays for the next one, with what it needs.
                Err(_) => kept.into_iter().for_each(|old| drop(old.keep())),
            }
            return Err(failed(path, error.error));
        }
    }
    end(&top);
    Ok(())
}

/// What is needed to undo the write of a file.
fn entry(top: &Path, path: &Path, content: &[u8], old: Option<&Path>) -> Option<Entry> {
    let below = |path: &Path| {
        let folder = folder_of(path).canonicalize().ok()?;
        Some(folder.strip_prefix(top).ok()?.join(path.file_name()?))
    };
    Some(Entry { path: below(path)?, new: journal::digest(content), old: old.and_then(below) })
}

/// Puts the journal in its place, if that can be written to; without one only a failure is undone, not a kill.
fn begin(top: &Path, journal: &Journal) {
    let part = serde_json::to_vec(journal).ok().zip(part_of(&journal::of(top)).ok());
    drop(
        part.and_then(|(text, mut part)| part.write_all(&text).ok().and_then(|()| part.persist(journal::of(top)).ok())),
    );
}

fn end(top: &Path) {
    drop(std::fs::remove_file(journal::of(top)));
}

/// The deepest folder that holds all of them.
fn above_all(folders: &BTreeSet<PathBuf>) -> Option<PathBuf> {
    let mut above = folders.first()?.ancestors();
    above.find(|above| folders.iter().all(|folder| folder.starts_with(above))).map(Path::to_path_buf)
}

/// Most folders that one process locks: it may not have many more files open.
const MOST_LOCKS: usize = 500;

/// Waits for other processes that write to the same folders, and removes what those that were killed have left. The turn ends
/// with the values returned; where a system cannot lock folders there are no turns.
fn turns(top: &Path, folders: &BTreeSet<PathBuf>) -> std::io::Result<Vec<File>> {
    folders.iter().try_for_each(|folder| journal::settle(folder))?;
    // In one order, so that no two processes wait for each other.
    let all: BTreeSet<&Path> = folders.iter().map(PathBuf::as_path).chain([top]).collect();
    let lock = |folder: &&Path| File::open(folder).and_then(|opened| opened.lock().map(|()| opened)).ok();
    let locked = all.iter().take(MOST_LOCKS).filter_map(lock).collect();
    journal::settle_locked(top)?;
    for folder in folders {
        let left = std::fs::read_dir(folder).into_iter().flatten().flatten().filter(|entry| {
            let name = entry.file_name();
            name.to_str().is_some_and(|name| name.starts_with(PREFIX) && (name.ends_with(PART) || name.ends_with(OLD)))
        });
        // What cannot be removed is no harm.
        left.for_each(|entry| drop(std::fs::remove_file(entry.path())));
    }
    Ok(locked)
}

/// How names of files on their way end, and those of files that are replaced.
const PART: &str = ".part";
const OLD: &str = ".old";

fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// A second name of a file that is to be replaced, or a copy where the disk has no second names; removed when dropped.
fn renamed_away(path: &Path) -> std::io::Result<Option<TempPath>> {
    if path.symlink_metadata().is_err() {
        return Ok(None);
    }
    let mut builder = tempfile::Builder::new();
    builder.prefix(PREFIX).suffix(OLD);
    let made = builder.make_in(folder_of(path), |name| {
        std::fs::hard_link(path, name).or_else(|_| std::fs::copy(path, name).map(drop))
    });
    made.map(|old| Some(old.into_temp_path()))
}

/// An empty file next to another, with the rights that new files have.
fn part_of(path: &Path) -> std::io::Result<NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(PREFIX).suffix(PART);
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    builder.tempfile_in(folder_of(path))
}
