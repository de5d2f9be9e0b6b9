//! What `residuals` finds: a description against measurements, nothing fitted. Lengths in mm, angles in deg.

use indexmap::IndexMap;
use serde::Serialize;

use super::configurations::ConfigurationResidual;
use super::errors::ReadingErrors;
use super::own_weight::OwnWeight;
use super::parts::{PartErrors, WorstReading, parts, target, worst};
use super::units::{deg, mm};
use crate::description::campaign::{Campaign, Reading};
use crate::estimation::errors_of;
use crate::math::{distinct, mean_rms_max};
use crate::model::Model;

/// One reading: measured less predicted.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ReadingResidual {
    /// Row of the measurements' file.
    pub row: usize,
    /// Name of the configuration.
    pub pose: String,
    /// `TCP` is the tool centre point.
    pub marker: String,
    /// What it refers to, as a socket or the sensor of a joint.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub target: Option<String>,
    /// Of x, y, z, or of the distance.
    pub error: Vec<f64>,
    /// Standard uncertainty of the predicted position along x, y, z of the base, where the description says how it was fitted;
    /// the noise of the reading is no part of it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub standard_uncertainty: Option<[f64; 3]>,
    /// Rotation vector, of poses.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub orientation_error_deg: Option<Vec<f64>>,
    /// Of a torque or force, N.m or N.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub load_error: Option<f64>,
}

/// What `residuals` finds.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DescriptionResiduals {
    /// Unit of position errors.
    pub unit: &'static str,
    /// Whether the predictions hold the deflection by own weight.
    pub own_weight: OwnWeight,
    /// Parameters that the campaign calls unknown and that a description does not hold: fitted to these readings first.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub fitted: Vec<String>,
    /// Errors of all readings; `None` where there are none.
    pub all: Option<ReadingErrors>,
    /// Readings marked `fit`.
    pub fit: Option<ReadingErrors>,
    /// Readings marked `check`.
    pub check: Option<ReadingErrors>,
    /// Errors by marker; `TCP` is the tool centre point.
    pub markers: IndexMap<String, Option<ReadingErrors>>,
    /// By session, station, file and kind, where there are several.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub parts: Vec<PartErrors>,
    /// Root mean square standard uncertainty of the predicted positions, where the description says how it was fitted.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub predicted_uncertainty: Option<f64>,
    /// Observed and predicted error of each configuration, where the description says how it was fitted.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub configurations: Vec<ConfigurationResidual>,
    /// The readings that the description fits worst.
    pub worst: Vec<WorstReading>,
    /// Root mean square error along x, y, z.
    pub directions: Vec<f64>,
    /// Residuals of each reading.
    pub readings: Vec<ReadingResidual>,
}

impl DescriptionResiduals {
    /// [`Self::parts`], and the markers.
    pub fn parts_and_markers(&self) -> Vec<PartErrors> {
        let of_marker = |(name, errors): (&String, &Option<ReadingErrors>)| {
            errors.map(|errors| PartErrors { part: "marker", name: name.clone(), errors })
        };
        self.parts.iter().cloned().chain(self.markers.iter().filter_map(of_marker)).collect()
    }

    /// From residuals as [`crate::prediction::Linearised::residual`].
    pub fn new(model: &Model, campaign: &Campaign, residual: &[f64]) -> Self {
        let errors = |among: &dyn Fn(usize) -> bool| ReadingErrors::new(&errors_of(campaign, residual, among));
        let marker = |index: usize| campaign.readings[index].marker.map_or("TCP", |m| model.markers[m].name.as_str());
        let names: Vec<&str> = distinct((0..campaign.readings.len()).map(marker));
        let lengths = |reading: &Reading| reading.observes.length_rows();
        let along = |k: usize| {
            let with = campaign.by_reading(residual, 1).filter(|(reading, _)| lengths(reading) > k);
            mm(mean_rms_max(with.map(|(_, own)| own[k]))[1])
        };
        let directions = campaign.readings.iter().map(lengths).max().unwrap_or(0).min(3);
        let readings = campaign.by_reading(residual, 1).enumerate();
        Self {
            unit: "mm",
            own_weight: OwnWeight::of_campaign(model, &model.registry.nominal(), campaign),
            fitted: Vec::new(),
            all: errors(&|_| true),
            fit: errors(&|i| campaign.readings[i].check == Some(false)),
            check: errors(&|i| campaign.readings[i].check == Some(true)),
            markers: names.iter().map(|name| ((*name).to_string(), errors(&|i| marker(i) == *name))).collect(),
            parts: parts(model, campaign, residual, |_| true).into_iter().filter(|p| p.part != "marker").collect(),
            predicted_uncertainty: None,
            configurations: Vec::new(),
            worst: worst(model, campaign, residual, &[]),
            directions: (0..directions).map(along).collect(),
            readings: readings
                .map(|(index, (reading, residual))| ReadingResidual {
                    row: reading.row,
                    pose: campaign.poses[reading.pose].clone(),
                    marker: marker(index).to_string(),
                    target: target(campaign, reading),
                    standard_uncertainty: None,
                    error: residual[..lengths(reading)].iter().map(|v| mm(*v)).collect(),
                    orientation_error_deg: residual
                        .get(lengths(reading)..)
                        .filter(|own| !own.is_empty() && reading.observes.by_variable().is_none())
                        .map(|own| own.iter().map(|v| deg(*v)).collect()),
                    load_error: reading.observes.by_variable().and(residual.first().copied()),
                })
                .collect(),
        }
    }

    /// The same with the standard uncertainties (m) of the positions predicted for all readings; those of angles and torques have
    /// none.
    #[must_use]
    pub fn with_uncertainties(mut self, campaign: &Campaign, all: &[[f64; 3]]) -> Self {
        let has_lengths = campaign.readings.iter().map(|reading| reading.observes.length_rows() > 0);
        let placed: Vec<(usize, &[f64; 3])> = all
            .iter()
            .enumerate()
            .zip(has_lengths)
            .filter_map(|(own, has_lengths)| has_lengths.then_some(own))
            .collect();
        if placed.is_empty() {
            return self;
        }
        let square = |own: &[f64; 3]| own.iter().map(|u| u * u).sum::<f64>();
        let mean = placed.iter().map(|(_, own)| square(own)).sum::<f64>() / placed.len() as f64;
        self.predicted_uncertainty = Some(mm(mean.sqrt()));
        for (index, own) in placed {
            if let Some(reading) = self.readings.get_mut(index) {
                reading.standard_uncertainty = Some(own.map(mm));
            }
        }
        self
    }
}
