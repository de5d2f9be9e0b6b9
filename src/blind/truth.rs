//! What a sealed campaign hides.

use serde::{Deserialize, Serialize};

/// What a sealed campaign hides.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Truth {
    /// Name of the campaign.
    pub name: String,
    /// Kind: single, pair, triple, null, unknown, mixture, trap.
    pub kind: String,
    /// Robot.
    pub robot: String,
    /// What a reading is.
    pub observes: String,
    /// One sigma of a coordinate, m; where it differs between readings, its root mean square.
    pub noise: f64,
    /// Root mean square after calibration, over that of the noise.
    pub gap: f64,
    /// Causes.
    pub causes: Vec<TruthCause>,
    /// Rows of outliers.
    pub outliers: Vec<usize>,
    /// The noise, where there are several kinds.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub instrument: Option<Instrument>,
}

/// The noise of a sealed campaign.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Instrument {
    /// Its kind.
    pub noise: String,
    /// Whether the campaign states its size.
    pub is_stated: bool,
}

/// A cause that was put in.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TruthCause {
    /// Effect of the catalogue, or what else it is.
    pub effect: String,
    /// Where it sits; empty where that has no name.
    pub site: String,
    /// Its size, of its shape.
    pub size: f64,
    /// The gap that it alone leaves, over the noise.
    pub gap: f64,
    /// Its shape.
    pub shape: String,
    /// What it adds to each coordinate of the readings, m; empty where it was not recorded.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub adds: Vec<f64>,
}
