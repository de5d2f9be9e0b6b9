//! What a campaign of the bench calibrates, read off the model alone.

use crate::model::{Model, SiteKind};
use crate::parameter::{Group, Slot};

/// Compliances about their axes of all joints.
pub fn joint_compliances(model: &Model) -> Vec<Slot> {
    model.sites(SiteKind::Joint).iter().filter_map(|site| model.axial_compliance(&model.frames[site.frame])).collect()
}

/// What is fitted whatever the cause: of deflections the joints that are compliant (all where none is), of positions the free geometry and the
/// zeros of the joints.
pub fn calibrated(model: &Model, is_difference: bool) -> Vec<Slot> {
    let mut slots = if is_difference {
        let mut own = joint_compliances(model);
        let is_compliant = |slot: &Slot| model.registry[*slot].nominal != 0.0;
        if own.iter().any(is_compliant) {
            own.retain(is_compliant);
        }
        own
    } else {
        let zero = |frame: usize| {
            let actuator = model.actuators.iter().find(|actuator| actuator.joint == frame);
            actuator.map_or_else(|| model.frames[frame].moving_slot(), |actuator| actuator.slot)
        };
        let free = model.free_slots().into_iter().filter(|slot| model.registry[*slot].group == Group::Geometry);
        free.chain(model.sites(SiteKind::Joint).iter().map(|site| zero(site.frame))).collect()
    };
    slots.sort_unstable();
    slots.dedup();
    slots
}
