//! Error of each configuration, observed and predicted. Lengths in mm.

use serde::Serialize;

use super::units::mm;
use crate::description::campaign::Campaign;
use crate::prediction::ConfigurationError;

/// A configuration under one load; along x, y, z of the measurements, measured less predicted.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ConfigurationResidual {
    /// Name of the configuration.
    pub pose: String,
    /// Number of readings.
    pub readings: usize,
    /// Force (N) and torque (N.m) on the tool, where there are any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub wrench: Option<[f64; 6]>,
    /// Mean measured deflection; of deflections only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub measured: Option<[f64; 3]>,
    /// Mean predicted deflection; of deflections only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub predicted: Option<[f64; 3]>,
    /// Least and greatest error.
    pub range: [[f64; 2]; 3],
    /// Mean error.
    pub mean: [f64; 3],
    /// Standard uncertainty of the mean prediction, by the covariance of the parameters.
    pub standard_uncertainty: [f64; 3],
    /// Half width of the 95 % interval of the mean error, with the noise.
    pub ci95: [f64; 3],
    /// Root mean square position error.
    pub observed_rms: f64,
    /// The same as predicted, by the covariance of the parameters alone.
    pub parameters_rms: f64,
    /// With the noise.
    pub predicted_rms: f64,
    /// 95 % interval of the observed error.
    pub predicted_ci95: [f64; 2],
    /// Whether the observed error is in it.
    pub within: bool,
}

impl ConfigurationResidual {
    /// Of the configurations of a campaign.
    pub fn all(campaign: &Campaign, errors: &[ConfigurationError]) -> Vec<Self> {
        errors.iter().filter_map(|error| Self::new(campaign, error)).collect()
    }

    fn new(campaign: &Campaign, error: &ConfigurationError) -> Option<Self> {
        let first = campaign.readings.get(*error.readings.first()?)?;
        let n = error.readings.len() as f64;
        let measured: [f64; 3] = std::array::from_fn(|k| {
            error
                .readings
                .iter()
                .filter_map(|&index| campaign.readings.get(index))
                .map(|of| of.measured[k])
                .sum::<f64>()
                / n
        });
        let measured = first.observes.is_difference().then_some(measured);
        let predicted = measured.map(|measured| std::array::from_fn(|k| measured[k] - error.mean[k]));
        let in_mm = |of: [f64; 3]| of.map(mm);
        Some(Self {
            pose: campaign.poses[first.pose].clone(),
            readings: error.readings.len(),
            wrench: (first.wrench != [0.0; 6]).then_some(first.wrench),
            measured: measured.map(in_mm),
            predicted: predicted.map(in_mm),
            range: error.range.map(|ends| ends.map(mm)),
            mean: in_mm(error.mean),
            standard_uncertainty: in_mm(error.uncertainty),
            ci95: in_mm(error.ci95),
            observed_rms: mm(error.observed),
            parameters_rms: mm(error.parameters),
            predicted_rms: mm(error.predicted),
            predicted_ci95: error.interval.map(mm),
            within: error.is_within(),
        })
    }
}
