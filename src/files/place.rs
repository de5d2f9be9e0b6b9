//! Where texts come from: the disk, or the set bundled with the program.

use std::io::Read;
use std::path::{Path, PathBuf};

use include_dir::{Dir, include_dir};

use super::journal::settle;
use super::reader::Reader;
use crate::description::table::workbook_name;
use crate::description::yaml;
use crate::diagnostic::{Diagnostic, Diagnostics, nearest};

static ROBOTS: Dir = include_dir!("$CARGO_MANIFEST_DIR/robots");
pub(super) static CAMPAIGNS: Dir = include_dir!("$CARGO_MANIFEST_DIR/campaigns");
pub(super) static PROCESSES: Dir = include_dir!("$CARGO_MANIFEST_DIR/processes");

/// What the names of bundled files begin with.
pub(super) const BUNDLED: &str = "bundled:";

/// Most bytes of a description or campaign file.
const MOST_BYTES: u64 = 20 << 20;

/// Names of the bundled robots.
///
/// ```
/// assert!(elastogeo::files::bundled_robots().contains(&"kuka-kr270".to_string()));
/// ```
pub fn bundled_robots() -> Vec<String> {
    let mut names: Vec<String> = ROBOTS
        .files()
        .filter(|file| file.path().extension().is_some_and(|e| e == "yaml"))
        .filter_map(|file| Some(file.path().file_stem()?.to_str()?.to_string()))
        .collect();
    names.sort();
    names
}

/// Where a file's text comes from: the disk, or the bundled set.
#[derive(Debug)]
pub(super) enum Place {
    Disk(PathBuf),
    Bundled(PathBuf),
}

impl Place {
    pub(super) fn name(&self) -> String {
        match self {
            Self::Disk(path) => path.display().to_string(),
            Self::Bundled(path) => format!("{BUNDLED}{}", path.display()),
        }
    }

    pub(super) fn next_to(&self, file: &str) -> Self {
        match self {
            Self::Disk(path) => Self::Disk(path.parent().unwrap_or(Path::new("")).join(file)),
            Self::Bundled(path) => Self::Bundled(path.parent().unwrap_or(Path::new("")).join(file)),
        }
    }

    pub(super) fn text(&self, reader: &Reader) -> Result<String, Vec<Diagnostic>> {
        let name = self.name();
        let bytes = match self {
            Self::Disk(path) => {
                let failed = |error: std::io::Error| vec![unreadable(path, &error)];
                settle(path.parent().unwrap_or(path)).map_err(failed)?;
                let mut bytes = Vec::new();
                // One byte more than is allowed tells that there is more; a device has no length to ask for.
                let file = std::fs::File::open(path).map_err(failed)?;
                reader.remember(path);
                let read = file.take(MOST_BYTES + 1).read_to_end(&mut bytes).map_err(failed)?;
                if read as u64 > MOST_BYTES {
                    return Err(vec![
                        Diagnostic::error(format!("`{name}` has more than {MOST_BYTES} bytes")).remedy(
                            "a description or campaign file is small; readings belong in the CSV that it names",
                        ),
                    ]);
                }
                bytes
            }
            Self::Bundled(path) => {
                let file = ROBOTS.get_file(path).or_else(|| CAMPAIGNS.get_file(path));
                let file = file.or_else(|| PROCESSES.get_file(path));
                file.ok_or_else(|| vec![Diagnostic::error(format!("`{name}` is not bundled"))])?.contents().to_vec()
            }
        };
        yaml::text_of(&name, &bytes).map_err(|diagnostic| vec![diagnostic])
    }

    pub(super) fn is_urdf(&self) -> bool {
        let (Self::Disk(path) | Self::Bundled(path)) = self;
        path.extension().is_some_and(|extension| ["urdf", "xml", "xacro"].iter().any(|end| extension == *end))
    }
}

impl Reader {
    /// The text of a file on disk.
    ///
    /// # Errors
    /// Why it cannot be read as text.
    pub fn text(&self, path: &Path) -> Result<String, Diagnostics> {
        Ok(Place::Disk(path.into()).text(self)?)
    }

    /// Opens a table on disk.
    ///
    /// # Errors
    /// Why it cannot be read, with the nearest file name in its folder where there is none.
    pub fn table(&self, path: &Path) -> Result<Box<dyn Read>, Diagnostic> {
        open(self, &Place::Disk(path.into()))
    }
}

/// Keys that only campaigns have.
pub(super) const KEYS_OF_CAMPAIGN: &[&str] = &["measurements", "observes", "campaign"];

/// What to give instead of a folder: the files in it that may be meant.
pub(super) fn inside(folder: &Path) -> String {
    let entries = std::fs::read_dir(folder).into_iter().flatten().take(10_000).flatten();
    let mut names: Vec<String> = entries
        .map(|entry| entry.path())
        .filter(|path| {
            path.extension().is_some_and(|end| ["yaml", "yml", "urdf", "csv", "xlsx"].iter().any(|e| end == *e))
        })
        .map(|path| format!("`{}`", path.display()))
        .collect();
    names.sort();
    let more = if names.len() > 5 { ", .." } else { "" };
    names.truncate(5);
    if names.is_empty() { "give a file".into() } else { format!("give a file in it: {}{more}", names.join(", ")) }
}

/// Why a file cannot be read, with the nearest file name in its folder where there is none.
fn unreadable(path: &Path, error: &std::io::Error) -> Diagnostic {
    let shown = path.display();
    if error.kind() != std::io::ErrorKind::NotFound {
        return if path.is_dir() {
            Diagnostic::error(format!("`{shown}` is a folder, and a file is needed")).remedy(inside(path))
        } else {
            Diagnostic::error(format!("`{shown}` cannot be read: {error}"))
        };
    }
    if path.as_os_str().is_empty() {
        return Diagnostic::error("no file is named").remedy("add `file:`, the name of a table");
    }
    let diagnostic = Diagnostic::error(format!("there is no file `{shown}`"));
    let folder = match path.parent() {
        Some(parent) if parent.as_os_str().is_empty() => Path::new("."),
        Some(parent) => parent,
        None => return diagnostic,
    };
    if !folder.is_dir() {
        return diagnostic.remedy(format!("there is no folder `{}` either", folder.display()));
    }
    let (Ok(entries), Some(wanted)) = (std::fs::read_dir(folder), path.file_name().and_then(|name| name.to_str()))
    else {
        return diagnostic;
    };
    let mut names: Vec<String> =
        entries.take(10_000).flatten().filter_map(|entry| entry.file_name().into_string().ok()).collect();
    names.sort();
    match nearest(wanted, names.iter().map(String::as_str)) {
        Some(near) => diagnostic.remedy(format!("did you mean `{}`?", path.with_file_name(near).display())),
        None => diagnostic,
    }
}

/// Opens a file of measurements: of a sheet of a workbook the workbook.
pub(super) fn open(reader: &Reader, place: &Place) -> Result<Box<dyn Read>, Diagnostic> {
    match place {
        Place::Disk(path) => {
            let name = path.to_str().and_then(workbook_name).map(|(workbook, _)| Path::new(workbook));
            open_on_disk(reader, name.unwrap_or(path))
        }
        Place::Bundled(path) => match CAMPAIGNS.get_file(path).or_else(|| PROCESSES.get_file(path)) {
            Some(found) => Ok(Box::new(found.contents())),
            None => Err(Diagnostic::error(format!("`{}` is not bundled", place.name()))),
        },
    }
}

fn open_on_disk(reader: &Reader, path: &Path) -> Result<Box<dyn Read>, Diagnostic> {
    if path.is_dir() {
        let diagnostic = Diagnostic::error(format!("`{}` is a folder, and a CSV file is needed", path.display()));
        return Err(diagnostic.remedy(inside(path)));
    }
    let file = settle(path.parent().unwrap_or(path)).and_then(|()| std::fs::File::open(path));
    let file = file.map_err(|error| unreadable(path, &error))?;
    reader.remember(path);
    Ok(Box::new(file))
}
