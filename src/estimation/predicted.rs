//! Errors of readings that a fit did not see, as its covariance and the noise that it leaves predict them (KR-270 paper, Tables X, XII).

use super::covariance::Covariance;
use super::result::{CalibrationError, PredictedError};
use super::robust::deviation;
use super::task::Task;
use crate::description::campaign::Campaign;
use crate::least_squares::Loss;
use crate::math::mean_rms_max;
use crate::parameter::Slot;
use crate::prediction::{ConfigurationError, ConfigurationErrors, NoiseParts, Predictor};

impl Task<'_> {
    /// Standard deviation of the fitted residuals of each direction, m: of positions, or of single lengths where none is read.
    pub(super) fn direction_noise(&self, residual: &[f64]) -> [f64; 3] {
        let lengths = self.campaign.readings.iter().map(|reading| reading.observes.length_rows());
        self.noise_of_lengths(residual, lengths.max().unwrap_or(0))
    }

    /// Standard deviation of the fitted residuals of readings with so many lengths, m.
    fn noise_of_lengths(&self, residual: &[f64], lengths: usize) -> [f64; 3] {
        std::array::from_fn(|k| {
            let readings = self.campaign.by_reading(residual, 1).zip(self.held_out);
            let fitted = readings.filter(|(_, held_out)| !**held_out).map(|(reading, _)| reading);
            let alike = fitted.filter(|(reading, _)| lengths > k && reading.observes.length_rows() == lengths);
            self.deviation(alike.map(|(_, own)| own[k]))
        })
    }

    /// Root mean square of residuals; after a robust loss, which is chosen where some are outliers, that by their median.
    fn deviation(&self, residuals: impl Iterator<Item = f64>) -> f64 {
        match self.settings.loss {
            Loss::Squares => mean_rms_max(residuals)[1],
            _ => deviation(residuals).unwrap_or(0.0),
        }
    }

    /// Position error of the held-out readings that the covariance predicts, of all together and of each configuration (KR-270
    /// paper, Tables X, XII).
    pub(super) fn predicted_error(
        &self,
        kept: &[Slot],
        values: &[f64],
        covariance: &Covariance,
        residual: &[f64],
    ) -> Result<(Option<PredictedError>, Vec<ConfigurationError>), CalibrationError> {
        let check = self.campaign.select(|i, _| self.held_out[i]);
        if check.readings.is_empty() {
            return Ok((None, Vec::new()));
        }
        let found = Predictor::new(self.model, &check, kept.to_vec())?.linearised(values)?;
        let predicted = self.predicted_rms(&check, &found.jacobian, covariance, residual);
        let of_rows = self.noise_by_direction(covariance, residual);
        let errors = ConfigurationErrors {
            jacobian: &found.jacobian,
            covariance: &covariance.matrix,
            freedom: covariance.shared.map_or(covariance.freedom, |shared| shared.between.min(covariance.freedom)),
        };
        let part = covariance.shared.map_or(0.0, |of| of.shared.powi(2) / (of.shared.powi(2) + of.own.powi(2)));
        let mut configurations = errors.of(&check, &found.residual, |reading| {
            let sigmas = reading.observes.sigmas(&reading.noise);
            std::array::from_fn(|k| {
                let variance = of_rows[k] * sigmas[k].powi(2);
                NoiseParts { own: (1.0 - part) * variance, shared: part * variance }
            })
        });
        let held_out: Vec<usize> = (0..self.held_out.len()).filter(|&index| self.held_out[index]).collect();
        for index in configurations.iter_mut().flat_map(|of| &mut of.readings) {
            *index = held_out[*index];
        }
        Ok((predicted, configurations))
    }

    /// Root mean square error of the lengths held out that the covariance predicts; angles and torques have no part in it. `None`
    /// where none is held out.
    fn predicted_rms(
        &self,
        check: &Campaign,
        jacobian: &[f64],
        covariance: &Covariance,
        residual: &[f64],
    ) -> Option<PredictedError> {
        let width = covariance.matrix.nrows().max(1);
        let noise: [f64; 4] = std::array::from_fn(|lengths| {
            self.noise_of_lengths(residual, lengths).iter().map(|sigma| sigma * sigma).sum()
        });
        let (mut count, mut of_parameters, mut of_noise) = (0.0, 0.0, 0.0);
        for (reading, own) in check.by_reading(jacobian, width) {
            let lengths = reading.observes.length_rows().min(3);
            if lengths == 0 {
                continue;
            }
            count += 1.0;
            of_parameters += own.chunks(width).take(lengths).map(|row| covariance.variance(row)).sum::<f64>();
            of_noise += noise[lengths];
        }
        (count > 0.0).then(|| PredictedError {
            parameters: (of_parameters / count).sqrt(),
            with_noise: ((of_parameters + of_noise) / count).sqrt(),
        })
    }

    /// Variance of the noise along x, y, z over the stated one, as the fitted residuals show it.
    fn noise_by_direction(&self, covariance: &Covariance, residual: &[f64]) -> [f64; 3] {
        let used = (covariance.freedom + covariance.matrix.nrows() as f64) / covariance.freedom;
        std::array::from_fn(|k| {
            let readings = self.campaign.by_reading(residual, 1).zip(self.held_out);
            let fitted = readings.filter(|(_, held_out)| !**held_out).map(|(reading, _)| reading);
            let along = fitted.filter(|(reading, _)| reading.observes.length_rows() == 3);
            used * self.deviation(along.map(|(of, own)| own[k] / of.observes.sigmas(&of.noise)[k])).powi(2)
        })
    }
}
