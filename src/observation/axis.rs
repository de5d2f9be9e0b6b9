//! `axis`: direction of the tool's z axis in the measurement frame, as a camera sees a rod or a two-angle target shows its own.
//!
//! The two residuals (rad) are the components of the predicted direction across the measured one. The turn of the tool about
//! its axis does not show.

use nalgebra::Vector3;

use super::direction::{LEAST, across, disturbed, read, two};
use super::kind::{MeasuredPoint, Noise, Observation, PointDerivative, Rows, ValueColumn, rows_of};

pub(super) struct Axis;

const COLUMNS: [ValueColumn; 3] =
    [ValueColumn::number("axis.x"), ValueColumn::number("axis.y"), ValueColumn::number("axis.z")];
const ANGLES: [ValueColumn; 2] = [ValueColumn::angle("azimuth"), ValueColumn::angle("elevation")];

fn predicted(point: &MeasuredPoint) -> Vector3<f64> {
    point.orientation * Vector3::z()
}

impl Observation for Axis {
    fn name(&self) -> &'static str {
        "axis"
    }

    fn about(&self) -> &'static str {
        "Direction of the tool's z axis: two angles."
    }

    fn columns(&self) -> &'static [ValueColumn] {
        &COLUMNS
    }

    fn other_columns(&self) -> &'static [ValueColumn] {
        &ANGLES
    }

    /// The azimuth counts from x towards y, the elevation from the x-y plane towards z.
    fn of_other_columns(&self, read: &[f64]) -> Rows {
        let [azimuth, elevation] = [0, 1].map(|k| read.get(k).copied().unwrap_or(0.0));
        let level = elevation.cos();
        rows_of(&Vector3::new(level * azimuth.cos(), level * azimuth.sin(), elevation.sin()))
    }

    fn rows(&self) -> usize {
        2
    }

    fn sees_orientation(&self) -> bool {
        true
    }

    fn residuals_named(&self) -> &'static str {
        "directions"
    }

    fn fault(&self, measured: &Rows) -> Option<(&'static str, &'static str)> {
        (read(measured).norm() < LEAST)
            .then_some(("axis.x", "axis.x, axis.y, axis.z are all zero, and give no direction"))
    }

    fn value(&self, point: &MeasuredPoint) -> Rows {
        rows_of(&predicted(point))
    }

    fn residual(&self, measured: &Rows, point: &MeasuredPoint) -> Rows {
        let predicted = predicted(point);
        two(across(measured, &predicted).map(|axis| -axis.dot(&predicted)))
    }

    fn derivative(&self, point: &MeasuredPoint, by: &PointDerivative) -> Rows {
        let predicted = predicted(point);
        let change = by.total().rotation.cross(&predicted);
        two(across(&point.measured, &predicted).map(|axis| axis.dot(&change)))
    }

    fn sigmas(&self, noise: &Noise) -> Rows {
        two([noise.orientation; 2])
    }

    fn disturb(&self, measured: &mut Rows, noise: &Noise, normal: &mut dyn FnMut() -> f64) {
        *measured = rows_of(&disturbed(measured, noise.orientation, normal));
    }
}
