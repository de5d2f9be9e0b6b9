//! Residuals against the noise that is stated: of lengths, of angles and of loads, each judged in its own.

use super::evidence::{Evidence, Limits};
use crate::diagnostic::{Code, Diagnostic};
use crate::estimation::{Calibration, row_kinds, row_sigmas};

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

pub(super) fn as_noisy_as_stated(evidence: &Evidence, limits: &Limits) -> Vec<Diagnostic> {
    let Some(found) = evidence.found else { return Vec::new() };
    let (quantities, rows) = by_quantity(evidence, found);
    let [least, most] = limits.noise;
    let each = quantities.iter().zip(QUANTITIES);
    each.filter_map(|(own, (of, key))| {
        let freedom = found.degrees_of_freedom * own.rows / rows;
        // Where all readings are of one quantity the fit's own ratio, which counts a robust loss's weights.
        let ratio = match own.rows == rows {
            true => found.noise_ratio,
            false => (own.squares / freedom).sqrt(),
        };
        if freedom < limits.noise_freedom || (least..=most).contains(&ratio) || !ratio.is_finite() {
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
    })
    .collect()
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
