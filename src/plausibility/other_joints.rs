//! Joint columns other than those at which the model is evaluated: of commanded and recorded joints one may be nearer to what the robot did.

use super::evidence::{Evidence, Limits};
use super::shown::mm;
use crate::description::campaign::Campaign;
use crate::diagnostic::{Code, Diagnostic};
use crate::estimation::{Settings, calibrate};

/// The same calibration with the other columns, where it leaves much less.
pub(super) fn as_declared(evidence: &Evidence, limits: &Limits) -> Vec<Diagnostic> {
    let (model, campaign) = (evidence.model, evidence.campaign);
    let Some(found) = evidence.found.filter(|found| found.converged() && !campaign.is_difference()) else {
        return Vec::new();
    };
    let Some(other) = with_other_joints(campaign) else { return Vec::new() };
    let settings = Settings { only: Some(found.slots.clone()), second_order: false, ..Settings::default() };
    let Ok(again) = calibrate(model, &other, &found.held_out, &settings, &mut |_| {}) else { return Vec::new() };
    let [here, there] = [found, &again].map(|of| of.after.fit.distance[1]);
    if !again.converged() || here < limits.joints_fall * there {
        return Vec::new();
    }
    let message = format!(
        "with the other column of each joint (commanded for recorded ones) the error of calibration falls from {} to {} mm: is that what the \
         robot did?",
        mm(here),
        mm(there)
    );
    let diagnostic = Diagnostic::warning(message).code(Code::OtherJoints).remedy(
        "say which one holds: `joints: commanded` or `joints: recorded` in the campaign; `diagnose` with `order` finds joints that were read too early",
    );
    vec![diagnostic.figure("before_mm", 1e3 * here).figure("after_mm", 1e3 * there)]
}

/// The campaign at its other joints; `None` where no row has any.
fn with_other_joints(campaign: &Campaign) -> Option<Campaign> {
    let mut other = campaign.clone();
    let count = campaign.variables.max(1);
    let mut differs = false;
    for (reading, q) in other.joints.chunks_mut(count).enumerate() {
        for (value, column) in q.iter_mut().zip(&campaign.conditions.other_joints) {
            let known = column.as_ref().and_then(|column| column.get(reading)).filter(|value| value.is_finite());
            if let Some(known) = known {
                differs |= *known != *value;
                *value = *known;
            }
        }
    }
    differs.then_some(other)
}
