//! Readings that are simply wrong: a digit that was mistyped, a reflector that was lost. They are few, and far from what all the
//! others say.
//!
//! Before a calibration they are found by fitting base and tool to the others, again and again, until the same ones stay out
//! (least trimmed squares by concentration steps: Rousseeuw and Van Driessen, *Data Min. Knowl. Discov.* 12, 2006). After one, each
//! fitted reading is judged by what the fit would leave of it if it were not fitted (deletion: Cook and Weisberg, *Residuals and
//! Influence in Regression*, 1982, section 2.2), the worst first, and each one held out by its error.

use nalgebra::{DMatrix, DVector};

use super::evidence::{Evidence, Limits};
use super::fitted::Fitted;
use super::trial::{errors, searching};
use super::words::mm;
use crate::description::campaign::Campaign;
use crate::diagnostic::{Code, Diagnostic};
use crate::estimation::registered;
use crate::math::{median, orthonormal, quantiles::f_tail};
use crate::prediction::{Linearised, Predictor};

/// Rounds of registration in which readings are left out.
const ROUNDS: usize = 6;
/// Most readings named in one message.
const NAMED: usize = 3;
/// Most readings that are taken out of a fit one after the other.
const MOST: usize = 20;

/// What is said of readings that are far from all others when base and tool are fitted to these, where tolerances and noise
/// allow an error of `allowed` (m).
pub(super) fn before(evidence: &Evidence, limits: &Limits, allowed: f64) -> Option<Diagnostic> {
    let (model, campaign) = (evidence.model, evidence.campaign);
    let settings = searching(campaign, limits);
    let count = campaign.readings.len();
    let mut kept = vec![true; count];
    let mut last = Vec::new();
    let mut all = Linearised::default();
    for _ in 0..ROUNDS {
        let own = campaign.select(|index, _| kept[index]);
        let (values, _) = registered(model, &own, &model.registry.nominal(), &settings).ok()?;
        Predictor::new(model, campaign, Vec::new()).ok()?.linearise(&values, false, &mut all).ok()?;
        last = errors(campaign, &all.residual, limits).collect();
        let middle = median(&mut last.clone())?;
        let next: Vec<bool> = last.iter().map(|error| *error <= limits.trimmed * middle).collect();
        let fewest = (1.0 - limits.wrong_share) * count as f64;
        if next == kept || (next.iter().filter(|kept| **kept).count() as f64) < fewest {
            break;
        }
        kept = next;
    }
    let middle = median(&mut last.clone())?;
    let wrong: Vec<usize> = (0..count).filter(|&k| last[k] > limits.hopeless * middle.max(allowed)).collect();
    let is_few = !wrong.is_empty() && wrong.len() as f64 <= limits.wrong_share * count as f64;
    (is_few && middle <= limits.far * allowed).then(|| said(campaign, &wrong, &|k| last[k], middle))
}

/// What is said of readings that are far off, of which others leave `left` (m).
fn said(campaign: &Campaign, wrong: &[usize], by: &dyn Fn(usize) -> f64, left: f64) -> Diagnostic {
    let mut worst = wrong.to_vec();
    worst.sort_by(|&a, &b| by(b).total_cmp(&by(a)));
    let named: Vec<String> = worst
        .iter()
        .take(NAMED)
        .map(|&k| format!("{} ({} mm)", campaign.address(&campaign.readings[k]), mm(by(k))))
        .collect();
    let more = if wrong.len() > NAMED { format!(" and {} more", wrong.len() - NAMED) } else { String::new() };
    let verb = if wrong.len() == 1 { "is" } else { "are" };
    let message = format!(
        "{} of {} readings {verb} far off where half of the others are within {} mm: {}{more}",
        wrong.len(),
        campaign.readings.len(),
        mm(left),
        named.join(", ")
    );
    Diagnostic::warning(message)
        .code(Code::OutlyingReadings)
        .remedy("look at those rows and correct or delete them; or let outliers count little (`--loss huber`)")
        .figure("readings", wrong.len() as f64)
        .figure("greatest_mm", worst.first().map_or(0.0, |&k| 1e3 * by(k)))
        .figure("others_mm", 1e3 * left)
}

/// After a calibration: fitted readings by deletion, held-out ones by their errors.
pub(super) fn after(evidence: &Evidence, limits: &Limits) -> Vec<Diagnostic> {
    let Some(found) = evidence.found.filter(|found| found.converged()) else { return Vec::new() };
    let campaign = evidence.campaign;
    let mut size: Vec<f64> = errors(campaign, &found.residual, limits).collect();
    let Some(mut fit) = Fitted::of(evidence) else { return Vec::new() };
    let mut wrong = Vec::new();
    while let Some((k, by)) = fit.worst(limits).filter(|_| wrong.len() < MOST) {
        fit.leave_out(k);
        wrong.push(fit.reading(k));
        size[fit.reading(k)] = by;
        // Of the others without it.
        for (reading, error) in fit.errors(limits) {
            size[reading] = error;
        }
    }
    let mut others: Vec<f64> = (0..size.len()).filter(|k| !wrong.contains(k)).map(|k| size[k]).collect();
    let Some(middle) = median(&mut others) else { return Vec::new() };
    let floor = limits.outlying * middle.max(fit.least());
    wrong.retain(|&k| size[k] > floor);
    wrong.extend((0..size.len()).filter(|&k| found.held_out.get(k) == Some(&true) && size[k] > floor));
    if wrong.is_empty() || wrong.len() as f64 > limits.wrong_share * size.len() as f64 {
        return Vec::new();
    }
    vec![said(campaign, &wrong, &|k| size[k], middle)]
}

impl Fitted<'_> {
    /// The fitted reading that a fit without it would leave most certainly elsewhere, and how far (m).
    fn worst(&self, limits: &Limits) -> Option<(usize, f64)> {
        let total = self.residual.norm_squared();
        let mut best: Option<(usize, f64, f64)> = None;
        for k in 0..self.rows.len().saturating_sub(1) {
            let own = self.rows[k]..self.rows[k + 1];
            if self.is_out[k] || own.is_empty() {
                continue;
            }
            let residual = self.residual.rows(own.start, own.len());
            // Without columns the residual itself is the least that it can be.
            let basis = self.basis.rows(own.start, own.len());
            let free = DMatrix::identity(own.len(), own.len()) - basis * basis.transpose();
            let Some(deleted) = free.cholesky().map(|factor| factor.solve(&residual)) else { continue };
            let gain = residual.dot(&deleted);
            if best.as_ref().is_none_or(|(_, most, _)| gain > *most) {
                best = Some((k, gain, self.distance(k, &deleted, limits)));
            }
        }
        let (k, gain, by) = best?;
        let count = (self.rows[k + 1] - self.rows[k]) as f64;
        let freedom = self.freedom() - count;
        if freedom < limits.noise_freedom {
            return None;
        }
        let ratio = (gain / count) / ((total - gain).max(f64::MIN_POSITIVE) / freedom);
        let chance = f_tail(ratio, count, freedom) * self.rows.len() as f64;
        (chance < limits.chance).then_some((k, by))
    }

    /// Takes a reading out of the fit.
    fn leave_out(&mut self, k: usize) {
        let own = self.rows[k]..self.rows[k + 1];
        let mut columns = DMatrix::zeros(self.residual.len(), own.len());
        own.enumerate().for_each(|(column, row)| columns[(row, column)] = 1.0);
        let added = orthonormal(&columns, Some(&self.basis));
        let part: DVector<f64> = added.tr_mul(&self.residual);
        self.residual -= &added * part;
        self.basis = crate::math::joined(&self.basis, &added);
        self.is_out[k] = true;
    }
}
