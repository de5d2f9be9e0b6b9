//! Deflections as samples of a compliance: inputs in rad and m, loads in N and N.m, displacements in m, base axes.

use nalgebra::{Rotation3, Vector3};

use super::task::FuzzyTask;
use crate::estimation::result::CalibrationError;
use crate::fuzzy;
use crate::kinematics::{Geometry, Placements};
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
    pub held_out: Vec<bool>,
    /// Components of the load that occur among the fitted readings.
    pub columns: Vec<usize>,
    /// Least and greatest of each input among the fitted readings.
    pub range: Vec<[f64; 2]>,
}

impl Samples {
    /// The measured displacements, with the geometry at `values`.
    pub fn measured(task: &FuzzyTask, values: &[f64]) -> Result<Self, CalibrationError> {
        let readings = task.campaign.readings.iter();
        let all: Vec<f64> = readings.flat_map(|reading| reading.measured.into_iter().take(3)).collect();
        Self::new(task, values, &all)
    }

    /// Displacements (m, three a reading, axes of the measurement frame), with the geometry at `values`.
    pub fn new(task: &FuzzyTask, values: &[f64], displacement: &[f64]) -> Result<Self, CalibrationError> {
        let FuzzyTask { model, campaign, held_out, inputs: of, .. } = *task;
        let malformed = |text: &str| Err(CalibrationError::Malformed(text.into()));
        if !campaign.observes.is_difference() {
            return malformed("a fuzzy compliance is fitted to deflections (`observes: deflection`)");
        }
        let Some(first) = campaign.readings.first() else { return malformed("the campaign has no readings") };
        if campaign.readings.iter().any(|reading| reading.marker != first.marker) {
            return malformed("a fuzzy compliance is that of one point: give the readings of one marker only");
        }
        if held_out.iter().all(|held_out| *held_out) {
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
        let fitted =
            || campaign.readings.iter().zip(held_out).filter(|(_, held_out)| !**held_out).map(|(reading, _)| reading);
        let range = |k: usize| {
            let seen = x.iter().zip(held_out).filter(|(_, held_out)| !**held_out).map(|(x, _)| x[k]);
            seen.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| [low.min(v), high.max(v)])
        };
        Ok(Self {
            marker: first.marker,
            range: (0..of.len()).map(range).collect(),
            columns: (0..6).filter(|&k| fitted().any(|reading| reading.wrench[k] != 0.0)).collect(),
            load: campaign.readings.iter().map(|reading| reading.wrench).collect(),
            d: displacement.chunks(3).map(|d| turn * Vector3::from_column_slice(d)).collect(),
            pose: campaign.readings.iter().map(|reading| reading.pose).collect(),
            held_out: held_out.to_vec(),
            x,
        })
    }

    /// Samples that are fitted (or not) and for which `among` holds.
    pub fn indices(&self, held_out: bool, among: impl Fn(usize) -> bool) -> Vec<usize> {
        (0..self.x.len()).filter(|&k| self.held_out[k] == held_out && among(k)).collect()
    }
}
