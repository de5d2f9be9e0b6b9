//! Campaigns: measurements of a robot, resolved against its model, in SI.

mod doubts;
pub mod raw;
mod read;

use indexmap::IndexMap;
use nalgebra::Vector3;

pub use raw::Observes;
pub use read::{expected_columns, faults, resolve};

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
    /// Conditions of each reading, by column: `approach.<variable>`, `temperature`, `temperature.<site>`, `time`.
    pub conditions: IndexMap<String, Vec<f64>>,
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
    /// Position (or deflection), and rotation vector of a pose; of a distance: the distance.
    pub measured: [f64; 6],
    /// The anchor of a distance, by index in [`Campaign::anchors`].
    pub anchor: usize,
    /// Force and torque applied on the tool at the marker, base axes.
    pub wrench: [f64; 6],
    /// Whether the reading was set aside to check, if the file says so.
    pub check: Option<bool>,
}

impl Campaign {
    /// Variables of a reading.
    pub fn configuration(&self, reading: usize) -> &[f64] {
        &self.joints[reading * self.variables..(reading + 1) * self.variables]
    }

    /// Number of residuals of a reading: 3, 6 (pose) or 1 (distance).
    pub fn components(&self) -> usize {
        match self.observes {
            Observes::Position | Observes::Deflection => 3,
            Observes::Pose => 6,
            Observes::Distance => 1,
        }
    }

    /// The campaign with only the readings for which `keep` holds.
    #[must_use]
    pub fn select(&self, keep: impl Fn(usize, &Reading) -> bool) -> Self {
        let kept: Vec<usize> = (0..self.readings.len()).filter(|&i| keep(i, &self.readings[i])).collect();
        Self {
            joints: kept.iter().flat_map(|&i| self.configuration(i).iter().copied()).collect(),
            readings: kept.iter().map(|&i| self.readings[i]).collect(),
            conditions: self
                .conditions
                .iter()
                .map(|(name, all)| (name.clone(), kept.iter().map(|&i| all[i]).collect()))
                .collect(),
            name: self.name.clone(),
            calibrate: self.calibrate.clone(),
            without: self.without.clone(),
            anchors: self.anchors.clone(),
            poses: self.poses.clone(),
            ..*self
        }
    }
}
