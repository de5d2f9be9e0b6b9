//! `geometry`: constant Khalil-Kleinfinger parameters of a frame off nominal.

use crate::model::{Effect, Family, Model, Nonlinear, Site, SiteKind};
use crate::parameter::Slot;

/// See the module.
pub struct Geometry;

impl Effect for Geometry {
    fn name(&self) -> &'static str {
        "geometry"
    }

    fn family(&self, _nonlinear: &Nonlinear) -> Family {
        Family::Geometry
    }

    fn sits_at(&self) -> SiteKind {
        SiteKind::Frame
    }

    fn signature(&self) -> &'static str {
        "grows with reach and turns with the joints before the frame; the same loaded and unloaded, warm and cold"
    }

    fn remedy(&self) -> &'static str {
        "calibrate the geometry (list `geometry` under `calibrate:`) and load the calibrated values"
    }

    fn constants(&self, model: &Model, site: &Site, _nonlinear: &Nonlinear) -> Vec<Slot> {
        let own = model.frames[site.frame].slots;
        let offset = model.frames[site.frame].moving_slot();
        let moves = model.frames[site.frame].moves();
        model.free_slots().into_iter().filter(|slot| own.contains(slot) && !(moves && *slot == offset)).collect()
    }
}
