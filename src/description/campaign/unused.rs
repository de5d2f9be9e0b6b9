//! What a campaign declares and no reading names.

use super::Campaign;
use super::raw::RawCampaign;
use crate::description::resolve::Locate;
use crate::diagnostic::Diagnostic;

/// Warnings of payloads, contacts and anchors that no reading names.
pub fn unused(campaign: &Campaign, raw: &RawCampaign, locate: Locate) -> Vec<Diagnostic> {
    let carries = |name: &str| {
        let own = campaign.payloads.iter().find(|(known, _)| known == name).map(|(_, payload)| *payload);
        campaign.readings.iter().any(|reading| reading.payload.is_some() && reading.payload == own)
    };
    let refers = |name: &str| {
        let mut named = campaign.readings.iter().filter_map(|reading| campaign.targets.get(reading.target?));
        named.any(|target| target.member.0 == name)
    };
    let payloads = raw.payloads.keys().filter(|name| !carries(name)).map(|name| ("payloads", "payload", name));
    let contacts = raw.contacts.keys().filter(|name| !refers(name)).map(|name| ("contacts", "contact", name));
    let anchors = raw.anchors.keys().filter(|name| !refers(name)).map(|name| ("anchors", "anchor", name));
    let warning = |(section, column, name): (&str, &str, &String)| {
        Diagnostic::warning(format!("{column} `{name}` is declared, and no reading names it"))
            .at(locate(&[section, name]))
            .remedy(format!("name it in the column `{column}` of its rows, or at the entry of its file; or remove it"))
    };
    if campaign.readings.is_empty() {
        Vec::new()
    } else {
        payloads.chain(contacts).chain(anchors).map(warning).collect()
    }
}
