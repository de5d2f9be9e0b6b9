//! `base-compliance`: the pedestal tilts and sinks under load.

use super::law::Law;
use crate::model::{Family, SiteKind};

pub(super) static LAW: Law = Law {
    name: "base-compliance",
    sits_at: SiteKind::Base,
    family: Some(|_| Family::Elastic),
    signature: "under load the whole robot tilts about its foot, most at long reach, whatever the posture of the arm",
    remedy: "tighten or stiffen the pedestal; measure it with an indicator under load",
    constants: |model, _, _| model.slots_named(["krx", "kry", "krz", "kz"].map(|symbol| format!("base.{symbol}"))),
    ..Law::NOTHING
};
