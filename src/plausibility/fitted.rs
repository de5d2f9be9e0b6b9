//! The linear problem at a calibration: residuals of the fitted readings in standard deviations, and what the fitted parameters
//! span of them.

use nalgebra::{DMatrix, DVector};

use super::evidence::{Evidence, Limits};
use super::trial::{is_of_torques, lever};
use crate::estimation::row_sigmas;
use crate::math::orthonormal;
use crate::parameter::Slot;
use crate::prediction::Predictor;

/// Fitted readings from which the parameters' share of each is left out of account: it is then below a hundredth.
const MANY: usize = 20_000;
/// Least standard deviation, m or rad: simulated readings without noise leave rounding.
const LEAST: f64 = 1e-9;

/// Residuals of the fitted readings.
pub(super) struct Fitted<'a> {
    pub evidence: &'a Evidence<'a>,
    /// Fitted readings, by index in the campaign.
    readings: Vec<usize>,
    /// First row of each, and the end.
    pub rows: Vec<usize>,
    /// In standard deviations.
    pub residual: DVector<f64>,
    sigmas: Vec<f64>,
    /// Whether all readings are torques and forces.
    torques: bool,
    /// Orthonormal columns that span what the fitted parameters do.
    pub basis: DMatrix<f64>,
    /// Readings that were taken out.
    pub is_out: Vec<bool>,
}

impl<'a> Fitted<'a> {
    /// Of the calibration in the evidence; `None` where there is none, or its values cannot be predicted with.
    pub fn of(evidence: &'a Evidence<'a>) -> Option<Self> {
        let found = evidence.found?;
        Self::spanned_by(evidence, found.kept_slots())
    }

    /// The same, spanned by all parameters that were to be fitted, those that the noise hides included.
    pub fn of_all(evidence: &'a Evidence<'a>) -> Option<Self> {
        Self::spanned_by(evidence, evidence.found?.slots.clone())
    }

    fn spanned_by(evidence: &'a Evidence<'a>, slots: Vec<Slot>) -> Option<Self> {
        let found = evidence.found?;
        let campaign = found.fitted(evidence.campaign);
        let readings: Vec<usize> = (0..evidence.campaign.readings.len()).filter(|&k| !found.holds_out(k)).collect();
        let slots: Vec<Slot> = if readings.len() > MANY { Vec::new() } else { slots };
        let all = Predictor::new(evidence.model, &campaign, slots).ok()?.linearised(&found.values).ok()?;
        let mut rows = vec![0];
        for reading in &campaign.readings {
            rows.push(rows.last().copied().unwrap_or(0) + reading.observes.rows());
        }
        let count = rows.last().copied().unwrap_or(0);
        let sigmas: Vec<f64> = row_sigmas(&campaign).into_iter().take(count).map(|sigma| sigma.max(LEAST)).collect();
        let (columns, residual) = all.whitened(&sigmas);
        let basis = if columns.ncols() > 0 { orthonormal(&columns, None) } else { columns };
        if !residual.iter().chain(basis.iter()).all(|value| value.is_finite()) {
            return None;
        }
        let is_out = vec![false; readings.len()];
        let torques = is_of_torques(&campaign);
        Some(Self { evidence, readings, rows, residual, sigmas, torques, basis, is_out })
    }

    /// A fitted reading's index in the campaign.
    pub fn reading(&self, k: usize) -> usize {
        self.readings[k]
    }

    /// Indices in the campaign, in order.
    pub fn readings(&self) -> &[usize] {
        &self.readings
    }

    /// Rows less parameters and readings taken out.
    pub fn freedom(&self) -> f64 {
        self.residual.len() as f64 - self.basis.ncols() as f64
    }

    /// A displacement (m) by rows in standard deviations; rotations at the end of [`Limits::arm`].
    pub fn distance(&self, k: usize, rows: &DVector<f64>, limits: &Limits) -> f64 {
        let (first, reading) = (self.rows[k], &self.evidence.campaign.readings[self.readings[k]]);
        let size = |(row, value): (usize, &f64)| {
            (lever(reading, row, self.torques, limits) * value * self.sigmas[first + row]).powi(2)
        };
        rows.iter().enumerate().map(size).sum::<f64>().sqrt()
    }

    /// Errors (m) of the readings that are still fitted, with their indices in the campaign.
    pub fn errors(&self, limits: &Limits) -> Vec<(usize, f64)> {
        let own = (0..self.readings.len()).filter(|&k| !self.is_out[k]);
        own.map(|k| {
            let rows = self.residual.rows(self.rows[k], self.rows[k + 1] - self.rows[k]).into_owned();
            (self.readings[k], self.distance(k, &rows, limits))
        })
        .collect()
    }

    /// Standard deviation of a row, m or rad.
    pub fn sigma(&self, row: usize) -> f64 {
        self.sigmas[row]
    }

    /// Least standard deviation that is known, m: where none is stated, that of rounding.
    pub fn least(&self) -> f64 {
        if self.evidence.campaign.sigma.is_some() { self.unit() } else { LEAST }
    }

    /// The same of readings that scatter by so many times their standard deviations: no less than what is stated.
    pub fn noise(&self, times: f64) -> f64 {
        let least = if self.evidence.campaign.sigma.is_some() { 1.0 } else { 0.0 };
        self.unit() * times.max(least)
    }

    /// Least standard deviation of the rows, stated or assumed.
    fn unit(&self) -> f64 {
        self.sigmas.iter().copied().fold(f64::INFINITY, f64::min)
    }
}
