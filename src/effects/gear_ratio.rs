//! `gear-ratio`: the joint moves in proportion more or less than commanded.

use std::sync::Arc;

use super::law::{Law, nothing};
use crate::model::{Change, EffectParameter, SiteKind};

pub(super) static LAW: Law = Law {
    name: "gear-ratio",
    sits_at: SiteKind::Joint,
    signature: "an angle of one joint that grows in proportion to the joint itself",
    remedy: "check the gear ratio in the controller; scale the joint",
    parameters: Some(|_, _, _| vec![EffectParameter::new("ratio", "1", 1e-3)]),
    changes: |_, site, _| {
        let (Some(variable), joint) = (site.coordinate, site.frame) else { return nothing() };
        Arc::new(move |context, out| out.push((0, Change::Joint(variable, context.joints[joint]))))
    },
    ..Law::NOTHING
};
