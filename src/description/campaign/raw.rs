//! Image of a campaign file.

use std::collections::BTreeMap;

use indexmap::IndexMap;
#[cfg(feature = "cli")]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

pub use super::raw_certificate::RawCertificate;
pub use super::raw_files::{Format, PointField, RawCsv, RawPoints};
pub use super::raw_instrument::{RawInstrument, RawSigma};
pub use super::raw_measurements::{Measurements, RawEntry, RawKinds, RawSharing, StandsOn};
pub use super::raw_targets::{ContactKind, OrUnknown, RawAnchor, RawContact, RawDeclaredAnchor, RawTorque, Unknown};
use super::sessions::Sharing;
use crate::description::raw::{RawPayload, format_version};
use crate::description::table::Orientation;
use crate::description::units::Units;
use crate::observation::Kinds;

/// One set of measurements of one robot: what was measured, with what, and where the readings are.
#[derive(Debug, Clone, Default, PartialEq, Deserialize, Serialize)]
#[cfg_attr(feature = "cli", derive(JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct RawCampaign {
    /// Version of this format: 2 where it is stated.
    #[serde(skip_serializing_if = "Option::is_none", deserialize_with = "format_version")]
    #[cfg_attr(feature = "cli", schemars(range(min = 1, max = 2)))]
    pub format: Option<u32>,
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
    /// What a reading is; a list where one row holds several.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub observes: Option<RawKinds>,
    /// The instrument's noise; estimated from the residuals where absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub instrument: Option<RawInstrument>,
    /// What of the measuring arrangement is unknown.
    pub estimate: RawEstimate,
    /// Effects known to be present everywhere; refitted with each hypothesis, never offered as the cause. Where it is left out, what
    /// `identify` fits: geometry and zeros of joints, or of deflections the description's springs. `[]` re-fits nothing.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub calibrate: Option<Vec<String>>,
    /// Named elements of the description that this evaluation leaves out.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub without: Vec<String>,
    /// Fixed points from which distances are measured, in the measurement frame, by name; in addition to the description's.
    #[serde(skip_serializing_if = "IndexMap::is_empty")]
    pub anchors: IndexMap<String, RawAnchor>,
    /// Places that a ball on the tool touches, by name.
    #[serde(skip_serializing_if = "IndexMap::is_empty")]
    pub contacts: IndexMap<String, RawContact>,
    /// Distances between contacts of one group, `a-b: distance`; `unknown` is one distance, the same in each placement.
    #[serde(skip_serializing_if = "IndexMap::is_empty")]
    pub distances: IndexMap<String, OrUnknown<f64>>,
    /// Known angles between faces (contacts of kind `plane`) of one group, `a-b: angle`: a datum cube has right ones.
    #[serde(skip_serializing_if = "IndexMap::is_empty")]
    pub angles: IndexMap<String, f64>,
    /// Bodies that the tool carries in some readings, by name; a column `payload` says in which.
    #[serde(skip_serializing_if = "IndexMap::is_empty")]
    pub payloads: IndexMap<String, RawPayload>,
    /// Sensors of joint torques, by variable: gain 1 and offset 0 where nothing is said.
    #[serde(skip_serializing_if = "IndexMap::is_empty")]
    pub torques: IndexMap<String, RawTorque>,
    /// What loads the joints.
    #[serde(skip_serializing_if = "RawLoads::is_described")]
    pub loads: RawLoads,
    /// Which joint values the model is evaluated at, where files hold both `commanded.<variable>` and
    /// `recorded.<variable>`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub joints: Option<JointSource>,
    /// What says in which order configurations were measured, where files have no column `order`: `rows` that rows stand as they were
    /// measured, which holds without a column `time` too; `unknown` that they have been sorted or mixed since.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub order: Option<RowOrder>,
    /// Files of readings, relative to this file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub measurements: Option<Measurements>,
    /// Files of fixed reflectors on base or pedestal, measured again while the robot was: columns pose, order, reflector, x,
    /// y, z, no joints.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub references: Option<Measurements>,
    /// Columns that are named otherwise in the files: our name, the file's name.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub columns: BTreeMap<String, String>,
    /// Columns of the files to pass over.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub ignore: Vec<String>,
    /// How orientations are written in the files: as rotation vectors where nothing is said.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub orientation: Option<Orientation>,
    /// How the files are written.
    pub csv: RawCsv,
    /// What a certificate says in addition to figures.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub certificate: Option<RawCertificate>,
}

/// What of the measuring arrangement is unknown and estimated.
#[derive(Debug, Clone, Default, PartialEq, Deserialize, Serialize)]
#[cfg_attr(feature = "cli", derive(JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct RawEstimate {
    /// The pose of the robot's base in the measurement frame.
    pub base: RawSharing,
    /// The markers, or the tool centre point.
    pub tool: RawSharing,
    /// The instrument's scale of lengths.
    #[serde(skip_serializing_if = "RawSharing::is_known")]
    pub scale: RawSharing,
}

impl RawCampaign {
    /// Its files of readings, each with all that holds of it.
    pub fn entries(&self) -> Vec<RawEntry> {
        self.measurements.iter().flat_map(|all| &all.0).map(|entry| self.completed(entry)).collect()
    }

    /// What holds of a file: its own words, and the campaign's where it has none.
    #[must_use]
    pub fn completed(&self, entry: &RawEntry) -> RawEntry {
        let mut all = entry.clone();
        all.observes = all.observes.or_else(|| self.observes.clone());
        let units = all.units(self.units);
        all.units = Some(units.into());
        let of_campaign = self.instrument.as_ref().map(|stated| stated.in_units(&self.units, &units));
        all.instrument = match (all.instrument, of_campaign) {
            (Some(own), Some(others)) => Some(own.or(others)),
            (own, others) => own.or(others),
        };
        all.orientation = all.orientation.or(self.orientation);
        all.csv = all.csv.or_else(|| Some(self.csv.clone()));
        for (ours, theirs) in &self.columns {
            all.columns.entry(ours.clone()).or_insert_with(|| theirs.clone());
        }
        all.ignore.extend(self.ignore.iter().cloned());
        all
    }

    /// Names of kinds of readings that are none of these, each with its path in the file.
    pub fn unknown_kinds(&self, kinds: &Kinds) -> Vec<(Vec<String>, &str)> {
        let entries = self.measurements.iter().flat_map(|all| all.0.iter().enumerate());
        let own = entries.map(|(k, entry)| (vec!["measurements".into(), k.to_string()], &entry.observes));
        let mut unknown = Vec::new();
        for (of, observes) in std::iter::once((Vec::new(), &self.observes)).chain(own) {
            for (k, name) in observes.iter().flat_map(|observes| observes.0.iter().enumerate()) {
                if kinds.named(name).is_none() {
                    unknown.push(([&of[..], &["observes".into(), k.to_string()]].concat(), name.as_str()));
                }
            }
        }
        unknown
    }
}

impl RawEstimate {
    /// Base and tool, unknown or not, the same in all readings.
    pub fn of([base, tool]: [bool; 2]) -> Self {
        let sharing = |is_unknown: bool| RawSharing(is_unknown.then_some(Sharing::All));
        Self { base: sharing(base), tool: sharing(tool), scale: sharing(false) }
    }
}

/// What loads the robot in the readings.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize, Serialize)]
#[cfg_attr(feature = "cli", derive(JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct RawLoads {
    /// Where the loads come from under which joints deflect.
    pub joints: LoadSource,
}

/// Where loads of joints come from.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize, Serialize)]
#[cfg_attr(feature = "cli", derive(JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum LoadSource {
    /// The description: masses, payloads, wrench, springs.
    #[default]
    Described,
    /// The columns `torque.<variable>`, where a file has them.
    Measured,
}

impl RawLoads {
    fn is_described(&self) -> bool {
        *self == Self::default()
    }
}

/// What says in which order configurations were measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize)]
#[cfg_attr(feature = "cli", derive(JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum RowOrder {
    /// The rows of the files.
    Rows,
    /// Nothing.
    Unknown,
}

/// Which of two values of each joint.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize)]
#[cfg_attr(feature = "cli", derive(JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum JointSource {
    /// What the controller commanded.
    Commanded,
    /// What the controller read.
    Recorded,
}

impl JointSource {
    /// The columns' prefix.
    pub fn prefix(self) -> &'static str {
        match self {
            Self::Commanded => "commanded",
            Self::Recorded => "recorded",
        }
    }
}
