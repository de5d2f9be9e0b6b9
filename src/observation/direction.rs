//! Directions as readings: two residuals (rad), the components of the predicted direction across the measured one.

use nalgebra::{Matrix3, Vector3};

use super::kind::{MeasuredPoint, Noise, Observation, PointDerivative, Rows, TargetValues, ValueColumn, rows_of};

/// Below this length a direction is none.
pub(super) const LEAST: f64 = 1e-9;

/// A kind of reading that is a direction.
pub(super) struct Direction {
    pub name: &'static str,
    pub about: &'static str,
    /// Columns of a vector of any length.
    pub columns: &'static [ValueColumn; 3],
    /// Columns of two angles, and the vector that they say.
    pub angles: &'static [ValueColumn; 2],
    pub of_angles: fn([f64; 2]) -> Vector3<f64>,
    /// Residuals in reports.
    pub residuals: &'static str,
    /// The fault of a vector of no length.
    pub fault: &'static str,
    /// The axis of the tool that is read; none of a body.
    pub of_tool: Option<Vector3<f64>>,
    /// A start for the values of the target.
    pub target_start: fn(&[MeasuredPoint]) -> Option<TargetValues>,
    /// The predicted unit vector.
    pub predicted: fn(&MeasuredPoint) -> Vector3<f64>,
    /// Its change with the point.
    pub change: fn(&MeasuredPoint, &PointDerivative) -> Vector3<f64>,
    /// Its change with the value `k` of the target.
    pub by_target: fn(&MeasuredPoint, usize) -> Vector3<f64>,
}

/// The measured vector, of any length.
pub(super) fn read(measured: &Rows) -> Vector3<f64> {
    Vector3::from_column_slice(&measured[..3])
}

/// The components of a vector along two unit vectors across the measured direction; across the predicted one where nothing is
/// measured yet.
fn across(measured: &Rows, predicted: &Vector3<f64>, vector: &Vector3<f64>) -> Rows {
    let along = read(measured).try_normalize(LEAST).unwrap_or(*predicted);
    let first = along.cross(&Vector3::ith(along.iamin(), 1.0)).normalize();
    let second = along.cross(&first);
    [first.dot(vector), second.dot(vector), 0.0, 0.0, 0.0, 0.0]
}

impl Observation for Direction {
    fn name(&self) -> &'static str {
        self.name
    }

    fn about(&self) -> &'static str {
        self.about
    }

    fn columns(&self) -> &'static [ValueColumn] {
        self.columns
    }

    fn other_columns(&self) -> &'static [ValueColumn] {
        self.angles
    }

    fn of_other_columns(&self, read: &[f64]) -> Rows {
        rows_of(&(self.of_angles)([0, 1].map(|k| read.get(k).copied().unwrap_or(0.0))))
    }

    fn rows(&self) -> usize {
        2
    }

    fn ignores_arrangement(&self) -> bool {
        self.of_tool.is_none()
    }

    fn sees_orientation(&self) -> bool {
        self.of_tool.is_some()
    }

    fn measured_axes(&self, measured: &Rows) -> Option<Matrix3<f64>> {
        Some(read(measured).try_normalize(LEAST)? * self.of_tool?.transpose())
    }

    fn target_start(&self, read: &[MeasuredPoint]) -> Option<TargetValues> {
        (self.target_start)(read)
    }

    fn residuals_named(&self) -> &'static str {
        self.residuals
    }

    fn fault(&self, measured: &Rows) -> Option<(&'static str, &'static str)> {
        (read(measured).norm() < LEAST).then_some((self.columns[0].name, self.fault))
    }

    fn value(&self, point: &MeasuredPoint) -> Rows {
        rows_of(&(self.predicted)(point))
    }

    fn residual(&self, measured: &Rows, point: &MeasuredPoint) -> Rows {
        let predicted = (self.predicted)(point);
        across(measured, &predicted, &predicted).map(|component| -component)
    }

    fn derivative(&self, point: &MeasuredPoint, by: &PointDerivative) -> Rows {
        across(&point.measured, &(self.predicted)(point), &(self.change)(point, by))
    }

    fn by_target(&self, point: &MeasuredPoint, k: usize) -> Rows {
        across(&point.measured, &(self.predicted)(point), &(self.by_target)(point, k))
    }

    fn disturb(&self, measured: &mut Rows, noise: &Noise, normal: &mut dyn FnMut() -> f64) {
        let along = read(measured);
        let noisy = along + Vector3::from_fn(|_, _| noise.orientation * normal());
        *measured = rows_of(&noisy.try_normalize(LEAST).unwrap_or(along));
    }
}
