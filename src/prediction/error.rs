//! Why readings cannot be predicted.

use crate::description::campaign::Campaign;
use crate::elastics::Mechanism;
use crate::kinematics::AssemblyError;
use crate::state::StateError;

/// Why readings cannot be predicted.
#[derive(Debug, Clone, thiserror::Error)]
pub enum PredictionError {
    /// A configuration cannot be assembled.
    #[error("{at} (configuration `{pose}`): {source}")]
    Assembly {
        /// Where the reading stands: file and line; its row where it came from no file.
        at: String,
        /// Its configuration.
        pose: String,
        /// Why.
        source: AssemblyError,
    },
    /// The model cannot be assembled at all.
    #[error(transparent)]
    Model(#[from] AssemblyError),
    /// The structure can move without any force.
    #[error("{at} (configuration `{pose}`): {source}")]
    Mechanism {
        /// Where the reading stands: file and line; its row where it came from no file.
        at: String,
        /// Its configuration.
        pose: String,
        /// What can move.
        source: Mechanism,
    },
    /// A load is beyond what statics can be computed with.
    #[error("{at} (configuration `{pose}`): the deflection is not finite; the wrench is too great")]
    TooGreat {
        /// Where the reading stands: file and line; its row where it came from no file.
        at: String,
        /// Its configuration.
        pose: String,
    },
    /// No readings.
    #[error("the campaign has no readings")]
    Empty,
}

impl PredictionError {
    /// Why the configuration of a reading cannot be placed.
    pub(crate) fn at(campaign: &Campaign, reading: usize, source: StateError) -> Self {
        let reading = &campaign.readings[reading];
        let (at, pose) = (campaign.address(reading), campaign.poses[reading.pose].clone());
        match source {
            StateError::Assembly(source) => Self::Assembly { at, pose, source },
            StateError::Mechanism(source) => Self::Mechanism { at, pose, source },
        }
    }
}
