//! What is read with which effects and kinds of readings, and which files a program has read, so that it does not write over its own inputs.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

use crate::effects::Catalogue;
use crate::observation::Kinds;

/// Reads robots, campaigns, paths, processes and tables from disk or from the bundled set, and remembers what it read from
/// disk.
#[derive(Debug)]
pub struct Reader {
    /// Effects that descriptions may switch on and campaigns may list.
    pub(super) catalogue: Arc<Catalogue>,
    /// Kinds of readings that campaigns may name.
    pub(crate) kinds: Kinds,
    /// Files on disk that were opened, by their real paths.
    read: Mutex<BTreeSet<PathBuf>>,
}

impl Default for Reader {
    /// Reads with the standard catalogue of effects.
    fn default() -> Self {
        Self::new(Catalogue::standard())
    }
}

impl From<Catalogue> for Reader {
    fn from(catalogue: Catalogue) -> Self {
        Self::new(catalogue)
    }
}

impl From<Arc<Catalogue>> for Reader {
    fn from(catalogue: Arc<Catalogue>) -> Self {
        Self::new(catalogue)
    }
}

impl Reader {
    /// Reads with a catalogue of effects, for example the standard one and those of a program, and the standard kinds of
    /// readings.
    pub fn new(catalogue: impl Into<Arc<Catalogue>>) -> Self {
        Self { catalogue: catalogue.into(), kinds: Kinds::standard(), read: Mutex::default() }
    }

    /// The same with these kinds of readings, for example the standard ones and those of a program.
    #[must_use]
    pub fn with_kinds(self, kinds: Kinds) -> Self {
        Self { kinds, ..self }
    }

    pub(super) fn remember(&self, path: &Path) {
        if let (Ok(path), Ok(mut read)) = (path.canonicalize(), self.read.lock()) {
            read.insert(path);
        }
    }

    /// Whether that file was read: to write over it would destroy an input. Devices do not count.
    pub fn has_read(&self, path: &Path) -> bool {
        path.is_file() && path.canonicalize().is_ok_and(|path| self.read.lock().is_ok_and(|read| read.contains(&path)))
    }
}
