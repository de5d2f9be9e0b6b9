//! What undoes a write of several files that was cut off: a journal in the folder that holds them all, and whoever reads or
//! writes there next.

use std::fs::{self, File};
use std::io::{Error, ErrorKind};
use std::path::{Component, Path, PathBuf};

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

/// What names of files begin with that are ours alone.
pub(super) const PREFIX: &str = ".elastogeo-";
/// While it stands, its files are on their way; to remove it ends the write of all of them.
const NAME: &str = ".elastogeo-journal";

/// Files that are being written, all or none.
#[derive(Debug, Default, Serialize, Deserialize)]
pub(super) struct Journal {
    pub(super) files: Vec<Entry>,
}

/// One of them; paths are below the journal's folder.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct Entry {
    pub(super) path: PathBuf,
    /// Digest of the new content: what is in its place and is not this was not put there by the write.
    pub(super) new: String,
    /// Where the file that stood there is kept, if there was one.
    pub(super) old: Option<PathBuf>,
}

pub(super) fn digest(content: &[u8]) -> String {
    Sha256::digest(content).iter().map(|byte| format!("{byte:02x}")).collect()
}

pub(super) fn of(folder: &Path) -> PathBuf {
    folder.join(NAME)
}

impl Journal {
    /// Puts back what stood in the places of the files; what someone has changed since stays.
    pub(super) fn undo(&self, folder: &Path) -> Result<(), Error> {
        for Entry { path, new, old } in &self.files {
            let target = folder.join(path);
            if !fs::read(&target).is_ok_and(|content| digest(&content) == *new) {
                continue;
            }
            match old.as_ref().map(|old| folder.join(old)) {
                Some(old) if old.symlink_metadata().is_ok() => fs::rename(old, target)?,
                Some(_) => {}
                None => fs::remove_file(target)?,
            }
        }
        Ok(())
    }

    /// Whether nothing of it leads out of its folder, and to nobody else's files: it may have come with a download.
    fn stays_within(&self, folder: &Path) -> bool {
        let is_below = |path: &Path| {
            path.components().all(|part| matches!(part, Component::Normal(_)))
                && folder.join(path).parent().and_then(|parent| parent.canonicalize().ok()).is_none_or(|parent| {
                    parent.starts_with(folder)
                        && owner(&folder.join(path)).is_none_or(|own| Some(own) == owner(&of(folder)))
                })
        };
        let is_ours =
            |path: &Path| path.file_name().and_then(|name| name.to_str()).is_some_and(|n| n.starts_with(PREFIX));
        self.files
            .iter()
            .all(|entry| is_below(&entry.path) && entry.old.as_ref().is_none_or(|old| is_below(old) && is_ours(old)))
    }
}

/// Owner of a file, where the system has one.
fn owner(path: &Path) -> Option<u32> {
    #[cfg(unix)]
    return path.symlink_metadata().ok().map(|known| std::os::unix::fs::MetadataExt::uid(&known));
    #[cfg(not(unix))]
    return path.symlink_metadata().ok().map(|_| 0);
}

/// Undoes writes that were cut off in a folder or above it. Waits for those that are still going on.
///
/// # Errors
/// What is half written and cannot be restored.
pub fn settle(folder: &Path) -> Result<(), Error> {
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let Ok(folder) = folder.canonicalize() else { return Ok(()) };
    for above in folder.ancestors().filter(|above| of(above).is_file()) {
        // Where folders cannot be locked it is not known whether the writer is still at work.
        if let Ok(locked) = File::open(above).and_then(|opened| opened.lock().map(|()| opened)) {
            settle_locked(above)?;
            drop(locked);
        }
    }
    Ok(())
}

/// The same for the folder alone, of which it is this process's turn.
pub(super) fn settle_locked(folder: &Path) -> Result<(), Error> {
    let text = match fs::read(of(folder)) {
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(()),
        text => text?,
    };
    // A journal is put in its place whole: another one is not ours, and says nothing.
    let known = serde_json::from_slice(&text).ok().filter(|journal: &Journal| journal.stays_within(folder));
    let Some(journal) = known else { return Ok(()) };
    let undone = journal.undo(folder).and_then(|()| fs::remove_file(of(folder)));
    journal.files.iter().filter_map(|entry| entry.old.as_ref()).filter(|_| undone.is_ok()).for_each(|old| {
        // What is kept of the old file is no harm.
        drop(fs::remove_file(folder.join(old)));
    });
    undone.map_err(|error| {
        let shown = folder.display();
        Error::new(error.kind(), format!("files in `{shown}` are half written and cannot be restored: {error}"))
    })
}
