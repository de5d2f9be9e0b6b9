//! Deflection under load and own weight, by the force method.
//!
//! The structure of a model ([`crate::model::Structure`]) is a tree of elements that hangs from the ground, and elements
//! that close its loops. A load runs down the tree by equilibrium alone; the only unknowns are the forces of the
//! closures and the motions of the released directions, so that a serial robot needs no solution at all and a four-bar
//! linkage one of eight unknowns. Rigid is a compliance of zero and passive a released direction: no penalty numbers
//! enter, and nothing is ill-conditioned by them. The result is the same as that of the assembled and condensed
//! stiffness matrix (eq. 24-27 of the IR663 calibration paper).
//!
//! Wrenches are (force, moment), twists (displacement, rotation vector), SI, base axes. *Spatial* ones are reduced to
//! the origin of the base.
//!
//! Derivatives by elastic parameters are adjoint: with internal forces f of unit loads at the output and f_w of the
//! load, a compliance contributes f' dc f_w, a stiffness -d' dk d_w, in one product each.

pub mod elements;

mod derivatives;
mod elimination;
mod equilibrium;
mod motion;
mod report;
mod response;
mod section;
mod slots;
mod stability;
mod statics;
mod unknowns;
mod weight;

pub use derivatives::ElasticColumns;
pub use equilibrium::{Equilibrium, equilibrium};
pub use motion::{Motion, MotionWork, by_motion};
pub use report::{Shares, shares, twists};
pub use response::Response;
pub use section::{Properties, properties};
pub use statics::{Elastics, Mechanism, Statics};

use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};

/// Spatial wrench of a force and moment acting at a point (m, base axes).
pub fn spatial(point: &Vector3<f64>, force: &Vector3<f64>, moment: &Vector3<f64>) -> Vector6<f64> {
    let moment = moment + point.cross(force);
    Vector6::new(force.x, force.y, force.z, moment.x, moment.y, moment.z)
}

/// Displacement and rotation, at a point, of the body that moves by a spatial twist.
pub fn at_point(twist: &Vector6<f64>, point: &Vector3<f64>) -> (Vector3<f64>, Vector3<f64>) {
    let (v, w) = (Vector3::new(twist[0], twist[1], twist[2]), Vector3::new(twist[3], twist[4], twist[5]));
    (v + w.cross(point), w)
}

/// Matrix that takes spatial wrenches to the local axes `rotation` at `origin`; its transpose takes local deformations
/// to spatial twists.
pub(crate) fn reduction(rotation: &Matrix3<f64>, origin: &Vector3<f64>) -> Matrix6<f64> {
    let turned = rotation.transpose();
    let arm = turned * origin.cross_matrix();
    let mut matrix = Matrix6::zeros();
    matrix.fixed_view_mut::<3, 3>(0, 0).copy_from(&turned);
    matrix.fixed_view_mut::<3, 3>(3, 0).copy_from(&-arm);
    matrix.fixed_view_mut::<3, 3>(3, 3).copy_from(&turned);
    matrix
}
