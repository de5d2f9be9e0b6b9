//! Placements of all frames, closure of loops, and first derivatives of both.
//!
//! [`Geometry`] is a model with values put in; it places frames for a configuration. All derivatives are analytic:
//! elementary transforms give twists, loops give implicit derivatives.

mod assembly;
mod assembly_error;
mod branch;
mod closure;
mod constants;
mod denavit_hartenberg;
mod geometry;
mod inverse;
mod jacobian;
mod keep_out;
mod limits;
mod linear;
mod linearisation;
mod planar;
mod rates;
mod slider_crank;
mod spatial;
mod transform;

pub use assembly_error::{AssemblyError, At, Gap};
pub use denavit_hartenberg::{DenavitHartenberg, Link as DhLink, NoSeries, denavit_hartenberg};
pub use geometry::{Geometry, Placements};
pub(crate) use inverse::LeastSteps;
pub use inverse::{Hold, InverseError, InverseSettings, Solution, Target, solve};
pub use jacobian::{By, ErrorColumns, shift};
pub use keep_out::{End, Entered, Link, always_entered, entered, passes_through};
pub use limits::{Limited, beyond_limits, limited};
pub use rates::Rates;
pub use slider_crank::slider_crank;
pub use transform::{Transform, rotation_vector};
