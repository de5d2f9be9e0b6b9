//! `joint-compliance`: torsional spring about a joint's axis.

use super::law::Law;
use crate::description::robot::Motion;
use crate::model::{Family, SiteKind};

pub(super) static LAW: Law = Law {
    name: "joint-compliance",
    sits_at: SiteKind::Joint,
    family: Some(|_| Family::Elastic),
    signature: "an angle of one joint in proportion to the load on it",
    remedy: "identify the stiffness (`identify --what elastic`) and compensate; inspect the gear",
    // Joints that follow others as well: a belt gives, and has a phase. What a loop moves is held by the loop.
    sites: Some(|model| model.joints_moved_by(|motion| motion != Motion::Passive)),
    constants: |model, site, _| model.axial_compliance(&model.frames[site.frame]).into_iter().collect(),
    ..Law::NOTHING
};
