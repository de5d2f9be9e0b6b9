//! Residuals against the noise that is stated: of lengths, of angles and of loads, each judged in its own.

use super::evidence::{Evidence, Limits};
use super::fitted::Fitted;
use crate::description::campaign::{NoiseOrigin, Reading};
use crate::diagnostic::{Code, Diagnostic};
use crate::estimation::{Calibration, row_kinds, row_sigmas};
use crate::math::{median, project_off};

/// Names of the quantities and the keys under `instrument:` that state their noise.
const QUANTITIES: [(&str, &str); 3] =
    [("", "sigma"), (" of orientations", "orientation"), (" of torques and forces", "torque")];

/// Residuals of readings whose noise is stated.
#[derive(Debug, Clone, Copy, Default)]
struct Residuals {
    /// Weighted squares, and how many.
    squares: f64,
    rows: f64,
}

/// A reading whose stated noise is this part of the median of its kind is given in another unit: it would count a million times as much
/// as each of them. Instruments of one campaign differ by less: a judgement.
const UNLIKE: f64 = 1e-3;

/// Readings whose stated noise is far below that of the others, whom they would outweigh.
pub(super) fn alike(evidence: &Evidence, _limits: &Limits) -> Vec<Diagnostic> {
    let campaign = evidence.campaign;
    let stated = |k: usize| {
        let of = move |reading: &Reading| {
            let noise = &reading.noise;
            let least = noise.position.into_iter().fold(f64::INFINITY, f64::min);
            noise.is_stated[k].then(|| [least, noise.orientation, noise.load][k]).filter(|sigma| *sigma > 0.0)
        };
        let all: Vec<(&Reading, f64)> = campaign.readings.iter().filter_map(|own| Some((own, of(own)?))).collect();
        let usual = median(&mut all.iter().map(|(_, sigma)| *sigma).collect::<Vec<f64>>())?;
        let low: Vec<_> = all.into_iter().filter(|(_, sigma)| *sigma < UNLIKE * usual).collect();
        let (first, sigma) = low.first()?;
        let more = if low.len() > 1 { format!(", and {} more", low.len() - 1) } else { String::new() };
        let message = format!(
            "the noise stated for {}{more} is {:.1e} times that of the others: it would outweigh all of them",
            campaign.address(first),
            sigma / usual
        );
        let remedy =
            "correct it: the column is in the campaign's units; of a reading without noise leave the cell empty";
        Some(Diagnostic::error(message).code(Code::WrongUnits).remedy(remedy).figure("ratio", sigma / usual))
    };
    (0..3).filter_map(stated).collect()
}

/// Whether a diagnostic says that what calibration leaves is above the stated noise, which causes or the robot's own error may explain.
pub fn is_above_noise(diagnostic: &Diagnostic) -> bool {
    diagnostic.code == Code::NoiseUnlikeStated && diagnostic.figures.get("ratio").is_some_and(|ratio| *ratio > 1.0)
}

pub(super) fn as_noisy_as_stated(evidence: &Evidence, limits: &Limits) -> Vec<Diagnostic> {
    let Some(found) = evidence.found else { return Vec::new() };
    let (quantities, rows) = by_quantity(evidence, found);
    let [least, most] = limits.noise;
    let each = quantities.iter().zip(QUANTITIES);
    let of_all = each.filter_map(|(own, (of, key))| {
        let freedom = found.degrees_of_freedom * own.rows / rows;
        // Where all readings are of one quantity the fit's own ratio, which counts a robust loss's weights.
        let ratio = match own.rows == rows {
            true => found.noise_ratio,
            false => (own.squares / freedom).sqrt(),
        };
        if freedom < limits.noise_freedom || (least..=most).contains(&ratio) || !ratio.is_finite() {
            return None;
        }
        // What the readings themselves show is the instrument's alone: a robot is noisier.
        if key == "sigma" && evidence.campaign.noise_origin != NoiseOrigin::Stated {
            return None;
        }
        let diagnostic = if ratio < least {
            let message = format!(
                "residuals{of} are {ratio:.2} times the stated noise: no instrument is that much better than stated"
            );
            Diagnostic::warning(message).remedy(format!(
                "state the noise under `instrument: {{{key}: ..}}`, in the campaign's units; look whether readings were measured or computed"
            ))
        } else {
            let message = format!(
                "residuals{of} are {ratio:.0} times the stated noise: calibration does not describe these readings"
            );
            Diagnostic::warning(message).remedy(format!(
                "`diagnose` says where the rest lies; state the noise under `instrument: {{{key}: ..}}`, in the campaign's units"
            ))
        };
        Some(diagnostic.code(Code::NoiseUnlikeStated).figure("ratio", ratio))
    });
    let all: Vec<Diagnostic> = of_all.collect();
    if !all.is_empty() {
        return all;
    }
    hiding(evidence, limits).or_else(|| of_the_noisiest(evidence, found, limits)).into_iter().collect()
}

/// A stated noise that hides parameters, without which residuals seem to be of its size: with these fitted too, to first order, they are
/// far below it.
fn hiding(evidence: &Evidence, limits: &Limits) -> Option<Diagnostic> {
    let found = evidence.found.filter(|found| found.noise_ratio < limits.noise[1])?;
    // What contacts leave scales with robot and fixtures, so that all parameters together span it whatever it is.
    let is_stated =
        |reading: &Reading| !reading.observes.touches() && row_kinds(reading).all(|kind| reading.noise.is_stated[kind]);
    let campaign = evidence.campaign;
    if campaign.noise_origin != NoiseOrigin::Stated || !campaign.readings.iter().all(is_stated) {
        return None;
    }
    let hidden = found.identifiability.rank.saturating_sub(found.identifiability.kept.len());
    let all = Fitted::of_all(evidence).filter(|all| hidden > 0 && all.freedom() >= limits.noise_freedom)?;
    let ratio = project_off(&all.residual, &all.basis).norm() / all.freedom().sqrt();
    if ratio >= limits.noise[0] {
        return None;
    }
    let message = format!(
        "residuals are {ratio:.3} times the stated noise once the {hidden} parameters that it hides are fitted too: no instrument is that \
         much better than stated"
    );
    let remedy = "state the noise under `instrument: {sigma: ..}`, in the campaign's units: parameters that it hides stay as described";
    Some(Diagnostic::error(message).code(Code::Implausible).figure("ratio", ratio).remedy(remedy))
}

/// Greatest over least stated noise of lengths from which each half is judged by itself: another instrument, or another unit.
const APART: f64 = 10.0;

/// Lengths whose stated noise is far above that of others, and which scatter far less than it says: they hardly count in the fit, and
/// figures of all readings seem to be below the noise.
fn of_the_noisiest(evidence: &Evidence, found: &Calibration, limits: &Limits) -> Option<Diagnostic> {
    let campaign = evidence.campaign;
    let sigmas = row_sigmas(campaign);
    let pairs: Vec<(f64, f64)> =
        found.residual.iter().zip(&sigmas).map(|(left, sigma)| (*sigma, left / sigma)).collect();
    let flat: Vec<f64> = pairs.iter().map(|(_, weighted)| *weighted).collect();
    let mut rows: Vec<(f64, f64)> = Vec::new();
    let mut first = 0;
    for ((reading, own), held_out) in campaign.by_reading(&flat, 1).zip(&found.held_out) {
        let is_fitted = !held_out && reading.noise.is_stated[0];
        let lengths = row_kinds(reading).enumerate().filter(|(_, kind)| is_fitted && *kind == 0);
        rows.extend(lengths.filter_map(|(k, _)| pairs.get(first + k).copied()));
        first += own.len();
    }
    let least = rows.iter().map(|(sigma, _)| *sigma).fold(f64::INFINITY, f64::min);
    let most = rows.iter().map(|(sigma, _)| *sigma).fold(0.0, f64::max);
    if most < APART * least {
        return None;
    }
    let noisy: Vec<(f64, f64)> = rows.iter().copied().filter(|(sigma, _)| *sigma > (least * most).sqrt()).collect();
    let ratio = (noisy.iter().map(|(_, weighted)| weighted * weighted).sum::<f64>() / noisy.len() as f64).sqrt();
    if (noisy.len() as f64) < limits.noise_freedom || ratio >= limits.noise[0] {
        return None;
    }
    let from = noisy.iter().map(|(sigma, _)| *sigma).fold(f64::INFINITY, f64::min);
    let message = format!(
        "coordinates whose noise is stated as {:.3} mm or more scatter by {ratio:.3} times that: no instrument is that much better than stated",
        1e3 * from
    );
    let remedy = "look at the column `sigma` there, and at its unit; readings that count too little make every error look like noise";
    Some(Diagnostic::warning(message).code(Code::NoiseUnlikeStated).figure("ratio", ratio).remedy(remedy))
}

/// Of each quantity, and the number of all rows.
fn by_quantity(evidence: &Evidence, found: &Calibration) -> ([Residuals; 3], f64) {
    let campaign = evidence.campaign;
    let sigmas = row_sigmas(campaign);
    let weighted: Vec<f64> = found.residual.iter().zip(&sigmas).map(|(left, sigma)| left / sigma).collect();
    let (mut all, mut rows) = ([Residuals::default(); 3], 0.0);
    let fitted = campaign.by_reading(&weighted, 1).zip(&found.held_out).filter(|(_, held_out)| !**held_out);
    for ((reading, own), _) in fitted {
        for (left, kind) in own.iter().zip(row_kinds(reading)) {
            rows += 1.0;
            if reading.noise.is_stated[kind] {
                all[kind].squares += left * left;
                all[kind].rows += 1.0;
            }
        }
    }
    (all, rows)
}
