//! Errors of a set of readings, mm and deg.

use serde::Serialize;

use super::units::{deg, mm};
use crate::estimation::Errors;

/// Whether the fit has seen a reading.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum FitOrCheck {
    /// Fitted.
    Fit,
    /// Held out.
    Check,
}

impl FitOrCheck {
    /// Of a reading that is held out, or not.
    pub fn of(is_held_out: bool) -> Self {
        if is_held_out { Self::Check } else { Self::Fit }
    }
}

/// Root mean square and greatest error of a coordinate, mm.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct CoordinateErrors {
    /// Root mean square error, mm.
    pub rms: f64,
    /// Greatest magnitude of an error, mm.
    pub max: f64,
}

/// Orientation errors of poses, deg.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct OrientationErrors {
    /// Unit of the errors.
    pub unit: &'static str,
    /// Mean angle.
    pub mean: f64,
    /// Root mean square angle.
    pub rms: f64,
    /// Greatest angle.
    pub max: f64,
}

/// Position errors (of distances: their absolute errors) of a set of readings, mm.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ReadingErrors {
    /// Number of readings.
    pub readings: usize,
    /// Mean position error; 0 where no reading holds a length.
    pub mean: f64,
    /// Root mean square position error; 0 where no reading holds a length.
    pub rms: f64,
    /// Greatest position error; 0 where no reading holds a length.
    pub max: f64,
    /// Errors of single coordinates.
    pub coordinate: CoordinateErrors,
    /// Of poses only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub orientation: Option<OrientationErrors>,
    /// Of torques (N.m) and forces (N) of joints only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub load: Option<LoadErrors>,
}

/// Errors of torques of joints, N.m; of sliding joints' forces, N.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct LoadErrors {
    /// Mean magnitude of the error.
    pub mean: f64,
    /// Root mean square error.
    pub rms: f64,
    /// Greatest magnitude of an error.
    pub max: f64,
}

impl ReadingErrors {
    /// `None` of no readings.
    pub fn new(errors: &Errors) -> Option<Self> {
        let [mean, rms, max] = errors.distance.map(mm);
        let orientation = errors.orientation.map(|all| {
            let [mean, rms, max] = all.map(deg);
            OrientationErrors { unit: "deg", mean, rms, max }
        });
        let [coordinate_rms, coordinate_max] = errors.coordinate.map(mm);
        let coordinate = CoordinateErrors { rms: coordinate_rms, max: coordinate_max };
        let load = errors.load.map(|[mean, rms, max]| LoadErrors { mean, rms, max });
        let all = Self { readings: errors.readings, mean, rms, max, coordinate, orientation, load };
        (errors.readings > 0).then_some(all)
    }

    /// Whether lengths are among them: readings of angles or torques alone have none, and their errors in mm are zero.
    pub fn has_lengths(&self) -> bool {
        self.max > 0.0 || self.orientation.is_none() && self.load.is_none()
    }
}
