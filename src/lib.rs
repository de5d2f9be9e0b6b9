//! Elasto-geometric models of declared robots, their identification, and the diagnosis of the sim-to-real gap.
//!
//! ```
//! use elastogeo::estimation::{Settings, calibrate, split};
//! use elastogeo::files::load_campaign;
//!
//! fn main() -> Result<(), elastogeo::Error> {
//!     // A bundled campaign; a path of a campaign.yaml and its CSV does as well.
//!     let loaded = load_campaign("kr270-simulated", None)?;
//!     let (model, campaign) = (&loaded.robot.model, &loaded.campaign);
//!     // Held out to judge the calibration: what the campaign marks as `check`, or else a quarter of the configurations.
//!     let held_out = split(campaign, 0.25, 1);
//!     let found = calibrate(model, campaign, &held_out, &Settings::default(), &mut |_| ())?;
//!     for estimate in &found.estimates {
//!         let Some(ci95) = estimate.ci95 else { continue }; // dropped: not identifiable
//!         let name = &model.registry[estimate.slot].name;
//!         println!("{name:12} {:+.6} ± {ci95:.6}", estimate.value - estimate.nominal); // m or rad
//!     }
//!     let rms = |figures: &elastogeo::estimation::Figures| 1e3 * figures.check.distance[1];
//!     let (registered, calibrated) = (rms(&found.registration), rms(&found.after)); // with base and tool fitted alone, and all
//!     println!("held-out readings: {registered:.3} mm rms registered, {calibrated:.3} mm calibrated");
//!     assert!(calibrated < 0.5 * registered);
//!     Ok(())
//! }
//! ```
//!
//! One way through: a [`description`] (YAML, URDF, CSV) is resolved and compiled into an immutable [`model`]; [`kinematics`]
//! places its frames and differentiates them; [`elastics`] computes its deflection under load; [`prediction`] computes what
//! each reading should be; [`identifiability`] decides which parameters the readings determine; [`estimation`] fits them;
//! [`diagnosis`] names what the model lacks; [`compensation`] inverts the model.
//! Inside, every quantity is SI (m, rad, N, kg, s).
//!
//! The feature `cli` (default) adds the command `elastogeo`: arguments, terminal, text, charts and HTML; `xlsx` (default) reads
//! tables from workbooks and writes them. Without both the library builds on 130 crates instead of 184.

pub mod blind;
#[cfg(feature = "cli")]
pub mod cli;
pub mod compensation;
pub mod description;
pub mod diagnosis;
pub mod diagnostic;
pub mod effects;
pub mod elastics;
pub mod elements;
mod error;
pub mod estimation;
pub mod files;
pub mod fuzzy;
pub mod identifiability;
pub mod kinematics;
pub mod least_squares;
pub mod math;
pub mod model;
pub mod noise;
pub mod observation;
pub mod parameter;
pub mod planning;
pub mod plausibility;
pub mod prediction;
pub mod process;
#[cfg(feature = "cli")]
pub mod render;
pub mod results;
pub mod review;
pub mod scene;
mod settings;
pub mod simulation;
pub mod snapshot;
pub mod state;
pub mod tracking;

pub use error::Error;
