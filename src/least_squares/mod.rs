//! Bounded, weighted, optionally robust nonlinear least squares.
//!
//! [`minimize`] seeks
//!
//! ```text
//!   min  F(x) = 1/2 sum_i rho(r_i(x)^2)     subject to  lower <= x <= upper
//! ```
//!
//! with `x` of length n, `r` of length m (already weighted: a residual of 1 is one standard deviation) and `rho` a
//! [`Loss`], the identity by default. It does not depend on what the parameters are.
//!
//! # Method
//! A Gauss-Newton trust-region method. At every iterate the residual is linearised, `r(x + p) ~ r + J p`, and the step
//! minimises `|W (r + J p)|` over a box: the bounds intersected with `|D p|_inf <= radius`, where `W` are the square
//! roots of the robust weights and `D` holds the largest norm each column of `W J` has had so far (Moré 1978), which
//! makes the iteration blind to the units of the parameters. Because a trust region in the maximum norm is itself a
//! box, both kinds of limit are one set of simple bounds and the step is a box-constrained quadratic programme.
//!
//! Two things are added to that. A step that the radius cuts short is damped as Levenberg and Marquardt did, just enough
//! to be no longer than the radius in the Euclidean norm as well; without, parameters of little influence would run to the
//! corners of the box. And a step that disappoints is computed once more with the curvature it revealed, which follows
//! bent valleys at the price of one evaluation of the residual.
//!
//! | file | role |
//! |---|---|
//! | `problem` | what the caller implements |
//! | `bounds`, `loss`, `settings` | what the caller chooses |
//! | `solve` | the iteration |
//! | `trust_region` | the scaling, the radius, the box |
//! | `linear` | the linearised problem at one iterate, reduced by QR, and its step |
//! | `box_step` | linear least squares over a box: interior point, then active set |
//! | `damped` | the step of Levenberg and Marquardt |
//! | `solution` | the answer, and the ways a question can be malformed |
//!
//! # Limits
//! The model has first derivatives only. At a minimum with large residuals in strongly curved directions it converges
//! linearly, and to about the square root of the rounding error.
//!
//! # Sources
//! - J. J. Moré, "The Levenberg-Marquardt algorithm: implementation and theory", in *Numerical Analysis*, Lecture Notes
//!   in Mathematics 630, Springer 1978: scaling, convergence tests, reduction of the radius.
//! - J. Nocedal, S. J. Wright, *Numerical Optimization*, 2nd ed., Springer 2006: chapters 4 and 10 (trust regions, least
//!   squares), 16.7 (bound-constrained quadratic programmes).
//! - M. K. Transtrum, J. P. Sethna, "Improvements to the Levenberg-Marquardt algorithm for nonlinear least-squares
//!   minimization", arXiv:1201.5885 (2012): second-order correction of the step.
//! - P. B. Stark, R. L. Parker, "Bounded-variable least-squares: an algorithm and applications", *Computational
//!   Statistics* 10 (1995): the active-set method that makes the interior-point answer exact.
//! - P. J. Huber, E. M. Ronchetti, *Robust Statistics*, 2nd ed., Wiley 2009, chapter 7: iteratively reweighted least
//!   squares.
//! - P. J. Goulart, Y. Chen, "Clarabel: an interior-point solver for conic programs with quadratic objectives", 2024.

mod bounds;
mod box_step;
mod damped;
mod linear;
mod loss;
mod problem;
mod settings;
mod solution;
mod solve;
mod trust_region;

pub use bounds::{Bounds, BoundsError, Side};
pub use box_step::minimize_in_box;
pub use loss::Loss;
pub use problem::{EvaluationError, Problem};
pub use settings::{Progress, Settings};
pub use solution::{Solution, Status, UsageError};
pub use solve::{minimize, minimize_observed};
