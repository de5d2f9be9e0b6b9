//! How many readings each part of a campaign has, and what puts them in order.

use std::collections::HashSet;

use indexmap::IndexMap;
use serde::Serialize;

use crate::description::campaign::{Campaign, OrderBy, Reading};

/// Readings of a part.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct PartCount {
    /// `session`, `station`, `file`, `contact`, `anchor`, `payload`, or the column of a group of contacts, as `placement`.
    pub part: String,
    /// Name of the part, as the files write it.
    pub name: String,
    /// Readings that belong to it.
    pub readings: usize,
    /// Configurations at which they were taken.
    pub configurations: usize,
}

/// What says which reading came before which.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct ReadingOrder {
    /// `order` (the column), `time` (the column), `rows`, `stated-rows` (as the campaign says) or `unknown` (as it says too).
    pub by: &'static str,
    /// Whether a column or the campaign says so.
    pub stated: bool,
}

impl ReadingOrder {
    /// Of a campaign.
    pub fn new(campaign: &Campaign) -> Self {
        let by = match campaign.conditions.order {
            OrderBy::Rows => "rows",
            OrderBy::TimesAndRows => "time-and-rows",
            OrderBy::StatedRows => "stated-rows",
            OrderBy::Unknown => "unknown",
            OrderBy::Times => "time",
            OrderBy::Numbers => "order",
        };
        let by_rows = matches!(campaign.conditions.order, OrderBy::Rows | OrderBy::TimesAndRows);
        Self { by, stated: !by_rows }
    }
}

/// Readings of each part that has a name, and of the files where there are several.
pub fn part_counts(campaign: &Campaign) -> Vec<PartCount> {
    let mut found: IndexMap<(String, String), (usize, HashSet<usize>)> = IndexMap::new();
    for reading in &campaign.readings {
        for (part, name) in parts_of(campaign, reading) {
            let (count, poses) = found.entry((part, name)).or_default();
            *count += 1;
            poses.insert(reading.pose);
        }
    }
    let count = |((part, name), (readings, poses)): ((String, String), (usize, HashSet<usize>))| PartCount {
        part,
        name,
        readings,
        configurations: poses.len(),
    };
    let mut counts: Vec<PartCount> = found.into_iter().map(count).collect();
    // Parts of one kind together, in the order in which the kinds first come.
    let mut kinds: Vec<String> = Vec::new();
    counts.iter().for_each(|own| {
        if !kinds.contains(&own.part) {
            kinds.push(own.part.clone());
        }
    });
    counts.sort_by_key(|own| kinds.iter().position(|kind| *kind == own.part));
    counts
}

/// Parts to which a reading belongs, with their names.
fn parts_of(campaign: &Campaign, reading: &Reading) -> Vec<(String, String)> {
    let sessions = &campaign.sessions;
    let mut parts = Vec::new();
    let mut add = |part: &str, name: &str| {
        if !name.is_empty() {
            parts.push((part.to_owned(), name.to_owned()));
        }
    };
    add("session", sessions.names.get(reading.session.session).map_or("", String::as_str));
    add("station", sessions.stations.get(reading.session.station).map_or("", String::as_str));
    if campaign.files.len() > 1 {
        add("file", campaign.file(reading).unwrap_or_default());
    }
    if let Some(target) = campaign.target_of(reading) {
        let is_contact = target.is_contact();
        if is_contact || target.is_anchor() {
            add(if is_contact { "contact" } else { "anchor" }, &target.member.0);
        }
        // Sessions and stations are parts of their own.
        if let Some([group, member]) =
            target.member.1.as_ref().filter(|[group, _]| group != "session" && group != "station")
        {
            add(group, member);
        }
    }
    if !campaign.payloads.is_empty() {
        let own = campaign.payloads.iter().find(|(_, known)| Some(*known) == reading.payload);
        add("payload", own.map_or("none", |(name, _)| name));
    }
    parts
}
