//! What is to be said of a diagnosis before its answer.

use crate::diagnosis::Diagnosis;
use crate::diagnostic::{Code, Diagnostic};

/// Doubts about a diagnosis.
pub fn doubts(found: &Diagnosis) -> Vec<Diagnostic> {
    let pulled = found.is_pulled.then(|| {
        Diagnostic::warning(
            "calibration with the readings alone does not converge: the tolerances of the description pull it",
        )
        .remedy("measure configurations that differ more, or hold base or tool if their place is known")
        .code(Code::WeakDirection)
    });
    pulled.into_iter().collect()
}
