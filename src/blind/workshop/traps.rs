//! Readings that are not what they are said to be.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use crate::description::campaign::Campaign;

/// Millimetres of an inch, and of a metre.
const UNITS: [f64; 3] = [1.0 / 25.4, 25.4, 1e-3];

/// Spoils a campaign and its hold-out; what was done, in words.
pub fn spoil(both: [&mut Campaign; 2], random: &mut ChaCha8Rng) -> &'static str {
    let markers = both[0].readings.iter().filter_map(|reading| reading.marker).max().map_or(1, |last| last + 1);
    let kinds = match (markers > 1, both[0].is_difference()) {
        (true, false) => &["one marker in other units", "markers swapped", "joint the other way", "mirrored axis"][..],
        (true, true) => &["one marker in other units", "mirrored axis"],
        (false, false) => &["joint the other way", "mirrored axis"],
        (false, true) => &["mirrored axis"],
    };
    let kind = kinds[random.random_range(0..kinds.len())];
    let units = UNITS[random.random_range(0..UNITS.len())];
    let variable = random.random_range(0..both[0].variables.max(1));
    let marker = random.random_range(0..markers);
    for campaign in both {
        let count = campaign.variables;
        match kind {
            "joint the other way" => {
                campaign.joints.chunks_exact_mut(count).for_each(|q| q[variable] = -q[variable]);
            }
            "markers swapped" => {
                let other = (marker + 1) % markers;
                for own in campaign.readings.iter_mut().filter_map(|reading| reading.marker.as_mut()) {
                    *own = if *own == marker {
                        other
                    } else if *own == other {
                        marker
                    } else {
                        *own
                    };
                }
            }
            "mirrored axis" => campaign.readings.iter_mut().for_each(|reading| reading.measured[1] *= -1.0),
            _ => {
                let own = campaign.readings.iter_mut().filter(|reading| reading.marker == Some(marker));
                own.for_each(|reading| reading.measured.iter_mut().for_each(|value| *value *= units));
            }
        }
    }
    kind
}
