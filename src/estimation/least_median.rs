//! Base and tool as the better half of the readings has them, whatever the others say: least median of squares.
//!
//! A robust loss needs a start in its reach, and where a fifth of the readings are far off, a fit by least squares is none. So base and tool
//! are fitted to a few configurations that are drawn, many times, and the draw is taken of which half of all readings are nearest; then they
//! are fitted to that half.
//!
//! Source: Rousseeuw, *Least median of squares regression*, J. Am. Stat. Assoc. 79, 1984; steps of concentration: Rousseeuw and Van Driessen,
//! *Computing LTS regression for large data sets*, Data Min. Knowl. Discov. 12, 2006.

use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;

use super::problem::row_sigmas;
use super::registration::{arrangement, registered};
use super::settings::RegistrationSettings;
use crate::description::campaign::{Campaign, Target};
use crate::math::{median, norm};
use crate::model::Model;
use crate::prediction::{PredictionError, residuals};

/// Draws: with a third of the readings wrong one of eight draws of five is sound, and that none of so many is has a chance of 1e-3.
const DRAWS: usize = 60;
/// Residuals of a draw over what it determines: a draw that is just determined is at the mercy of the noise.
const MORE: f64 = 1.5;
/// Steps of concentration on the nearer half.
const STEPS: usize = 4;

/// Values with base and tool, as [`registered`], as the better half of the readings has them; `None` where the
/// campaign has too few configurations to draw from, or estimates what readings refer to. Of the readings of each session as many configurations are drawn.
///
/// # Errors
/// A configuration that cannot be assembled, or no readings.
pub fn least_median(
    model: &Model,
    campaign: &Campaign,
    values: &[f64],
    settings: &RegistrationSettings,
    seed: u64,
) -> Result<Option<Vec<f64>>, PredictionError> {
    // Of what readings refer to each needs readings of its own.
    if campaign.targets.iter().any(Target::is_estimated) {
        return Ok(None);
    }
    let unknowns = arrangement(model, campaign).len() as f64;
    let mut of_sessions: Vec<Vec<usize>> = Vec::new();
    let mut parts = Vec::new();
    for reading in &campaign.readings {
        let part = parts.iter().position(|known| *known == reading.session).unwrap_or(parts.len());
        if part == parts.len() {
            parts.push(reading.session);
            of_sessions.push(Vec::new());
        }
        if !of_sessions[part].contains(&reading.pose) {
            of_sessions[part].push(reading.pose);
        }
    }
    let configurations: usize = of_sessions.iter().map(Vec::len).sum();
    let rows = row_sigmas(campaign).len() as f64 / configurations.max(1) as f64;
    let drawn = (MORE * unknowns / rows / of_sessions.len().max(1) as f64).ceil() as usize;
    if unknowns == 0.0 || of_sessions.iter().any(|poses| poses.len() < 2 * drawn) {
        return Ok(None);
    }
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut best: Option<(f64, Vec<f64>)> = None;
    for _ in 0..DRAWS {
        let mut chosen = Vec::new();
        for poses in &mut of_sessions {
            poses.shuffle(&mut random);
            chosen.extend_from_slice(&poses[..drawn]);
        }
        let own = campaign.select(|_, reading| chosen.contains(&reading.pose));
        let Ok((found, _)) = registered(model, &own, values, settings) else { continue };
        let Some(middle) = median(&mut sizes(model, campaign, &found)?) else { continue };
        if best.as_ref().is_none_or(|(least, _)| middle < *least) {
            best = Some((middle, found));
        }
    }
    let Some((mut least, mut found)) = best else { return Ok(None) };
    for _ in 0..STEPS {
        let size = sizes(model, campaign, &found)?;
        let own = campaign.select(|index, _| size[index] <= least);
        let Ok((next, _)) = registered(model, &own, values, settings) else { break };
        let Some(middle) = median(&mut sizes(model, campaign, &next)?).filter(|middle| *middle < least) else { break };
        (least, found) = (middle, next);
    }
    Ok(Some(found))
}

/// Length of each reading's residual, in standard deviations.
fn sizes(model: &Model, campaign: &Campaign, values: &[f64]) -> Result<Vec<f64>, PredictionError> {
    let residual = residuals(model, campaign, values)?;
    let sigmas = row_sigmas(campaign);
    let in_sigmas: Vec<f64> = residual.iter().zip(&sigmas).map(|(row, sigma)| row / sigma).collect();
    Ok(campaign.by_reading(&in_sigmas, 1).map(|(_, rows)| norm(rows)).collect())
}
