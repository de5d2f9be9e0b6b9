//! Where the gap lies by site: how much of the residuals a local error at a site could carry if it were free in every
//! configuration.

use nalgebra::DVector;
use rand::RngExt;

use super::bootstrap::interval95;
use super::competition::Competition;
use super::free_errors::{FreeErrors, Squares};
use super::inputs::Inputs;
use super::result::SiteShare;
use crate::prediction::PredictionError;
use crate::simulation::generator;

/// Shares of all sites in the residuals of calibration (weighted), the greatest first. `noise` is over the sigmas.
///
/// # Errors
/// A configuration that cannot be assembled.
pub fn sites(
    inputs: &Inputs,
    competition: &Competition,
    residual: &DVector<f64>,
    noise: f64,
) -> Result<Vec<SiteShare>, PredictionError> {
    let (campaign, problem) = (&competition.campaign, &competition.problem);
    let free = FreeErrors::new(inputs.model, campaign, &competition.values, problem)?;
    let share_of = |(site, squares): (&str, Vec<Squares>)| {
        let mut random = generator(inputs.settings.seed);
        let mut draw = || share((0..squares.len()).map(|_| &squares[random.random_range(0..squares.len())]));
        let mut drawn: Vec<f64> = (0..inputs.settings.location.draws).map(|_| draw()).collect();
        let value = share(squares.iter());
        SiteShare { site: site.into(), share: value, ci95: interval95(&mut drawn).unwrap_or([value; 2]) }
    };
    let mut found: Vec<SiteShare> = free.squares(residual, noise).map(share_of).collect();
    // Sites that carry the same but for rounding stay in their order, joints first.
    found.sort_by(|a, b| rounded(b.share).total_cmp(&rounded(a.share)));
    Ok(found)
}

fn rounded(share: f64) -> f64 {
    (share * 1e9).round()
}

fn share<'a>(all: impl Iterator<Item = &'a Squares>) -> f64 {
    let (carried, total) = all.fold((0.0, 0.0), |sum, own| (sum.0 + own.carried, sum.1 + own.total));
    (carried / total.max(f64::MIN_POSITIVE)).clamp(0.0, 1.0)
}
