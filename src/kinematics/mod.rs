//! Placements of all frames, closure of loops, and first derivatives of both.
//!
//! [`Geometry`] is a model with values put in; it places frames for a configuration. All derivatives are analytic:
//! elementary transforms give twists, loops give implicit derivatives.

mod assembly_error;
mod closure;
mod constants;
mod geometry;
mod inverse;
mod jacobian;
mod linear;
mod linearisation;
mod planar;
mod rates;
mod slider_crank;
mod spatial;
mod transform;

pub use assembly_error::AssemblyError;
pub use geometry::{Geometry, Placements};
pub use inverse::{InverseError, InverseSettings, Solution, Target, beyond_limits, solve};
pub use jacobian::{By, ErrorColumns, shift};
pub use rates::Rates;
pub use slider_crank::slider_crank;
pub use transform::{Transform, rotation_vector};
