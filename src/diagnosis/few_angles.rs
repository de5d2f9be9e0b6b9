//! What is left open at a few angles of one joint: the mark of a damaged tooth, or of a dent in a bearing ring.

use nalgebra::DVector;

use super::competition::Competition;
use super::free_errors::FreeErrors;
use super::inputs::Inputs;
use super::result::FewAngles;
use super::windows;
use crate::math::quantiles::f_tail;
use crate::math::{orthonormal, project_off};
use crate::prediction::PredictionError;

/// Share of a window's squares below which what is calibrated makes the same as the window, to rounding.
const ITS_OWN: f64 = 1e-6;
/// Share of the squares above the noise (of all squares where the noise is not known) from which most of what is open lies there: more than half.
const MOST: f64 = 0.5;

/// The window of a joint's angle at which one error takes most of the rest away, `members` and what is calibrated fitted with it; `None`
/// where it does not, or may be chance. `noise` is over the sigmas, 0 where nothing but the residuals tells it.
///
/// # Errors
/// A configuration that cannot be assembled.
pub fn few_angles(
    inputs: &Inputs,
    competition: &Competition,
    members: &[usize],
    noise: f64,
) -> Result<Option<FewAngles>, PredictionError> {
    let (model, campaign, problem) = (inputs.model, &competition.campaign, &competition.problem);
    let free = FreeErrors::new(model, campaign, &competition.values, problem)?;
    let basis = orthonormal(&problem.design(members), None);
    let left = project_off(&problem.residual, &basis);
    let total = left.norm_squared();
    let freedom = (problem.rows() as f64 - basis.ncols() as f64 - 1.0).max(1.0);
    let excess = total - (freedom + 1.0) * noise * noise;
    let mut best: Option<(f64, FewAngles, DVector<f64>)> = None;
    let mut tried = 0.0;
    windows::each((model, campaign), problem, &free, windows::LEAST, |site, window, column| {
        tried += 1.0;
        // What is left is orthogonal to the basis already.
        let along = column.dot(&left);
        let size = column.norm_squared() - basis.tr_mul(column).norm_squared();
        if size <= ITS_OWN * column.norm_squared() {
            return;
        }
        let gain = along * along / size;
        if best.as_ref().is_none_or(|(greatest, ..)| gain > *greatest) {
            let found = FewAngles {
                site: site.name.clone(),
                variable: site.coordinate.map_or_else(String::new, |of| model.variables[of].name.clone()),
                at_deg: window.centre.to_degrees(),
                half_width_deg: window.half_width.to_degrees(),
                amount_deg: (along / size).to_degrees(),
                share: ((gain - noise * noise) / excess).min(1.0),
            };
            best = Some((gain, found, column * (along / size)));
        }
    });
    // One configuration that is far off is an outlier, and has some joint's direction.
    let is_of_several = |column: &DVector<f64>| {
        // What is calibrated takes a part up.
        let by = project_off(column, &basis);
        let rows: Vec<usize> = (0..by.len()).collect();
        let poses = rows.chunk_by(|a, b| problem.pose[*a] == problem.pose[*b]);
        let squares =
            |pose: &[usize], share: f64| pose.iter().map(|&row| (left[row] - share * by[row]).powi(2)).sum::<f64>();
        let is_within = |pose: &&[usize]| pose.iter().any(|&row| column[row] != 0.0);
        poses.filter(is_within).filter(|pose| squares(pose, 1.0) < 0.5 * squares(pose, 0.0)).count() >= windows::LEAST
    };
    let is_certain = |gain: f64| {
        let variance = (total - gain).max(f64::MIN_POSITIVE) / freedom;
        f_tail(gain / variance, 1.0, freedom) * tried < inputs.settings.claims.chance
    };
    let is_clear = |gain: f64, found: &FewAngles| excess > 0.0 && found.share >= MOST && is_certain(gain);
    Ok(best.filter(|(gain, found, by)| is_clear(*gain, found) && is_of_several(by)).map(|(_, found, _)| found))
}
