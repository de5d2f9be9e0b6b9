//! `link-compliance`: a link bends or twists as a beam.

use super::law::Law;
use crate::model::{Family, SiteKind};

pub(super) static LAW: Law = Law {
    name: "link-compliance",
    sits_at: SiteKind::Link,
    family: Some(|_| Family::Elastic),
    signature: "under load the parts after a link turn and drop, more for forces across it, whatever its joints do",
    remedy: "identify the link as a beam (sections in the description); stiffen it",
    sites: Some(|model| model.sites_with_constants(&&LAW)),
    constants: |model, site, _| {
        let link = &model.frames[site.frame].name;
        model.slots_named(["bending_y", "bending_z", "torsion"].map(|symbol| format!("link{link}.{symbol}")))
    },
    ..Law::NOTHING
};
