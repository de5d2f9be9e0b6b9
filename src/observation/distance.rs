//! `distance`: length (m) from a fixed anchor of the measurement frame to a marker or the tool centre point, as a draw wire
//! or a ball bar gives it, and a zero that is added to it. Values of its target: the anchor, the zero (m).

use nalgebra::{DMatrix, DVector, Vector3};

use super::kind::{
    ANCHOR_COLUMN, MOST_TARGET_VALUES, MeasuredPoint, Observation, PointDerivative, Rows, TargetValues, ValueColumn,
    ValueFault, centre_of, row,
};
use crate::math::least_squares;

pub(super) struct Distance;

const COLUMNS: [ValueColumn; 1] = [ValueColumn::length("distance")];

/// Position of the zero among the values of the target.
const ZERO: usize = 3;

/// Length from the anchor to the point, and its direction.
fn from_anchor(point: &MeasuredPoint) -> (f64, Vector3<f64>) {
    let arm = point.position() - point.anchor();
    let length = arm.norm();
    (length, arm / length.max(f64::MIN_POSITIVE))
}

/// Anchor and zero by linear least squares.
fn anchor_and_zero(read: &[MeasuredPoint]) -> Option<TargetValues> {
    let columns = DMatrix::from_fn(read.len(), 5, |row, k| match k {
        0..3 => 2.0 * read[row].position()[k],
        3 => -2.0 * read[row].measured[0],
        _ => 1.0,
    });
    let squares = read.iter().map(|point| point.position().norm_squared() - point.measured[0].powi(2));
    let x = least_squares(&columns, &DVector::from_iterator(read.len(), squares));
    let mut start = [0.0; MOST_TARGET_VALUES];
    start.iter_mut().zip(x.iter().take(4)).for_each(|(to, from)| *to = *from);
    x.iter().all(|value| value.is_finite()).then_some(start)
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

    fn target_column(&self) -> Option<&'static str> {
        Some(ANCHOR_COLUMN)
    }

    fn residuals_named(&self) -> &'static str {
        "distances"
    }

    fn depends_on(&self) -> &'static str {
        "where the anchors are, and zeros of the lengths"
    }

    fn fault(&self, measured: &Rows, is_free: &[bool]) -> Option<ValueFault> {
        let has_zero = is_free.get(ZERO).copied().unwrap_or(false);
        (measured[0] <= 0.0 && !has_zero).then_some(ValueFault {
            column: "distance",
            message: "a distance must be above 0",
            remedy: "correct the row; or write `zero: unknown` at its anchor, if the sensor counts from somewhere else",
        })
    }

    fn value(&self, point: &MeasuredPoint) -> Rows {
        row(from_anchor(point).0 + point.target[ZERO])
    }

    fn derivative(&self, point: &MeasuredPoint, by: &PointDerivative) -> Rows {
        row(from_anchor(point).1.dot(&by.total().displacement))
    }

    /// |p|^2 - d^2 = 2 a.p - |a|^2 is linear in the anchor a, where there is no zero z; with d - z for d, so is
    /// |p|^2 - d^2 = 2 a.p - 2 z d + z^2 - |a|^2 in both. Lengths below zero certainly have one.
    fn target_start(&self, read: &[MeasuredPoint]) -> Option<TargetValues> {
        if read.iter().any(|point| point.measured[0] <= 0.0) {
            return anchor_and_zero(read);
        }
        let square = |point: &MeasuredPoint| point.position().norm_squared() - point.measured[0].powi(2);
        let (anchor, _) = centre_of(read.iter().map(|point| (point.position(), square(point))))?;
        let mut start = [0.0; MOST_TARGET_VALUES];
        start[..3].copy_from_slice(anchor.as_slice());
        Some(start)
    }

    fn by_target(&self, point: &MeasuredPoint, k: usize) -> Rows {
        let (_, direction) = from_anchor(point);
        row(if k == ZERO { 1.0 } else { -direction[k.min(2)] })
    }

    /// The direction of a distance is that to its anchor.
    fn is_comparable(&self, _same_point: bool, same_target: bool) -> bool {
        same_target
    }
}
