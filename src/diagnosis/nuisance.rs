//! What is re-fitted whatever is tried.

use crate::description::campaign::Campaign;
use crate::effects::Form;
use crate::model::Model;
use crate::observation::Purpose;
use crate::parameter::{Group, Slot};

/// Parameters that are re-fitted whatever is tried: those of the known effects, at all their sites.
pub fn nuisance(model: &Model, campaign: &Campaign, known: &[String]) -> Vec<Slot> {
    let mut slots = Vec::new();
    for effect in known.iter().filter_map(|name| crate::effects::by_name(name)) {
        let mut own: Vec<Slot> =
            effect.sites(model).iter().flat_map(|site| effect.constants(model, site, &Form::ONLY)).collect();
        // Where a description declares some of them to give, those are meant.
        let declared = |slot: &Slot| model.registry[*slot].nominal != 0.0;
        if own.iter().any(|slot| model.registry[*slot].group == Group::Elastic && declared(slot)) {
            own.retain(declared);
        }
        slots.extend(own);
    }
    if known.iter().any(|name| name == "geometry") {
        slots.extend(model.free_slots().into_iter().filter(|slot| model.registry[*slot].group == Group::Geometry));
    }
    if campaign.observes.purpose() == Purpose::Stiffness {
        slots.retain(|slot| model.registry[*slot].group == Group::Elastic);
    }
    slots.sort_unstable();
    slots.dedup();
    slots
}
