//! `settling`: a joint was read before it had come to rest after its last move.

use std::sync::Arc;

use super::law::{Law, nothing};
use crate::model::{Change, Condition, EffectParameter, Nonlinear, SiteKind};

pub(super) static LAW: Law = Law {
    name: "settling",
    sits_at: SiteKind::Joint,
    signature: "an angle of one joint in proportion to its last move",
    remedy: "wait longer before reading; evaluate at the commanded joints",
    reads: &[Condition::LastMove],
    cancels_in_differences: true,
    // Only where the campaign gives the order of its readings: that of rows may be any.
    candidates: |_, site, survey| match site.of(&survey.moves) {
        Some(true) => vec![Nonlinear::default()],
        _ => Vec::new(),
    },
    parameters: Some(|_, _, _| vec![EffectParameter::new("share", "1", 1e-3)]),
    changes: |_, site, _| {
        let Some(variable) = site.coordinate else { return nothing() };
        Arc::new(move |context, out| out.push((0, Change::Joint(variable, context.last_move[variable]))))
    },
    ..Law::NOTHING
};
