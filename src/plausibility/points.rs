//! Points of the robot: two do not stand in one place.

use std::collections::HashMap;

use super::evidence::{Evidence, Limits};
use crate::diagnostic::Diagnostic;

/// Least share of the readings that agree with those of another point: single ones are chance, of coarse readings.
const COPIED: f64 = 0.1;

/// Readings of two points that agree to the last digit: one was pasted in place of the other.
pub(super) fn apart(evidence: &Evidence, _: &Limits) -> Vec<Diagnostic> {
    let (model, campaign) = (evidence.model, evidence.campaign);
    let mut seen: HashMap<_, usize> = HashMap::new();
    let mut copied: Vec<(usize, usize)> = Vec::new();
    for (index, reading) in campaign.readings.iter().enumerate() {
        // Single numbers, as of torques, agree by chance.
        if reading.observes.length_rows() < 2 {
            continue;
        }
        let measured = reading.measured.iter().take(reading.observes.columns().len());
        let bits: Vec<u64> = measured.map(|value| value.to_bits()).collect();
        let first = *seen.entry((reading.pose, reading.observes.name(), reading.target, bits)).or_insert(index);
        if campaign.readings[first].marker != reading.marker {
            copied.push((first, index));
        }
    }
    let Some(&(first, index)) = copied.first() else { return Vec::new() };
    let (count, all) = (copied.len(), campaign.readings.len());
    if (count as f64) < COPIED * all as f64 {
        return Vec::new();
    }
    let name = |reading: usize| {
        campaign.readings[reading].marker.map_or("the tool", |marker| model.markers[marker].name.as_str())
    };
    let message = format!(
        "{count} of {all} readings are those of another point to the last digit: {} in place of {}, first {}",
        name(first),
        name(index),
        campaign.address(&campaign.readings[index])
    );
    let remedy = "give each point its own readings; two points cannot coincide";
    vec![Diagnostic::warning(message).remedy(remedy).figure("readings", count as f64)]
}
