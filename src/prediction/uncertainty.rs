//! Standard uncertainty of predicted positions, from the covariance of a fit and what it left unexplained.
//!
//! Source: *Guide to the expression of uncertainty in measurement* (JCGM 100:2008), sec. 5: `J C J'` to first order, the
//! unexplained part added as an independent one.

use nalgebra::{DMatrix, Matrix3, Vector3};

use super::batch::Predictor;
use super::configurations::{ConfigurationError, ConfigurationErrors, NoiseParts};
use super::error::PredictionError;
use crate::description::campaign::{Campaign, Reading};
use crate::description::raw::RawFit;
use crate::kinematics::Geometry;
use crate::model::Model;
use crate::observation::POSITION;
use crate::parameter::Slot;

/// What a fit left open of the parameters of a robot.
#[derive(Debug, Clone)]
pub struct FittedUncertainty {
    slots: Vec<Slot>,
    /// Their covariance, SI.
    covariance: DMatrix<f64>,
    /// Standard deviations along the axes of the measurements, m.
    unexplained: Vector3<f64>,
}

impl FittedUncertainty {
    /// As a description states it; parameters that the model does not have (effects left out) count no more.
    pub fn new(model: &Model, fit: &RawFit) -> Self {
        let known = fit.parameters.iter().enumerate().filter_map(|(k, name)| Some((k, model.registry.slot(name)?)));
        let known: Vec<(usize, Slot)> = known.collect();
        let entry = |row: usize, column: usize| {
            let (row, column) = (known[row].0, known[column].0);
            fit.covariance.get(row.max(column)).and_then(|own| own.get(row.min(column))).copied().unwrap_or(0.0)
        };
        Self {
            covariance: DMatrix::from_fn(known.len(), known.len(), entry),
            slots: known.into_iter().map(|(_, slot)| slot).collect(),
            unexplained: Vector3::from(fit.unexplained),
        }
    }

    /// Standard uncertainties (m) along x, y, z of the base of the points that readings see, at their configurations and under
    /// their loads, at these values; the base is taken as known.
    ///
    /// # Errors
    /// A configuration that cannot be assembled.
    pub fn positions(
        &self,
        model: &Model,
        values: &[f64],
        readings: &Campaign,
    ) -> Result<Vec<[f64; 3]>, PredictionError> {
        let mut points = readings.clone();
        points.constraints.clear();
        points.declared.clear();
        points.readings.iter_mut().for_each(|reading| reading.observes = POSITION);
        let found = Predictor::new(model, &points, self.slots.clone())?.linearised(values)?;
        let geometry = Geometry::new(model, values)?;
        let width = self.slots.len();
        let unexplained = Matrix3::from_diagonal(&self.unexplained.component_mul(&self.unexplained));
        let one = |(index, reading): (usize, &Reading)| {
            let jacobian =
                DMatrix::from_row_slice(3, width, &found.jacobian[3 * width * index..3 * width * (index + 1)]);
            let of_parameters = &jacobian * &self.covariance * jacobian.transpose();
            let all = Matrix3::from_fn(|i, j| of_parameters[(i, j)]) + unexplained;
            // Readings are in the axes of the measurements.
            let turn = geometry.placement(model.base_slot(reading.session)).rotation.inverse();
            let own = turn.matrix() * all * turn.matrix().transpose();
            std::array::from_fn(|k| own[(k, k)].max(0.0).sqrt())
        };
        Ok(points.readings.iter().enumerate().map(one).collect())
    }

    /// Error of each configuration, observed (`residual`, as [`crate::prediction::Linearised::residual`]) and predicted: what the fit left unexplained is
    /// shared by the readings of a configuration, the noise of the campaign is not. The base is taken as known.
    ///
    /// # Errors
    /// A configuration that cannot be assembled.
    pub fn configurations(
        &self,
        model: &Model,
        values: &[f64],
        campaign: &Campaign,
        residual: &[f64],
    ) -> Result<Vec<ConfigurationError>, PredictionError> {
        let found = Predictor::new(model, campaign, self.slots.clone())?.linearised(values)?;
        let errors =
            ConfigurationErrors { jacobian: &found.jacobian, covariance: &self.covariance, freedom: f64::INFINITY };
        let is_stated = campaign.sigma.is_some();
        Ok(errors.of(campaign, residual, |reading| {
            let sigmas = reading.observes.sigmas(&reading.noise);
            std::array::from_fn(|k| NoiseParts {
                own: if is_stated { sigmas[k].powi(2) } else { 0.0 },
                shared: self.unexplained[k].powi(2),
            })
        }))
    }

    /// The same of the tool centre point at configurations (rad, m), under a wrench on it.
    ///
    /// # Errors
    /// A configuration that cannot be assembled.
    pub fn tool<'q>(
        &self,
        model: &Model,
        configurations: impl Iterator<Item = &'q [f64]>,
        wrench: [f64; 6],
    ) -> Result<Vec<[f64; 3]>, PredictionError> {
        let mut points = Campaign { observes: POSITION, variables: model.variables.len(), ..Campaign::default() };
        let blank = points.blank();
        for (pose, q) in configurations.enumerate() {
            points.poses.push((pose + 1).to_string());
            points.readings.push(Reading { row: pose + 1, pose, wrench, ..blank });
            points.joints.extend_from_slice(q);
        }
        self.positions(model, &model.registry.nominal(), &points)
    }
}
