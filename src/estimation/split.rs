//! Readings to fit and readings to check.

use rand::SeedableRng;
use rand::seq::SliceRandom;

use crate::description::campaign::Campaign;

/// Whether each reading is set aside to check: as the campaign says, else a seeded share of the configurations. The
/// readings of one configuration are never split. With fewer than 8 configurations nothing is set aside.
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
    let mut order: Vec<usize> = (0..campaign.poses.len()).collect();
    order.shuffle(&mut rand_chacha::ChaCha8Rng::seed_from_u64(seed));
    let count = if order.len() < 8 { 0 } else { (share.clamp(0.0, 0.9) * order.len() as f64).round() as usize };
    let mut aside = vec![false; campaign.poses.len()];
    order.iter().take(count).for_each(|&pose| aside[pose] = true);
    campaign.readings.iter().map(|reading| aside[reading.pose]).collect()
}
