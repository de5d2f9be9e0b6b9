//! Whether a result may be believed: a list of checks, each with its limit and the reason for it.
//!
//! A check looks at the evidence (model, campaign, calibration) and says what it finds as diagnostics with a code. An error
//! of the numerics ([`Code::NotConverged`]) means that there is no result. An error of plausibility
//! ([`Code::is_plausibility`]) means that there is one which no robot can have; [`forced`] makes it a warning. To add a
//! check: write a function of [`Evidence`] and [`Limits`], and put it into [`CHECKS`].

mod again;
mod amount;
mod another_robot;
mod approach;
mod beyond;
mod changes;
mod checks;
mod common_factor;
mod compensator;
mod constraints;
mod deflections;
mod diagnosis;
mod evidence;
mod fitted;
mod hypothesis;
mod instrument;
mod lengths_under_load;
mod meant;
mod midway;
mod nearer;
mod numerics;
mod other_joints;
mod outlying;
mod overlap;
mod own_weight;
mod parameters;
mod payload;
mod placement;
mod places_and_deflections;
mod points;
mod readings;
mod reordered;
mod sensors;
mod sessions;
mod shown;
mod springs;
mod stated_noise;
mod step;
mod torques;
mod trial;
mod turned;
mod unfitted_springs;
mod words;

pub use checks::{CHECKS, Check, forced, judge, judge_result, misread, refusing, reported_once, why_not_computed};
pub use compensator::{of_compliances, of_elasticity, of_mounting};
pub use diagnosis::doubts;
pub use evidence::{Evidence, Limits};
pub use outlying::{far_readings, far_when_registered};
pub use springs::as_stiff_as_arms;
pub use stated_noise::is_above_noise;
