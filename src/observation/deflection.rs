//! `deflection`: displacement (m, axes of the measurement frame) of a point by the applied wrench: loaded position minus
//! unloaded position at the same commanded joints. `deflection-pose`: and the rotation vector (rad, the same axes) by which
//! the wrench turns the body that carries the point.
//!
//! Source of the six components: Marie, Courteille, Maurine, *Elasto-geometrical modeling and calibration of robot
//! manipulators*, eq. 64, where a laser tracker reads several reflectors of one tool.

use nalgebra::{Rotation3, Vector3};

use super::kind::{MeasuredPoint, Observation, PointDerivative, Purpose, Rows, ValueColumn, XYZ, rows_of};
use super::pose::{COLUMNS as POSE_COLUMNS, rotation, rows};
use crate::math::rotation_vector;

pub(super) struct Deflection;
pub(super) struct DeflectionPose;

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

    fn with_more_columns(&self) -> Option<&'static dyn Observation> {
        Some(&DeflectionPose)
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

    /// Deflections of one point share the unloaded reading.
    fn is_comparable(&self, same_point: bool, _same_anchor: bool) -> bool {
        !same_point
    }
}

impl Observation for DeflectionPose {
    fn name(&self) -> &'static str {
        "deflection-pose"
    }

    fn about(&self) -> &'static str {
        "Loaded pose minus unloaded pose: displacement and rotation."
    }

    fn columns(&self) -> &'static [ValueColumn] {
        &POSE_COLUMNS
    }

    fn is_difference(&self) -> bool {
        true
    }

    fn purpose(&self) -> Purpose {
        Purpose::Stiffness
    }

    fn value(&self, point: &MeasuredPoint) -> Rows {
        rows(&point.displacement, &point.turned)
    }

    fn residual(&self, measured: &Rows, point: &MeasuredPoint) -> Rows {
        let moved = Vector3::from_column_slice(&measured[..3]) - point.displacement;
        rows(&moved, &rotation_vector(&(rotation(measured) * Rotation3::new(point.turned).inverse())))
    }

    fn derivative(&self, _point: &MeasuredPoint, by: &PointDerivative) -> Rows {
        rows(&by.deflection.displacement, &by.deflection.rotation)
    }

    /// Deflections of one point share the unloaded reading.
    fn is_comparable(&self, same_point: bool, _same_anchor: bool) -> bool {
        !same_point
    }
}
