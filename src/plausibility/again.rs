//! A calibration made once more with something read otherwise, and what is said where that leaves much less.

use super::shown::mm;
use crate::description::campaign::Campaign;
use crate::diagnostic::Diagnostic;
use crate::estimation::{Calibration, Settings, calibrate};
use crate::model::Model;
use crate::parameter::Slot;

/// Steps of such a fit: of 28 sound campaigns (practice and laboratory) all ended within 12, and wrong ones may take hundreds. A judgement.
const STEPS: usize = 40;

/// The parameters of a calibration fitted to its campaign read otherwise, or with another model; `None` where that does not converge.
pub(super) fn again(model: &Model, campaign: &Campaign, found: &Calibration) -> Option<Calibration> {
    fitted(model, campaign, &found.held_out, Some(found.slots.clone()))
}

/// Certain parameters fitted, by default all that the campaign asks for; `None` where that does not converge.
pub(super) fn fitted(
    model: &Model,
    campaign: &Campaign,
    held_out: &[bool],
    only: Option<Vec<Slot>>,
) -> Option<Calibration> {
    let settings = Settings { only, second_order: false, max_iterations: Some(STEPS), ..Settings::default() };
    calibrate(model, campaign, held_out, &settings, &mut |_| {}).ok().filter(Calibration::converged)
}

/// What calibration leaves before and after a change, m.
#[derive(Debug, Clone, Copy)]
pub(super) struct Fall {
    pub before: f64,
    pub after: f64,
}

impl Fall {
    pub fn between(before: &Calibration, after: &Calibration) -> Self {
        let [before, after] = [before, after].map(|of| of.after.fit.distance[1]);
        Self { before, after }
    }

    /// Whether it is at least by a factor.
    pub fn is_by(self, factor: f64) -> bool {
        self.before >= factor * self.after
    }

    /// What is said of it, `with` being the change.
    pub fn words(self, with: &str) -> String {
        format!("with {with} the error of calibration falls from {} to {} mm", mm(self.before), mm(self.after))
    }

    /// The same as figures.
    pub fn put(self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic.figure("before_mm", 1e3 * self.before).figure("after_mm", 1e3 * self.after)
    }
}
