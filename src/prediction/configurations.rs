//! Error of each configuration, observed and predicted (KR-270 paper, Tables X and XII).
//!
//! The residuals of the readings of a configuration under one load scatter with `V = J C J' + N`: the covariance of the
//! parameters, and the noise of the readings, of which a part is shared by the configuration. Their mean square has the expectation
//! `tr V / n`; relative to it, it is distributed nearly as chi-square with `(tr V)^2 / tr V^2` degrees of freedom over their number
//! (Satterthwaite, *Biometrics Bulletin* 2, 1946), and as Fisher's F where the noise itself was estimated.

use nalgebra::{DMatrix, DVector, DVectorView};

use crate::description::campaign::{Campaign, Reading};
use crate::math::quantiles::{f_interval95, t95};

/// Variances of a coordinate of a reading, m^2.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct NoiseParts {
    /// Of the reading alone.
    pub own: f64,
    /// Shared by the readings of the configuration.
    pub shared: f64,
}

/// A configuration under one load; m, along x, y, z of the measurements.
#[derive(Debug, Clone, PartialEq)]
pub struct ConfigurationError {
    /// Its readings, by index.
    pub readings: Vec<usize>,
    /// Least and greatest residual.
    pub range: [[f64; 2]; 3],
    /// Mean residual.
    pub mean: [f64; 3],
    /// Standard uncertainty of the mean prediction, by the parameters alone.
    pub uncertainty: [f64; 3],
    /// Half width of the 95 % interval of the mean residual, with the noise.
    pub ci95: [f64; 3],
    /// Root mean square position error.
    pub observed: f64,
    /// The same as predicted: by the parameters alone.
    pub parameters: f64,
    /// With the noise.
    pub predicted: f64,
    /// 95 % interval of the observed error.
    pub interval: [f64; 2],
}

impl ConfigurationError {
    /// Whether the observed error lies in its interval.
    pub fn is_within(&self) -> bool {
        (self.interval[0]..=self.interval[1]).contains(&self.observed)
    }
}

/// What predicts the residuals of configurations.
pub struct ConfigurationErrors<'a> {
    /// Derivatives of the residuals by the parameters, as [`super::Linearised::jacobian`].
    pub jacobian: &'a [f64],
    /// Covariance of the parameters, SI.
    pub covariance: &'a DMatrix<f64>,
    /// Degrees of freedom with which the noise was estimated; infinite where it is known.
    pub freedom: f64,
}

impl ConfigurationErrors<'_> {
    /// Of all configurations among whose readings positions are, in the order of their first readings.
    pub fn of(
        &self,
        campaign: &Campaign,
        residual: &[f64],
        noise: impl Fn(&Reading) -> [NoiseParts; 3],
    ) -> Vec<ConfigurationError> {
        let width = self.covariance.nrows();
        let residuals = campaign.by_reading(residual, 1).map(|(_, own)| own);
        let rows: Vec<(&[f64], &[f64])> =
            residuals.zip(campaign.by_reading(self.jacobian, width).map(|(_, own)| own)).collect();
        let groups = groups(campaign);
        groups.into_iter().map(|readings| self.one(campaign, readings, &rows, &noise)).collect()
    }

    fn one(
        &self,
        campaign: &Campaign,
        readings: Vec<usize>,
        rows: &[(&[f64], &[f64])],
        noise: &impl Fn(&Reading) -> [NoiseParts; 3],
    ) -> ConfigurationError {
        let (width, n) = (self.covariance.nrows(), readings.len() as f64);
        let mut sums = vec![DVector::zeros(width); 3];
        let mut information = DMatrix::zeros(width, width);
        let mut range = [[f64::INFINITY, f64::NEG_INFINITY]; 3];
        let (mut mean, mut own, mut shared) = ([0.0; 3], [0.0; 3], [0.0; 3]);
        let [mut of_parameters, mut squares, mut mixed, mut own_squares, mut observed] = [0.0; 5];
        for &index in &readings {
            let (residual, jacobian) = rows[index];
            for (k, parts) in noise(&campaign.readings[index]).into_iter().enumerate() {
                let row = DVectorView::from_slice(&jacobian[k * width..(k + 1) * width], width);
                let variance = row.dot(&(self.covariance * row));
                sums[k] += row;
                information.ger(1.0, &row, &row, 1.0);
                range[k] = [range[k][0].min(residual[k]), range[k][1].max(residual[k])];
                mean[k] += residual[k] / n;
                own[k] += parts.own;
                shared[k] = parts.shared;
                of_parameters += variance;
                mixed += 2.0 * parts.own * variance;
                own_squares += parts.own * (parts.own + 2.0 * parts.shared);
                observed += residual[k].powi(2);
            }
        }
        // tr V and tr V^2, part by part.
        let product = &information * self.covariance;
        squares += product.component_mul(&product.transpose()).sum() + mixed + own_squares;
        let of_mean: [f64; 3] = std::array::from_fn(|k| sums[k].dot(&(self.covariance * &sums[k])).max(0.0));
        squares += (0..3).map(|k| shared[k] * (2.0 * of_mean[k] + shared[k] * n * n)).sum::<f64>();
        let trace = of_parameters + own.iter().sum::<f64>() + n * shared.iter().sum::<f64>();
        let predicted = (trace / n).sqrt();
        // Nothing scatters without noise.
        let degrees = if squares > 0.0 { trace * trace / squares } else { 1.0 };
        let [low, high] = f_interval95(degrees, self.freedom);
        let deviation = |k: usize| ((of_mean[k] + own[k]) / (n * n) + shared[k]).sqrt();
        ConfigurationError {
            range,
            mean,
            uncertainty: of_mean.map(|variance| variance.sqrt() / n),
            ci95: std::array::from_fn(|k| t95(self.freedom) * deviation(k)),
            observed: (observed / n).sqrt(),
            parameters: (of_parameters / n).sqrt(),
            predicted,
            interval: [predicted * low.sqrt(), predicted * high.sqrt()],
            readings,
        }
    }
}

/// Readings of positions by configuration and load.
fn groups(campaign: &Campaign) -> Vec<Vec<usize>> {
    let mut groups: Vec<Vec<usize>> = Vec::new();
    let mut known: indexmap::IndexMap<(usize, [u64; 6], u64), usize> = indexmap::IndexMap::new();
    for (index, reading) in campaign.readings.iter().enumerate() {
        if reading.observes.length_rows() != 3 {
            continue;
        }
        let mass = reading.payload.map_or(0.0, |payload| payload.mass);
        let key = (reading.pose, reading.wrench.map(f64::to_bits), mass.to_bits());
        let group = *known.entry(key).or_insert(groups.len());
        if group == groups.len() {
            groups.push(Vec::new());
        }
        groups[group].push(index);
    }
    groups
}
