//! Diagnosis of the sim-to-real gap: where it lies, which effects cause it, how far it shrinks.
//!
//! What calibration can remove is projected off first. All effects at all their sites then compete with linear columns
//! for the residuals, without a new calibration for each. Figures are of readings that were not fitted. What nothing
//! explains is reported as unexplained. Lengths in m, angles in rad, measurement frame.

mod autocorrelation;
mod bootstrap;
mod competition;
mod conclusion;
mod cross_validation;
mod diagnose;
mod hypothesis;
mod inputs;
mod linear_fit;
mod linear_problem;
mod location;
mod next_poses;
mod nuisance;
mod outliers;
mod probe;
mod projection;
mod refinement;
mod refit;
mod regions;
mod repeatability;
mod result;
mod rivals;
mod selection;
mod settings;
mod verdict;

pub use autocorrelation::autocorrelation;
pub use diagnose::diagnose;
pub use nuisance::nuisance;
pub use result::{
    Autocorrelation, Cause, CauseParameter, Diagnosis, EffectAtSite, ExcessCompliance, Gap, Location, LookAlikes,
    NextPose, NoiseSource, Region, Rejected, Shrinkage, SiteShare, Verdict,
};
pub use settings::{
    AutocorrelationSettings, LocationSettings, OutlierSettings, ProposalSettings, RivalSettings, SelectionSettings,
    Settings, VerdictSettings,
};
