//! Deflection under load and own weight, by the force method.
//!
//! The structure of a model ([`crate::model::Structure`]) is a tree of elements ([`crate::elements`]) that hangs from the
//! ground, and elements that close its loops. A load runs down the tree by equilibrium alone; the only unknowns are the
//! forces of the closures and the motions of the released directions, so that a serial robot needs no solution at all and a
//! four-bar linkage one of eight unknowns. Rigid is a compliance of zero and passive a released direction: no penalty
//! numbers enter, and nothing is ill-conditioned by them. The result is the same as that of the assembled and condensed
//! stiffness matrix (eq. 24-27 of the IR663 calibration paper).
//!
//! Wrenches are (force, moment), twists (displacement, rotation vector), SI, base axes. *Spatial* ones are reduced to
//! the origin of the base.
//!
//! Derivatives by elastic parameters are adjoint: with internal forces f of unit loads at the output and f_w of the
//! load, a compliance contributes f' dc f_w, a stiffness -d' dk d_w, in one product each.

mod compiled;
mod derivatives;
mod elimination;
mod equilibrium;
mod fuzzy;
mod in_plane;
mod load_case;
mod motion;
mod prepare;
mod report;
mod response;
mod stability;
mod statics;
mod unknowns;
mod weight;

pub use crate::elements::spatial;
pub use compiled::Elastics;
pub use derivatives::ElasticColumns;
pub use equilibrium::{Equilibrium, PointLoad, deflection_at_rest, equilibrium};
pub use fuzzy::{fuzzy_doubts, put_fuzzy};
pub use load_case::{Load, LoadCase};
pub use motion::MotionWorkspace;
pub use report::{Shares, shares, twists};
pub use response::{Response, at_point};
pub use statics::{Mechanism, Statics};
