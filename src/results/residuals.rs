//! What `residuals` finds: a description against measurements, nothing fitted. Lengths in mm, angles in deg.

use indexmap::IndexMap;
use serde::Serialize;

use super::errors::ReadingErrors;
use super::units::{deg, mm};
use crate::description::campaign::Campaign;
use crate::estimation::errors_of;
use crate::math::mean_rms_max;
use crate::model::Model;

/// One reading: measured less predicted.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ReadingResidual {
    /// Row of the measurements' file.
    pub row: usize,
    pub pose: String,
    /// `TCP` is the tool centre point.
    pub marker: String,
    /// Of x, y, z, or of the distance.
    pub error: Vec<f64>,
    /// Rotation vector, of poses.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub orientation_error_deg: Option<Vec<f64>>,
}

/// What `residuals` finds.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DescriptionResiduals {
    pub unit: &'static str,
    pub all: Option<ReadingErrors>,
    /// Readings marked `fit`.
    pub fit: Option<ReadingErrors>,
    /// Readings marked `check`.
    pub check: Option<ReadingErrors>,
    pub markers: IndexMap<String, Option<ReadingErrors>>,
    /// Root mean square error along x, y, z.
    pub directions: Vec<f64>,
    pub readings: Vec<ReadingResidual>,
}

impl DescriptionResiduals {
    /// From residuals as [`crate::prediction::Linearised::residual`].
    pub fn new(model: &Model, campaign: &Campaign, residual: &[f64]) -> Self {
        let errors = |among: &dyn Fn(usize) -> bool| ReadingErrors::new(&errors_of(campaign, residual, among));
        let marker = |index: usize| campaign.readings[index].marker.map_or("TCP", |m| model.markers[m].name.as_str());
        let mut names: Vec<&str> = (0..campaign.readings.len()).map(marker).collect();
        names.sort_unstable();
        names.dedup();
        let components = campaign.components();
        let direction = |k: usize| mm(mean_rms_max(residual.iter().skip(k).step_by(components).copied())[1]);
        let readings = campaign.readings.iter().zip(residual.chunks(components)).enumerate();
        Self {
            unit: "mm",
            all: errors(&|_| true),
            fit: errors(&|i| campaign.readings[i].check == Some(false)),
            check: errors(&|i| campaign.readings[i].check == Some(true)),
            markers: names.iter().map(|name| ((*name).to_string(), errors(&|i| marker(i) == *name))).collect(),
            directions: (0..components.min(3)).map(direction).collect(),
            readings: readings
                .map(|(index, (reading, residual))| ReadingResidual {
                    row: reading.row,
                    pose: campaign.poses[reading.pose].clone(),
                    marker: marker(index).to_string(),
                    error: residual.iter().take(3).map(|v| mm(*v)).collect(),
                    orientation_error_deg: residual.get(3..6).map(|r| r.iter().map(|v| deg(*v)).collect()),
                })
                .collect(),
        }
    }
}
