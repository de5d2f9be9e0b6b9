//! `outliers`: single readings that are wrong.

use super::law::Law;
use crate::model::{Family, SiteKind};

pub(super) static LAW: Law = Law {
    name: "outliers",
    sits_at: SiteKind::Instrument,
    family: Some(|_| Family::Gross),
    signature: "single readings far from all others, without pattern",
    remedy: "look at the readings named; repeat them",
    // Outliers are found after the other effects, from the residuals: they are not among the hypotheses.
    candidates: |_, _, _| Vec::new(),
    ..Law::NOTHING
};
