//! What is to be said of a diagnosis before its answer.

use super::amount::too_little;
use super::checks::judge_result;
use super::evidence::{Evidence, Limits};
use crate::description::campaign::Campaign;
use crate::diagnosis::{Diagnosis, Verdict};
use crate::diagnostic::{Code, Diagnostic};
use crate::model::Model;

/// Doubts about a diagnosis of a campaign: about the calibration that it starts from, and about what its readings can show.
pub fn doubts(model: &Model, campaign: &Campaign, found: &Diagnosis, limits: &Limits) -> Vec<Diagnostic> {
    let pulled = found.is_pulled.then(|| {
        Diagnostic::warning(
            "calibration with the readings alone does not converge: the tolerances of the description pull it",
        )
        .remedy("measure configurations that differ more, or hold base or tool if their place is known")
        .code(Code::WeakDirection)
    });
    let calibration = found.calibration.as_ref().map(|of| judge_result(&Evidence::with(model, campaign, of), limits));
    // What is too little is judged by the verdict's own limits.
    let about_figures =
        |diagnostic: &Diagnostic| diagnostic.code.is_about_figures() && diagnostic.code != Code::TooLittleData;
    let mut all: Vec<Diagnostic> = calibration.into_iter().flatten().filter(about_figures).collect();
    let (amount, fitted) = &found.evidence;
    let little = too_little(amount, *fitted, limits).or_else(|| {
        (found.verdict == Verdict::Undecided).then(|| {
            Diagnostic::warning("no hypothesis of the catalogue could have shown in these readings")
                .code(Code::TooLittleData)
                .remedy(
                    "measure what effects show in: loads, other configurations, sides of approach, times, temperatures",
                )
        })
    });
    all.extend(little);
    all.extend(pulled);
    all
}
