//! Deflections as samples of a compliance.

use nalgebra::{Rotation3, Vector3};

use crate::description::campaign::{Campaign, Observes};
use crate::description::fuzzy::Input;
use crate::estimation::{Calibration, CalibrationError};
use crate::kinematics::{Geometry, Placements};
use crate::model::Model;
use crate::prediction::PredictionError;
use crate::surrogate;

/// Readings of one marker: inputs, load and displacement, base axes.
pub struct Samples {
    pub marker: Option<usize>,
    /// Inputs, rad and m.
    pub x: Vec<Vec<f64>>,
    pub load: Vec<[f64; 6]>,
    /// Displacement to be explained, m.
    pub d: Vec<Vector3<f64>>,
    pub pose: Vec<usize>,
    pub aside: Vec<bool>,
    /// Components of the load that occur among the fitted readings.
    pub columns: Vec<usize>,
    /// Least and greatest of each input among the fitted readings.
    pub range: Vec<[f64; 2]>,
}

impl Samples {
    /// What was measured.
    pub fn measured(
        model: &Model,
        campaign: &Campaign,
        aside: &[bool],
        of: &[Input],
    ) -> Result<Self, CalibrationError> {
        let all: Vec<f64> = campaign.readings.iter().flat_map(|reading| reading.measured[..3].to_vec()).collect();
        Self::new(model, campaign, aside, of, &model.registry.nominal(), &all)
    }

    /// What a calibration leaves.
    pub fn left(
        model: &Model,
        campaign: &Campaign,
        aside: &[bool],
        of: &[Input],
        found: &Calibration,
    ) -> Result<Self, CalibrationError> {
        Self::new(model, campaign, aside, of, &found.values, &found.residual)
    }

    fn new(
        model: &Model,
        campaign: &Campaign,
        aside: &[bool],
        of: &[Input],
        values: &[f64],
        displacement: &[f64],
    ) -> Result<Self, CalibrationError> {
        let malformed = |text: &str| Err(CalibrationError::Malformed(text.into()));
        if campaign.observes != Observes::Deflection {
            return malformed("a fuzzy compliance is fitted to deflections (`observes: deflection`)");
        }
        let Some(first) = campaign.readings.first() else { return malformed("the campaign has no readings") };
        if campaign.readings.iter().any(|reading| reading.marker != first.marker) {
            return malformed("a fuzzy compliance is that of one point: give the readings of one marker only");
        }
        if aside.iter().all(|aside| *aside) {
            return malformed("no reading is left to fit");
        }
        if of.is_empty() {
            return malformed("nothing that the compliance could depend on changes in the readings");
        }
        let geometry = Geometry::new(model, values).map_err(PredictionError::from)?;
        let turn: Rotation3<f64> = geometry.base().rotation.inverse();
        let mut placements = Placements::default();
        let mut x = Vec::with_capacity(campaign.readings.len());
        for index in 0..campaign.readings.len() {
            let q = campaign.configuration(index);
            geometry.place(q, &mut placements).map_err(PredictionError::from)?;
            let mut inputs = Vec::new();
            surrogate::inputs(of, q, &placements, &mut inputs);
            x.push(inputs);
        }
        let fitted = || campaign.readings.iter().zip(aside).filter(|(_, aside)| !**aside).map(|(reading, _)| reading);
        let range = |k: usize| {
            let seen = x.iter().zip(aside).filter(|(_, aside)| !**aside).map(|(x, _)| x[k]);
            seen.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| [low.min(v), high.max(v)])
        };
        Ok(Self {
            marker: first.marker,
            range: (0..of.len()).map(range).collect(),
            columns: (0..6).filter(|&k| fitted().any(|reading| reading.wrench[k] != 0.0)).collect(),
            load: campaign.readings.iter().map(|reading| reading.wrench).collect(),
            d: displacement.chunks(3).map(|d| turn * Vector3::from_column_slice(d)).collect(),
            pose: campaign.readings.iter().map(|reading| reading.pose).collect(),
            aside: aside.to_vec(),
            x,
        })
    }

    /// Samples that are fitted (or not) and for which `among` holds.
    pub fn indices(&self, aside: bool, among: impl Fn(usize) -> bool) -> Vec<usize> {
        (0..self.x.len()).filter(|&k| self.aside[k] == aside && among(k)).collect()
    }
}

/// Whether what is measured under loads of one size is what the model, linear in the load, says.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Level {
    /// Force, N.
    pub force: f64,
    /// Number of readings.
    pub readings: usize,
    /// Measured over predicted displacement, by least squares; 1 if linear.
    pub gain: f64,
    /// Its standard error.
    pub sigma: f64,
}

/// Readings by the size of their force (whole newtons), from residuals of the model.
pub fn levels(campaign: &Campaign, residual: &[f64]) -> Vec<Level> {
    let mut sizes: Vec<(i64, usize)> = campaign
        .readings
        .iter()
        .enumerate()
        .map(|(k, reading)| (Vector3::from_column_slice(&reading.wrench[..3]).norm().round() as i64, k))
        .collect();
    sizes.sort_unstable();
    sizes
        .chunk_by(|a, b| a.0 == b.0)
        .map(|level| {
            let (mut dot, mut squares, mut left) = (0.0, 0.0, 0.0);
            for &(_, k) in level {
                let measured = Vector3::from_column_slice(&campaign.readings[k].measured[..3]);
                let predicted = measured - Vector3::from_column_slice(&residual[3 * k..3 * k + 3]);
                dot += measured.dot(&predicted);
                squares += predicted.norm_squared();
                left += (measured - predicted).norm_squared();
            }
            let gain = dot / squares;
            let degrees = (3 * level.len()).saturating_sub(1).max(1) as f64;
            let sigma = ((left - (gain - 1.0).powi(2) * squares).max(0.0) / degrees / squares).sqrt();
            Level { force: level[0].0 as f64, readings: level.len(), gain, sigma }
        })
        .collect()
}
