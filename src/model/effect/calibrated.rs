//! What a campaign calibrates by name, and the nuisance parameters which that are: they are calibrated with every hypothesis.

use super::{Nonlinear, Site};
use crate::description::campaign::Campaign;
use crate::model::Model;
use crate::observation::Purpose;
use crate::parameter::{Group, Slot};

/// Names for the `calibrate:` of a campaign that has none: what `identify` fits, the geometry that the description frees, or of
/// deflections its springs.
pub fn usually_calibrated(model: &Model, campaign: &Campaign) -> Vec<String> {
    let frees_geometry = || model.free_slots().iter().any(|slot| model.registry[*slot].group == Group::Geometry);
    let is_geometry = campaign.purpose() == Purpose::Geometry && frees_geometry();
    let mut names: Vec<String> = if is_geometry { vec!["geometry".into(), "joint-offset".into()] } else { Vec::new() };
    if campaign.holds_differences() {
        names.extend(all_springs(model, campaign));
    }
    names
}

/// Names for a campaign's `calibrate:` that together mean all springs which the description declares to be identified.
pub fn all_springs(model: &Model, campaign: &Campaign) -> Vec<String> {
    let mut open = model.elastic_slots();
    let mut names = Vec::new();
    for effect in model.catalogue.iter() {
        let own = nuisance(model, campaign, &[effect.name().to_string()]);
        let before = open.len();
        open.retain(|slot| !own.contains(slot));
        if open.len() < before {
            names.push(effect.name().to_string());
        }
    }
    names
}

/// Parameters of the model that are calibrated with every hypothesis: those of the `known` effects, at all
/// the joints, links and actuators that variables move, and those springs of passive joints that the description declares to be identified:
/// an identification fits them too.
pub fn nuisance(model: &Model, campaign: &Campaign, known: &[String]) -> Vec<Slot> {
    let mut slots = Vec::new();
    let declared = model.elastic_slots();
    for effect in known.iter().filter_map(|name| model.catalogue.get(name)) {
        let constants = |sites: Vec<Site>| -> Vec<Slot> {
            sites.iter().flat_map(|site| effect.constants(model, site, &Nonlinear::default())).collect()
        };
        let mut own = constants(model.sites_with_constants(effect.as_ref()));
        own.extend(constants(effect.sites(model)).into_iter().filter(|slot| declared.contains(slot)));
        // Where a description has some of them compliant, those are meant.
        let is_compliant = |slot: &Slot| model.registry[*slot].nominal != 0.0;
        if own.iter().any(|slot| model.registry[*slot].group == Group::Elastic && is_compliant(slot)) {
            own.retain(is_compliant);
        }
        slots.extend(own);
    }
    if known.iter().any(|name| name == "geometry") {
        slots.extend(model.free_slots().into_iter().filter(|slot| model.registry[*slot].group == Group::Geometry));
    }
    if campaign.purpose() == Purpose::Stiffness {
        slots.retain(|slot| model.registry[*slot].group == Group::Elastic);
    }
    slots.sort_unstable();
    slots.dedup();
    slots
}
