//! What a sealed campaign hides.

use serde::{Deserialize, Serialize};

use crate::settings::named;

named! {
    /// What a sealed campaign hides.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
    #[serde(rename_all = "kebab-case")]
    pub enum Kind {
        /// One effect.
        Single "single",
        /// Two.
        Pair "pair",
        /// Three.
        Triple "triple",
        /// None.
        Null "null",
        /// What no catalogue knows.
        Unknown "unknown",
        /// One effect, then what no catalogue knows.
        Mixture "mixture",
        /// None, and readings that are not what they are said to be.
        Trap "trap",
        /// One effect, diagnosed with that effect taken out of the catalogue.
        LeftOut "left-out",
    }
}

impl Kind {
    /// Number of causes.
    pub(super) fn causes(self) -> usize {
        match self {
            Self::Null | Self::Trap => 0,
            Self::Single | Self::Unknown | Self::LeftOut => 1,
            Self::Pair | Self::Mixture => 2,
            Self::Triple => 3,
        }
    }
}

/// What a sealed campaign hides.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Truth {
    /// Name of the campaign.
    pub name: String,
    /// Kind.
    pub kind: Kind,
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
