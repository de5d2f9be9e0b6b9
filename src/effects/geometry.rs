//! `geometry`: constant Khalil-Kleinfinger parameters of a frame off nominal.

use super::law::Law;
use crate::model::{Family, SiteKind};

pub(super) static LAW: Law = Law {
    name: "geometry",
    sits_at: SiteKind::Frame,
    family: Some(|_| Family::Geometry),
    signature: "grows with reach and turns with the joints before the frame; the same loaded and unloaded, warm and cold",
    remedy: "calibrate the geometry (list `geometry` under `calibrate:`) and load the calibrated values",
    constants: |model, site, _| {
        let own = model.frames[site.frame].slots;
        let offset = model.frames[site.frame].moving_slot();
        let moves = model.frames[site.frame].moves();
        model.free_slots().into_iter().filter(|slot| own.contains(slot) && !(moves && *slot == offset)).collect()
    },
    ..Law::NOTHING
};
