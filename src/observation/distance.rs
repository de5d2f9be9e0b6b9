//! `distance`: length (m) from a fixed anchor of the measurement frame to a marker or the tool centre point, as a draw wire
//! or a ball bar gives it.

use nalgebra::Vector3;

use super::kind::{MeasuredPoint, Noise, Observation, PointDerivative, Rows, ValueColumn};

pub(super) struct Distance;

const COLUMNS: [ValueColumn; 1] = [ValueColumn::length("distance")];

/// Length from the anchor to the point, and its direction.
fn from_anchor(point: &MeasuredPoint) -> (f64, Vector3<f64>) {
    let arm = point.position() - point.anchor;
    let length = arm.norm();
    (length, arm / length.max(f64::MIN_POSITIVE))
}

fn row(value: f64) -> Rows {
    [value, 0.0, 0.0, 0.0, 0.0, 0.0]
}

impl Observation for Distance {
    fn name(&self) -> &'static str {
        "distance"
    }

    fn about(&self) -> &'static str {
        "Length from a fixed anchor to a marker or the tool centre point."
    }

    fn columns(&self) -> &'static [ValueColumn] {
        &COLUMNS
    }

    fn anchor_column(&self) -> Option<&'static str> {
        Some("anchor")
    }

    fn residuals_named(&self) -> &'static str {
        "distances"
    }

    fn fault(&self, measured: &Rows) -> Option<(&'static str, &'static str)> {
        (measured[0] <= 0.0).then_some(("distance", "a distance must be above 0"))
    }

    fn value(&self, point: &MeasuredPoint) -> Rows {
        row(from_anchor(point).0)
    }

    fn derivative(&self, point: &MeasuredPoint, by: &PointDerivative) -> Rows {
        row(from_anchor(point).1.dot(&by.total().displacement))
    }

    fn sigmas(&self, noise: &Noise) -> Rows {
        row(noise.position[0])
    }

    /// The direction of a distance is that to its anchor.
    fn is_comparable(&self, _same_point: bool, same_anchor: bool) -> bool {
        same_anchor
    }
}
