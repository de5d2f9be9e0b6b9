//! Mathematics, independent of robots: rotations, factorisations, quantiles and summaries of samples.

mod angles;
pub(crate) mod linear;
mod orthonormal;
pub mod quantiles;
mod rigid;
mod se3;
mod spline;
mod summary;

pub use angles::wrapped;
pub use orthonormal::{independent, joined, least_squares, orthonormal, project_off};
pub(crate) use rigid::{nearest_rotation, rigid_fit};
pub use se3::{left_jacobian, rotation_vector};
pub use spline::NaturalSpline;
pub(crate) use summary::{distinct, extremes};
pub use summary::{mean_rms_max, median, norm};
