//! Elasto-geometric models of declared robots, their identification, and the diagnosis of the sim-to-real gap.
//!
//! One way in, one way through: a [`description`] (YAML, URDF, CSV) is resolved and compiled into an immutable
//! [`model`]; [`kinematics`] places its frames and differentiates them; [`elastics`] says how it gives under load;
//! [`prediction`] says what each reading should be; [`identifiability`] says what the readings can tell; [`estimation`] fits it;
//! [`compensation`] inverts it; [`render`] words the result.
//! Inside, every quantity is SI (m, rad, N, kg, s).

pub mod blind;
pub mod cli;
pub mod compensation;
pub mod description;
pub mod diagnosis;
pub mod diagnostic;
pub mod effects;
pub mod elastics;
pub mod elements;
pub mod estimation;
pub mod files;
pub mod fuzzy;
pub mod identifiability;
pub mod kinematics;
pub mod math;
pub mod model;
pub mod observation;
pub mod parameter;
pub mod planning;
pub mod prediction;
pub mod process;
pub mod render;
pub mod review;
pub mod scene;
pub mod simulation;
pub mod snapshot;
