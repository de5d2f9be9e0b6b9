//! Which measurements to make: configurations (and loads) that leave the smallest position error after compensation at
//! the user's own test poses.
//!
//! Readings are linear in small errors of the parameters, so that a set of them has an information matrix M (a sum over
//! the readings), the fit a covariance 1/M, and a test pose with derivatives J a mean square error of tr(J M^-1 J').
//! Candidates drawn in the joint box are chosen greedily and exchanged for better ones (Fedorov 1972) as long as that
//! helps; then the joints themselves are moved. The criterion is that of Klimchik and co-authors ("industry-oriented
//! performance measure", used in the KR-270 paper); D-, A-, E-optimality and the observability indices O1 to O5 of Sun
//! and Hollerbach (2008) can be chosen instead.

mod criterion;
mod error;
mod exchange;
mod information;
mod place;
mod refine;
mod request;
mod result;
mod search;
mod settings;
pub mod stiffest;

pub use criterion::Optimality;
pub use error::PlanningError;
pub use place::Station;
pub use request::{Design, Request, Sight};
pub use result::{Bought, Planned};
pub use search::plan;
pub use settings::Settings;
