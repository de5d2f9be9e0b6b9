//! Sessions that calibration describes one by one and not together: another robot of the type, a joint set anew, a part that was
//! exchanged between them.

use super::again::fitted;
use super::evidence::{Evidence, Limits};
use super::sessions::{agree_calibrated, differ, left, left_words, parts};
use super::trial::noise;
use crate::description::campaign::Campaign;
use crate::diagnostic::{Code, Diagnostic};

/// What calibration leaves falls at least by this factor with constants of their own for each session: those of each session also take up
/// what load or region make different, and most of the error is then still left. A judgement.
const FALL: f64 = 3.0;

/// Where calibration leaves more than the noise, each session by itself with the same parameters.
pub(super) fn is_the_same(evidence: &Evidence, limits: &Limits) -> Vec<Diagnostic> {
    let (model, campaign) = (evidence.model, evidence.campaign);
    let Some(found) = evidence.found.filter(|found| found.converged() && !found.slots.is_empty()) else {
        return Vec::new();
    };
    let Some(parts) = parts(campaign).filter(|_| !campaign.holds_differences()) else { return Vec::new() };
    let together = left(campaign, found);
    let has_lengths = campaign.holds_lengths();
    let is_noise =
        if has_lengths { campaign.sigma.is_some() && together <= FALL * noise(campaign) } else { together <= FALL };
    if is_noise {
        return Vec::new();
    }
    // Each with its degrees of freedom: a session of few readings leaves little whatever its robot is.
    let alone = |part: usize| {
        let own = campaign.select(|index, _| !found.holds_out(index) && parts.of.get(index) == Some(&part));
        let rows = rows(&own) as f64;
        let again = fitted(model, &own, &vec![false; own.readings.len()], Some(found.slots.clone()))?;
        let freedom = again.degrees_of_freedom;
        // The ratio to the noise counts them already.
        let inflated = if has_lengths { (rows / freedom).sqrt() } else { 1.0 };
        let left = left(campaign, &again) * inflated;
        (freedom >= limits.noise_freedom).then_some((left, own.readings.len()))
    };
    let Some(all) = (0..parts.names.len()).map(alone).collect::<Option<Vec<(f64, usize)>>>() else {
        return Vec::new();
    };
    let count: usize = all.iter().map(|(_, count)| count).sum();
    let squares: f64 = all.iter().map(|(left, count)| left * left * *count as f64).sum();
    let apart = (squares / count as f64).sqrt();
    let is_named = differ(evidence, limits).is_some() || !agree_calibrated(evidence, limits).is_empty();
    if FALL * apart > together || is_named {
        return Vec::new();
    }
    let each =
        parts.names.iter().zip(&all).map(|(name, (left, _))| format!("`{name}` {}", left_words(campaign, *left)));
    let message = format!(
        "{} are not of one robot: each calibrated by itself leaves {}, and all together {}: is one of another machine, or was a joint set \
         anew or a part exchanged between them?",
        parts.noun,
        each.collect::<Vec<String>>().join(", "),
        left_words(campaign, together)
    );
    let remedy =
        format!("calibrate each of the {} by itself, and compare: `identify --since` says what changed", parts.noun);
    let diagnostic = Diagnostic::warning(message).code(Code::SessionsDiffer).remedy(remedy);
    vec![match has_lengths {
        true => diagnostic.figure("together_mm", 1e3 * together).figure("separate_mm", 1e3 * apart),
        false => diagnostic.figure("together", together).figure("separate", apart),
    }]
}

/// Rows of all readings.
fn rows(campaign: &Campaign) -> usize {
    campaign.readings.iter().map(|reading| reading.observes.rows()).sum()
}
