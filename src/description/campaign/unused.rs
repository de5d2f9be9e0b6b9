//! What a campaign declares and no reading names.

use super::raw::RawCampaign;
use super::{Campaign, LOAD_POINT, LoadPoint};
use crate::description::resolve::Locate;
use crate::diagnostic::{Diagnostic, Place};

/// Warnings of payloads, contacts and anchors that no reading names, and of points at which nothing acts.
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
        payloads.chain(contacts).chain(anchors).map(warning).chain(point_of_no_load(campaign, locate)).collect()
    }
}

/// A place of the wrench where no reading has one.
fn point_of_no_load(campaign: &Campaign, locate: Locate) -> Option<Diagnostic> {
    let mut said = campaign.readings.iter().filter(|reading| reading.load_point != LoadPoint::Measured).peekable();
    let first = *said.peek()?;
    let is_idle = said.all(|reading| reading.wrench == [0.0; 6]);
    let message = format!("`{LOAD_POINT}` says where a wrench acts, and no reading that it is said of has one");
    let place = campaign.file(first).filter(|_| first.line > 0).map(|file| Place::line_of(file, first.line));
    let remedy = "give the wrench in columns fx, fy, fz, mx, my, mz, or leave the point out; what a payload weighs acts at its own centre";
    is_idle.then(|| Diagnostic::warning(message).at(place.or_else(|| locate(&["measurements"]))).remedy(remedy))
}
