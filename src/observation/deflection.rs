//! `deflection`: displacement (m, axes of the measurement frame) of a point by the applied wrench: loaded position minus
//! unloaded position at the same commanded joints.

use super::kind::{MeasuredPoint, Noise, Observation, PointDerivative, Purpose, Rows, ValueColumn, XYZ, rows_of};

pub(super) struct Deflection;

impl Observation for Deflection {
    fn name(&self) -> &'static str {
        "deflection"
    }

    fn about(&self) -> &'static str {
        "Loaded position minus unloaded position."
    }

    fn columns(&self) -> &'static [ValueColumn] {
        &XYZ
    }

    fn is_difference(&self) -> bool {
        true
    }

    fn purpose(&self) -> Purpose {
        Purpose::Stiffness
    }

    fn value(&self, point: &MeasuredPoint) -> Rows {
        rows_of(&point.displacement)
    }

    fn derivative(&self, _point: &MeasuredPoint, by: &PointDerivative) -> Rows {
        rows_of(&by.deflection.displacement)
    }

    fn sigmas(&self, noise: &Noise) -> Rows {
        rows_of(&noise.position.into())
    }

    /// Deflections of one point share the unloaded reading.
    fn is_comparable(&self, same_point: bool, _same_anchor: bool) -> bool {
        !same_point
    }
}
