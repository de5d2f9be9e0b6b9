//! `bearing-compliance`: tilt and radial compliance across a joint's axis.

use super::law::Law;
use crate::model::{Family, SiteKind};

pub(super) static LAW: Law = Law {
    name: "bearing-compliance",
    sits_at: SiteKind::Joint,
    family: Some(|_| Family::Elastic),
    signature: "under load the parts after one joint tilt across its axis",
    remedy: "inspect and preload the bearing; identify kr and krr",
    // Bearings sit in all joints, those that follow others or that a loop moves included.
    sites: Some(|model| model.joints_moved_by(|_| true)),
    constants: |model, site, _| {
        let joint = &model.frames[site.frame].name;
        model.slots_named(["krr", "krrx", "krry", "kr", "krx", "kry"].map(|symbol| format!("joint{joint}.{symbol}")))
    },
    ..Law::NOTHING
};
