//! Where the gap lies by site: how much of the residuals a local error at a site could carry if it were free in every
//! configuration.

use nalgebra::{DMatrix, DVector};
use rand::RngExt;

use super::bootstrap::interval95;
use super::competition::Competition;
use super::inputs::Inputs;
use super::probe::probes;
use super::result::SiteShare;
use crate::math::{orthonormal, project_off};
use crate::prediction::{PredictionError, effect_columns};
use crate::simulation::generator;

/// Squares of one configuration under one load.
struct Squares {
    /// Taken up by the free error, less those of noise and of chance.
    carried: f64,
    /// Above the noise.
    total: f64,
}

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
    let (model, problem) = (inputs.model, &competition.problem);
    let terms = probes(model);
    let names: Vec<(String, usize)> =
        terms.iter().map(|term| (term.site.name.clone(), term.parameters.len())).collect();
    let (all, width) = effect_columns(model, &competition.campaign, &competition.values, terms)?;
    let load = |row: usize| competition.campaign.readings.get(problem.reading[row]).map(|reading| reading.wrench);
    let rows: Vec<usize> = (0..problem.rows()).collect();
    let blocks: Vec<&[usize]> =
        rows.chunk_by(|&a, &b| problem.pose[a] == problem.pose[b] && load(a) == load(b)).collect();
    let mut found = Vec::new();
    let mut first = 0;
    for (site, count) in names {
        let squares: Vec<Squares> = blocks
            .iter()
            .map(|rows| {
                let column = |i: usize, k: usize| all[rows[i] * width + first + k] / problem.sigmas[rows[i]];
                squares(&DMatrix::from_fn(rows.len(), count, column), &residual.select_rows(*rows), noise)
            })
            .collect();
        first += count;
        let mut random = generator(inputs.settings.seed);
        let mut draw = || share((0..squares.len()).map(|_| &squares[random.random_range(0..squares.len())]));
        let mut drawn: Vec<f64> = (0..inputs.settings.location.draws).map(|_| draw()).collect();
        let value = share(squares.iter());
        found.push(SiteShare { site, share: value, ci95: interval95(&mut drawn).unwrap_or([value; 2]) });
    }
    // Sites that carry the same but for rounding stay in their order, joints first.
    found.sort_by(|a, b| rounded(b.share).total_cmp(&rounded(a.share)));
    Ok(found)
}

fn rounded(share: f64) -> f64 {
    (share * 1e9).round()
}

fn squares(columns: &DMatrix<f64>, residual: &DVector<f64>, noise: f64) -> Squares {
    let basis = orthonormal(columns, None);
    let (rows, directions, variance) = (residual.len(), basis.ncols() as f64, noise * noise);
    let taken = residual.norm_squared() - project_off(residual, &basis).norm_squared();
    let total = residual.norm_squared() - rows as f64 * variance;
    // What as many directions would carry of any motion of the tool, which has six.
    let chance = directions / rows.clamp(1, 6) as f64;
    Squares { carried: (taken - directions * variance - chance * total) / (1.0 - chance).max(0.1), total }
}

fn share<'a>(all: impl Iterator<Item = &'a Squares>) -> f64 {
    let (carried, total) = all.fold((0.0, 0.0), |sum, own| (sum.0 + own.carried, sum.1 + own.total));
    (carried / total.max(f64::MIN_POSITIVE)).clamp(0.0, 1.0)
}
