//! What a Python program adds of its own: effects and kinds of readings.

use std::sync::Arc;

use elastogeo::effects::{Catalogue, Effect};
use elastogeo::files::Reader;
use elastogeo::model::Model;
use elastogeo::observation::Kinds;
use pyo3::prelude::*;

use crate::effect::PythonEffect;
use crate::error::fault;
use crate::faults::Faults;
use crate::observation::Kind;

/// What a program adds of its own: the reader that knows its effects and kinds of readings, and what they raise.
pub struct Own {
    pub catalogue: Arc<Catalogue>,
    pub kinds: Kinds,
    pub faults: Faults,
}

impl Own {
    /// Reads with them.
    pub fn reader(&self) -> Reader {
        Reader::new(Arc::clone(&self.catalogue)).with_kinds(self.kinds.clone())
    }
}

/// Asks all effects for their sites: one that names a site which the robot has not says so.
pub fn look_for_sites(effects: &Catalogue, model: &Model) {
    effects.iter().for_each(|effect| drop(effect.sites(model)));
}

/// Effects and kinds of readings of a program next to the standard ones.
pub fn own(py: Python<'_>, effects: &[Bound<'_, PyAny>], kinds: &[Bound<'_, Kind>]) -> PyResult<Own> {
    let (mut catalogue, mut faults) = (Catalogue::standard(), Faults::new());
    for effect in effects {
        let own = PythonEffect::new(py, effect, faults.clone())?;
        if Catalogue::standard().get(own.name()).is_some() {
            let message = format!("`{}` is an effect of elastogeo itself", own.name());
            return Err(fault(py, message, "give yours another name"));
        }
        catalogue = catalogue.with(own);
    }
    let mut known = Kinds::standard();
    for kind in kinds {
        faults = faults.and(kind.get().faults());
        known = known.with(kind.get().observes()).map_err(|known| {
            let message = format!("`{}` is a kind of readings of elastogeo itself", known.name());
            fault(py, message, "give yours another name")
        })?;
    }
    Ok(Own { catalogue: catalogue.into(), kinds: known, faults })
}
