//! Image of a campaign file.

use std::collections::BTreeMap;

use indexmap::IndexMap;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::description::units::Units;
use crate::observation::Observes;

/// One set of measurements of one robot: what was measured, with what, and where the readings are.
#[derive(Debug, Clone, Default, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct RawCampaign {
    /// Display name.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub campaign: Option<String>,
    /// Where the readings come from.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub source: Option<String>,
    /// A bundled description's name, or a path relative to this file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub robot: Option<String>,
    /// Units of this file and of the measurements; SI where absent.
    pub units: Units,
    /// What a reading is.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub observes: Option<Observes>,
    /// The instrument's noise; estimated from the residuals where absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub instrument: Option<RawInstrument>,
    /// What of the measuring arrangement is unknown.
    pub estimate: RawEstimate,
    /// Effects known to be present everywhere; re-fitted with whatever is tried, never offered as the cause.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub calibrate: Vec<String>,
    /// Named elements of the description that this evaluation leaves out.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub without: Vec<String>,
    /// Fixed points from which distances are measured, in the measurement frame, by name; in addition to the description's.
    #[serde(skip_serializing_if = "IndexMap::is_empty")]
    pub anchors: IndexMap<String, [f64; 3]>,
    /// File or files of readings, relative to this file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub measurements: Option<OneOrMany>,
    /// Columns that are named otherwise in the files: our name, the file's name.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub columns: BTreeMap<String, String>,
    /// Columns of the files to pass over.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub ignore: Vec<String>,
    /// How the files are written.
    pub csv: RawCsv,
}

/// The instrument's noise, one sigma.
#[derive(Debug, Clone, Default, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct RawInstrument {
    /// Of each coordinate or distance, in the length unit: one number, or by axis.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sigma: Option<RawSigma>,
    /// Of each component of the orientation, in the angle unit.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub orientation: Option<f64>,
}

/// Noise of a coordinate.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(untagged)]
pub enum RawSigma {
    /// The same along all axes.
    All(f64),
    /// By axis.
    ByAxis {
        /// Along x.
        x: f64,
        /// Along y.
        y: f64,
        /// Along z.
        z: f64,
    },
}

/// What of the measuring arrangement is unknown and estimated.
#[derive(Debug, Clone, Default, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct RawEstimate {
    /// The pose of the robot's base in the measurement frame.
    pub base: bool,
    /// The markers, or the tool centre point.
    pub tool: bool,
}

/// One file name or several.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(untagged)]
pub enum OneOrMany {
    /// One.
    One(String),
    /// Several, of the same columns.
    Many(Vec<String>),
}

/// How CSV files are written.
#[derive(Debug, Clone, Default, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct RawCsv {
    /// Between fields; guessed from the header line where absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub delimiter: Option<char>,
    /// `.` or `,`; where absent a point between commas, else that of the first number that has one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub decimal: Option<char>,
    /// Most rows accepted of one file; a million where absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max_rows: Option<usize>,
}
