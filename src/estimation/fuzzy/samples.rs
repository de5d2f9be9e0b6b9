//! Deflections as samples of a compliance.

use std::collections::BTreeMap;

use nalgebra::{Rotation3, Vector3};

use crate::description::campaign::Campaign;
use crate::description::fuzzy::Input;
use crate::estimation::{Calibration, CalibrationError};
use crate::fuzzy;
use crate::kinematics::{Geometry, Placements};
use crate::model::Model;
use crate::prediction::PredictionError;

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
        if !campaign.observes.is_difference() {
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
            fuzzy::inputs(of, q, &placements, &mut inputs);
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
    /// Measured over predicted displacement, by least squares.
    pub gain: f64,
    /// Its standard error.
    pub sigma: f64,
    /// The same beside loads of other sizes in the same directions, and its standard error: 1 if linear. None where no
    /// direction was loaded by several sizes.
    pub linear: Option<[f64; 2]>,
}

/// Sums by which a gain is fitted: measured times predicted, predicted squared, measured squared, and number of rows.
#[derive(Debug, Clone, Copy, Default)]
struct Sums {
    dot: f64,
    predicted: f64,
    measured: f64,
    rows: f64,
}

impl Sums {
    fn add(&mut self, other: &Self) {
        self.dot += other.dot;
        self.predicted += other.predicted;
        self.measured += other.measured;
        self.rows += other.rows;
    }

    /// Gain and its standard error.
    fn gain(&self) -> [f64; 2] {
        let gain = self.dot / self.predicted;
        let left = (self.measured - gain * self.dot).max(0.0);
        [gain, (left / (self.rows - 1.0).max(1.0) / self.predicted).sqrt()]
    }
}

/// Readings by the size of their force (whole newtons), from residuals of the model.
pub fn levels(campaign: &Campaign, residual: &[f64]) -> Vec<Level> {
    // By size, and among these by direction (to a degree or so).
    let mut cells: BTreeMap<(i64, [i64; 3]), Sums> = BTreeMap::new();
    for (k, reading) in campaign.readings.iter().enumerate() {
        let force = Vector3::from_column_slice(&reading.wrench[..3]);
        let size = force.norm();
        let way = force.map(|f| if size > 0.0 { (50.0 * f / size).round() as i64 } else { 0 });
        let measured = Vector3::from_column_slice(&reading.measured[..3]);
        let predicted = measured - Vector3::from_column_slice(&residual[3 * k..3 * k + 3]);
        cells.entry((size.round() as i64, way.into())).or_default().add(&Sums {
            dot: measured.dot(&predicted),
            predicted: predicted.norm_squared(),
            measured: measured.norm_squared(),
            rows: 3.0,
        });
    }
    // What the model is off in a direction is off at all sizes: linear is what the sizes have in common.
    let mut ways: BTreeMap<[i64; 3], (usize, Sums)> = BTreeMap::new();
    for ((_, way), sums) in &cells {
        let own = ways.entry(*way).or_default();
        own.0 += 1;
        own.1.add(sums);
    }
    let mut sizes: Vec<i64> = cells.keys().map(|(size, _)| *size).collect();
    sizes.dedup();
    let level = |size: i64| {
        let (mut all, mut compared) = (Sums::default(), Sums::default());
        for ((_, way), sums) in cells.iter().filter(|((own, _), _)| *own == size) {
            all.add(sums);
            let Some((_, common)) = ways.get(way).filter(|(count, _)| *count > 1) else { continue };
            let [gain, _] = common.gain();
            compared.add(&Sums { dot: gain * sums.dot, predicted: gain * gain * sums.predicted, ..*sums });
        }
        let [gain, sigma] = all.gain();
        let linear = (compared.rows > 0.0).then(|| compared.gain());
        Level { force: size as f64, readings: (all.rows / 3.0).round() as usize, gain, sigma, linear }
    };
    sizes.into_iter().map(level).collect()
}
