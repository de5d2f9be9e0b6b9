//! Campaigns: measurements of a robot, resolved against its model, in SI.

mod conditions;
mod doubts;
mod faults;
pub mod raw;
mod read;
mod rows;
mod write;

use indexmap::IndexMap;
use nalgebra::Vector3;

use crate::observation::{Noise, Observes, Rows};
pub use conditions::{ConditionColumn, Conditions};
pub use faults::faults;
pub use read::{expected_columns, resolve};
pub use write::csv;

/// Columns of the applied wrench: force and moment, base axes.
pub const WRENCH: [&str; 6] = ["fx", "fy", "fz", "mx", "my", "mz"];

/// Measurements of one robot. Lengths in m, angles in rad, forces in N, torques in N.m, times in s, temperatures in K or degC
/// as given.
#[derive(Debug, Clone, PartialEq)]
pub struct Campaign {
    /// Display name.
    pub name: String,
    /// What a reading is.
    pub observes: Observes,
    /// One sigma of each coordinate (of a distance: the first), if stated.
    pub sigma: Option<[f64; 3]>,
    /// One sigma of each component of an orientation, if stated.
    pub sigma_orientation: Option<f64>,
    /// Whether the base's pose in the measurement frame is unknown.
    pub estimate_base: bool,
    /// Whether markers or tool are unknown.
    pub estimate_tool: bool,
    /// Effects re-fitted whatever is tried.
    pub calibrate: Vec<String>,
    /// Elements left out.
    pub without: Vec<String>,
    /// Fixed points in the measurement frame.
    pub anchors: IndexMap<String, Vector3<f64>>,
    /// Names of the configurations.
    pub poses: Vec<String>,
    /// Number of variables in each reading's configuration.
    pub variables: usize,
    /// Variables of all readings, one after the other.
    pub joints: Vec<f64>,
    /// The readings.
    pub readings: Vec<Reading>,
    /// Conditions under which the readings were taken.
    pub conditions: Conditions,
}

/// One reading.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reading {
    /// Row in the files, header and empty lines left out, counted from 1 through all files.
    pub row: usize,
    /// Configuration, by index in [`Campaign::poses`].
    pub pose: usize,
    /// The marker measured; `None` is the tool centre point.
    pub marker: Option<usize>,
    /// The measured values, in the order of the columns of [`Campaign::observes`], m and rad.
    pub measured: Rows,
    /// The anchor, by index in [`Campaign::anchors`], where [`Campaign::observes`] needs one.
    pub anchor: usize,
    /// Force and torque applied on the tool at the marker, base axes.
    pub wrench: [f64; 6],
    /// Whether the reading is held out to check, if the file says so.
    pub check: Option<bool>,
}

impl Campaign {
    /// Variables of a reading.
    pub fn configuration(&self, reading: usize) -> &[f64] {
        &self.joints[reading * self.variables..(reading + 1) * self.variables]
    }

    /// Number of residuals of a reading.
    pub fn components(&self) -> usize {
        self.observes.rows()
    }

    /// The instrument's noise, one sigma: as stated, else 1 mm and 1 mrad. Where only that of positions is stated, a
    /// rotation vector has the same number in rad: a component of it weighs as much as a coordinate at an arm of 1 m.
    pub fn noise(&self) -> Noise {
        let orientation = self.sigma_orientation.unwrap_or_else(|| self.sigma.map_or(1e-3, |sigma| sigma[0]));
        Noise { position: self.sigma.unwrap_or([1e-3; 3]), orientation }
    }

    /// Anchors to which each point is measured; one (of no meaning) where the kind of reading needs none.
    pub fn anchors_per_point(&self) -> usize {
        if self.observes.anchor_column().is_some() { self.anchors.len().max(1) } else { 1 }
    }

    /// The anchor of a reading, m, measurement frame; the origin where it has none.
    pub fn anchor(&self, reading: &Reading) -> Vector3<f64> {
        self.anchors.get_index(reading.anchor).map_or_else(Vector3::zeros, |(_, at)| *at)
    }

    /// The campaign with only the readings for which `keep` holds.
    #[must_use]
    pub fn select(&self, keep: impl Fn(usize, &Reading) -> bool) -> Self {
        let kept: Vec<usize> = (0..self.readings.len()).filter(|&i| keep(i, &self.readings[i])).collect();
        Self {
            joints: kept.iter().flat_map(|&i| self.configuration(i).iter().copied()).collect(),
            readings: kept.iter().map(|&i| self.readings[i]).collect(),
            conditions: self.conditions.select(&kept),
            name: self.name.clone(),
            calibrate: self.calibrate.clone(),
            without: self.without.clone(),
            anchors: self.anchors.clone(),
            poses: self.poses.clone(),
            ..*self
        }
    }
}
