//! Which measurements to make: configurations (and loads) that leave the smallest position error after compensation at
//! the user's own test poses.
//!
//! Readings are linear in small errors of the parameters, so that a set of them has an information matrix M (a sum over
//! the readings), the fit a covariance 1/M, and a test pose with derivatives J a mean square error of tr(J M^-1 J').
//! Candidates drawn in the joint box are chosen greedily and exchanged for better ones (Fedorov 1972) as long as that
//! helps; then the joints themselves are moved. The criterion is that of Klimchik and co-authors ("industry-oriented
//! performance measure", used in the KR-270 paper); D-, A-, E-optimality and the observability indices O1 to O5 of Sun
//! and Hollerbach (2008) stand beside it.

mod criterion;
mod exchange;
mod information;
mod place;
mod refine;
mod search;

pub use criterion::Optimality;
pub use place::{Sight, Station};
pub use search::{Bought, Planned, PlanningError, SETS, plan};

use crate::description::campaign::Campaign;
use crate::estimation::What;
use crate::identifiability::{Criterion, Scaling};
use crate::observation::Observes;
use crate::parameter::Slot;
use crate::simulation::Loaded;

/// What is to be planned.
#[derive(Debug, Clone)]
pub struct Request {
    /// Configurations to add.
    pub count: usize,
    /// Which parameters are estimated beside base and tool.
    pub what: What,
    /// What a reading is.
    pub observes: Observes,
    /// Points measured at each configuration; `None` is the tool centre point.
    pub markers: Vec<Option<usize>>,
    /// Loads that can be applied, N and N.m, base axes; each configuration gets the one that serves best. None where
    /// empty.
    pub loads: Vec<[f64; 6]>,
    /// Readings of each point.
    pub repeats: usize,
    /// One sigma of a coordinate, m.
    pub sigma: f64,
    /// One sigma of a component of the orientation, rad.
    pub sigma_orientation: f64,
    /// Whether base, and tool and markers, are unknown.
    pub estimate: [bool; 2],
    /// What is to be best.
    pub criterion: Optimality,
    /// From where points must be seen.
    pub sight: Option<Sight>,
    /// Box of the variables, rad and m.
    pub within: Vec<[f64; 2]>,
    /// Where the measured points may be: least and greatest x, y, z in the robot's base frame, m.
    pub workspace: Option<[[f64; 2]; 3]>,
    /// Least distance between the tool centre points of two configurations, m.
    pub apart: f64,
    /// Configurations and loads at which the error counts; drawn in `tested_within` where empty.
    pub tests: Vec<Loaded>,
    /// Box of the variables in which test poses are drawn, rad and m.
    pub tested_within: Vec<[f64; 2]>,
    /// Readings that are made already.
    pub measured: Option<Campaign>,
    /// Parameters to hold at their nominal values.
    pub hold: Vec<Slot>,
    /// Column scaling of the reduction.
    pub scaling: Scaling,
    /// When a parameter that is not exactly dependent is dropped.
    pub tolerance: Criterion,
    /// Seed of all that is drawn.
    pub seed: u64,
}
