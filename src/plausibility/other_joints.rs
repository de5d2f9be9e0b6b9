//! Joint columns other than those at which the model is evaluated: of commanded and recorded joints one may be nearer to what the robot did.

use super::again::{Fall, again};
use super::evidence::{Evidence, Limits};
use crate::description::campaign::Campaign;
use crate::diagnostic::{Code, Diagnostic};

/// The same calibration with the other columns, where it leaves much less.
pub(super) fn as_declared(evidence: &Evidence, limits: &Limits) -> Vec<Diagnostic> {
    let (model, campaign) = (evidence.model, evidence.campaign);
    let Some(found) = evidence.found.filter(|found| found.converged() && !campaign.is_difference()) else {
        return Vec::new();
    };
    let Some(other) = with_other_joints(campaign) else { return Vec::new() };
    let fall = again(model, &other, found).map(|again| Fall::between(found, &again));
    let Some(fall) = fall.filter(|fall| fall.is_by(limits.joints_fall)) else { return Vec::new() };
    let with = fall.words("the other column of each joint (commanded for recorded ones)");
    let diagnostic = Diagnostic::warning(format!("{with}: is that what the robot did?")).code(Code::OtherJoints).remedy(
        "say which one holds: `joints: commanded` or `joints: recorded` in the campaign; `diagnose` with `order` finds joints that were read too early",
    );
    vec![fall.put(diagnostic)]
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
