//! Exceptions that a program's own effects and kinds of readings raise while they are evaluated.

use std::sync::{Arc, Mutex};

use pyo3::prelude::*;

/// The first exception that effects or kinds of readings raised while they were evaluated: of effects in the first place, of
/// each kind in one of its own.
#[derive(Clone)]
pub struct Faults(Vec<Arc<Mutex<Option<PyErr>>>>);

impl Faults {
    /// A place for one.
    pub fn new() -> Self {
        Self(vec![Arc::default()])
    }

    /// With those of a kind of readings.
    pub fn and(mut self, kind: &Self) -> Self {
        self.0.extend(kind.0.iter().cloned());
        self
    }

    /// What was found, or the exception that an effect or a kind of readings raised meanwhile.
    pub fn first<T>(&self, found: PyResult<T>) -> PyResult<T> {
        let taken = |place: &Arc<Mutex<Option<PyErr>>>| place.lock().ok()?.take();
        self.0.iter().find_map(taken).map_or(found, Err)
    }

    pub fn keep(&self, raised: PyErr) {
        if let Some(mut first) = self.0.first().and_then(|place| place.lock().ok()) {
            first.get_or_insert(raised);
        }
    }
}
