//! Diagnosis of the sim-to-real gap: where it lies, which effect causes it, how far it shrinks.
//!
//! What could be calibrated away is projected out first. All effects at all their sites then compete with linear columns
//! on what is left; each figure reported is of readings that the fit did not see. What nothing explains is said so.

mod algebra;
mod evidence;
mod figures;
mod fit;
mod location;
mod look_alikes;
mod next;
mod nuisance;
mod repeats;
mod report;
mod round;
mod search;
mod structure;
mod verdict;

pub use evidence::{Evidence, Hypothesis};
pub use location::{Condition, Location, SiteShare, Yielding};
pub use look_alikes::LookAlikes;
pub use nuisance::nuisance;
pub use report::{Cause, CauseParameter, Diagnosis, Gap, NextPose, Rejected, Shrinkage, Verdict};
pub use structure::{Structure, structure_in};
pub use verdict::{Settings, diagnose};
