//! Readings to fit and readings to check.

use rand::SeedableRng;
use rand::seq::SliceRandom;

use crate::description::campaign::{Campaign, Sharing, Target};

/// Configurations below which none is held out: the errors of one or two would mean nothing.
const FEWEST: usize = 8;
/// Share of the configurations that is held out where neither the campaign nor a flag says another.
pub const CHECK: f64 = 0.25;
/// Seed by which `identify` draws what is held out where none is given.
pub const SEED: u64 = 1;
/// Greatest share that is held out.
const MOST: f64 = 0.9;

/// Whether each reading is held out to check: as the campaign marks them, else a seeded share (0 to 0.9) of the
/// configurations. The readings of one configuration are never split. With fewer than 8 configurations none is held out, and of a
/// session or station with a base, a tool or a scale of its own never so many that fewer than 8 stay to fit; of an anchor or contact
/// whose place is sought never so many that fewer stay than it has unknowns.
///
/// ```
/// let campaign = elastogeo::files::load_campaign("kr270-simulated", None)?.campaign;
/// let held_out = elastogeo::estimation::split(&campaign, 0.25, 1);
/// // The file marks 12 of the 30 configurations, with 9 readings each.
/// assert_eq!(held_out.iter().filter(|held_out| **held_out).count(), 108);
/// # Ok::<(), elastogeo::Error>(())
/// ```
pub fn split(campaign: &Campaign, share: f64, seed: u64) -> Vec<bool> {
    if campaign.readings.iter().any(|reading| reading.check.is_some()) {
        return campaign.readings.iter().map(|reading| reading.check == Some(true)).collect();
    }
    let configurations = campaign.neighbourhoods();
    let mut order: Vec<usize> = (0..campaign.poses.len()).filter(|&pose| configurations[pose] == pose).collect();
    order.shuffle(&mut rand_chacha::ChaCha8Rng::seed_from_u64(seed));
    let count = if order.len() < FEWEST { 0 } else { (share.clamp(0.0, MOST) * order.len() as f64).round() as usize };
    let mut held_out = vec![false; campaign.poses.len()];
    let parts = parts(campaign, &configurations);
    let fewest = fewest(campaign);
    let mut left = vec![0; fewest.len()];
    order.iter().flat_map(|&pose| &parts[pose]).for_each(|&part| left[part] += 1);
    let mut out = 0;
    for &pose in &order {
        if out < count && parts[pose].iter().all(|&part| left[part] > fewest[part]) {
            parts[pose].iter().for_each(|&part| left[part] -= 1);
            held_out[pose] = true;
            out += 1;
        }
    }
    campaign.readings.iter().map(|reading| held_out[configurations[reading.pose]]).collect()
}

/// Parts of a campaign with something of their own to estimate, numbered through: sessions, stations, targets; of each the
/// configurations that stay to be fitted.
fn fewest(campaign: &Campaign) -> Vec<usize> {
    let sessions = &campaign.sessions;
    let unknowns = |target: &Target| target.values.iter().filter(|value| value.parameter.is_some()).count();
    let of_sessions = std::iter::repeat_n(FEWEST, sessions.names.len() + sessions.stations.len());
    of_sessions.chain(campaign.targets.iter().map(unknowns)).collect()
}

/// Of each configuration, the parts by which it is read, numbered as [`fewest`].
fn parts(campaign: &Campaign, configurations: &[usize]) -> Vec<Vec<usize>> {
    let sessions = &campaign.sessions;
    let mut found: Vec<Vec<usize>> = vec![Vec::new(); campaign.poses.len()];
    for reading in &campaign.readings {
        let of_sessions =
            [sessions.base, sessions.tool, sessions.scale].into_iter().filter_map(|shared| match shared {
                Sharing::All => None,
                Sharing::PerSession => Some(reading.session.part(shared)),
                Sharing::PerStation => Some(sessions.names.len() + reading.session.part(shared)),
            });
        let of_target = reading.target.map(|target| sessions.names.len() + sessions.stations.len() + target);
        let own = &mut found[configurations[reading.pose]];
        for part in of_sessions.chain(of_target) {
            if !own.contains(&part) {
                own.push(part);
            }
        }
    }
    found
}
