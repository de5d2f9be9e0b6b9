//! Placements of all frames, closure of loops, and first derivatives of both.
//!
//! [`Geometry`] is a model with values put in; it places frames for a configuration. All derivatives are analytic:
//! elementary transforms give twists, loops give implicit derivatives.

mod closure;
mod geometry;
mod inverse;
mod jacobian;
mod linear;
mod planar;
mod rates;
mod slider_crank;
mod spatial;

pub use geometry::{AssemblyError, Geometry, Placements};
pub use inverse::{InverseError, InverseSettings, Solution, Target, beyond_limits, solve};
pub use jacobian::{By, ErrorColumns, shift};
pub use rates::Rates;
pub use slider_crank::slider_crank;

/// A rigid transform: rotation matrix and translation (m).
pub type Transform = nalgebra::IsometryMatrix3<f64>;

pub use crate::math::rotation_vector;
