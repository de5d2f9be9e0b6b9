//! `torque`: what a motor supplies to hold a joint (N.m; N of a sliding one), from a torque sensor or a motor current. Values of
//! its target: the gain, the offset (N.m or N).
//!
//! The holding load is own weight, payload, wrench and springs between bodies by virtual work, nothing deflected. It counts as known in
//! a fit, which is repeated with the loads of the lengths that it finds (`estimation::calibrate`): a millimetre of a link's length is a tenth of
//! a N.m under 10 kg.

use super::kind::{MeasuredPoint, Noise, Observation, PointDerivative, Rows, row};

pub(super) struct Torque;

impl Observation for Torque {
    fn name(&self) -> &'static str {
        "torque"
    }

    fn about(&self) -> &'static str {
        "Torque or current with which a motor holds its joint."
    }

    fn by_variable(&self) -> Option<&'static str> {
        Some("torque")
    }

    fn rows(&self) -> usize {
        1
    }

    fn ignores_arrangement(&self) -> bool {
        true
    }

    fn residuals_named(&self) -> &'static str {
        "torques"
    }

    fn depends_on(&self) -> &'static str {
        "masses and their centres (`bodies`), gravity, units and gains of the torques"
    }

    fn value(&self, point: &MeasuredPoint) -> Rows {
        row(point.target[0] * point.load + point.target[1])
    }

    fn derivative(&self, _point: &MeasuredPoint, _by: &PointDerivative) -> Rows {
        row(0.0)
    }

    fn by_target(&self, point: &MeasuredPoint, k: usize) -> Rows {
        row(if k == 0 { point.load } else { 1.0 })
    }

    fn sigmas(&self, noise: &Noise) -> Rows {
        row(noise.load)
    }
}
