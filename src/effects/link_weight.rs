//! `link-weight`: mass or centre of mass of a link off nominal.

use super::law::Law;
use crate::model::{Family, SiteKind};

/// A link's mass may be off by half and its centre by a tenth of a metre, five times their common sizes: a judgement. What is
/// described beyond that hangs on the tool, or is an error of another law that own weight resembles.
const OFF: f64 = 5.0;

pub(super) static LAW: Law = Law {
    name: "link-weight",
    sits_at: SiteKind::Link,
    family: Some(|_| Family::Elastic),
    signature: "unloaded, the arm sags more or less than its masses say, as the posture of the link changes",
    remedy: "weigh, or identify the masses; note cables and added equipment",
    sites: Some(|model| model.sites_with_constants(&&LAW)),
    constants: |model, site, _| {
        let link = &model.frames[site.frame].name;
        model.slots_named(["mass", "x", "y", "z"].map(|symbol| format!("body{link}.{symbol}")))
    },
    greatest_amount: Some(OFF),
    ..Law::NOTHING
};
