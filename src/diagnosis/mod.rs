//! Diagnosis of the sim-to-real gap: where it lies, which effects cause it, how far it shrinks.
//!
//! What calibration can remove is projected off first. All effects at all their sites then compete with linear columns
//! for the residuals, without a new calibration for each. Figures are of readings that were not fitted. What nothing
//! explains is reported as unexplained. Lengths in m, angles in rad, measurement frame.

mod autocorrelation;
mod bootstrap;
mod choice;
mod claims;
mod compared;
mod competition;
mod conclusion;
mod constancy;
mod cross_validation;
mod diagnose;
mod explanation;
mod few_angles;
mod flips;
mod forward;
mod free_errors;
mod gates;
mod heavy_tail;
mod held_out;
mod hypothesis;
mod implied;
mod inputs;
mod joint_compliance;
mod kept_amount;
mod lasting;
mod level;
mod linear_fit;
mod linear_problem;
mod locality;
mod location;
mod misfit;
mod next_poses;
mod other_shapes;
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
mod shared_site;
mod stability;
mod unnamed;
mod untried;
mod verdict;
mod windows;

pub use autocorrelation::autocorrelation;
pub use diagnose::diagnose;
pub use level::{Level, Stability, Support};
pub use result::{
    Autocorrelation, Cause, CauseParameter, Curve, Diagnosis, EffectAtSite, ExcessCompliance, Excluded, FewAngles, Gap,
    Location, LookAlikes, NextPose, NoiseSource, NotTried, Region, Rejected, Rest, Shrinkage, SiteShare, Verdict,
};
pub use settings::{
    AutocorrelationSettings, ClaimSettings, LocationSettings, OutlierSettings, ProposalSettings, RivalSettings,
    SelectionSettings, Settings, VerdictSettings,
};
