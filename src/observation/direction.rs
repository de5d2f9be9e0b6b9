//! Directions as readings: two residuals (rad), the angle between the predicted and the measured direction by its components across the
//! measured one. They are the rotation vector that takes one into the other, so that a direction that is reversed is pi off.

use nalgebra::{Matrix3, Vector3};

use super::kind::{
    MeasuredPoint, Noise, Observation, PointDerivative, Rows, TargetValues, ValueColumn, ValueFault, rows_of,
};

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
    /// The angles of a unit vector.
    pub in_angles: fn(&Vector3<f64>) -> [f64; 2],
    /// Residuals in reports.
    pub residuals: &'static str,
    /// As [`Observation::depends_on`].
    pub depends_on: &'static str,
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

/// The predicted direction seen from the measured one; from itself where nothing is measured yet.
struct Across {
    along: Vector3<f64>,
    /// Unit vectors across it.
    axes: [Vector3<f64>; 2],
    /// Components of the predicted direction along these: together the sine of the angle.
    sines: [f64; 2],
    cosine: f64,
    angle: f64,
}

/// An angle (rad) below which its ratio to its sine is that of the series.
const SMALL: f64 = 1e-3;

impl Across {
    fn new(measured: &Rows, predicted: &Vector3<f64>) -> Self {
        let along = read(measured).try_normalize(LEAST).unwrap_or(*predicted);
        let first = along.cross(&Vector3::ith(along.iamin(), 1.0)).normalize();
        let axes = [first, along.cross(&first)];
        let (sines, cosine) = (axes.map(|axis| axis.dot(predicted)), along.dot(predicted));
        Self { along, axes, sines, cosine, angle: sines[0].hypot(sines[1]).atan2(cosine) }
    }

    /// The angle over its sine, and the derivative of that by the cosine.
    fn stretch(&self) -> [f64; 2] {
        let (angle, sine) = (self.angle, self.angle.sin());
        if angle < SMALL {
            return [1.0 + angle * angle / 6.0, -1.0 / 3.0 - 2.0 * angle * angle / 15.0];
        }
        let sine = sine.max(LEAST);
        [angle / sine, -(sine - angle * self.cosine) / sine.powi(3)]
    }

    /// Components of the rotation from the measured to the predicted direction.
    fn angles(&self) -> Rows {
        let [stretch, _] = self.stretch();
        // Opposite directions are a half turn apart about any axis across.
        let is_opposite = self.cosine < 0.0 && self.sines[0].hypot(self.sines[1]) < LEAST;
        let [a, b] = if is_opposite { [self.angle, 0.0] } else { self.sines.map(|sine| stretch * sine) };
        [a, b, 0.0, 0.0, 0.0, 0.0]
    }

    /// Their change with the predicted direction.
    fn derivative(&self, change: &Vector3<f64>) -> Rows {
        let [stretch, by_cosine] = self.stretch();
        let along = self.along.dot(change);
        let of = |k: usize| stretch * self.axes[k].dot(change) + self.sines[k] * by_cosine * along;
        [of(0), of(1), 0.0, 0.0, 0.0, 0.0]
    }
}

impl Observation for Direction {
    fn name(&self) -> &'static str {
        self.name
    }

    fn depends_on(&self) -> &'static str {
        self.depends_on
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

    fn in_other_columns(&self, measured: &Rows) -> Option<[f64; 2]> {
        read(measured).try_normalize(LEAST).map(|along| (self.in_angles)(&along))
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

    fn fault(&self, measured: &Rows, _is_free: &[bool]) -> Option<ValueFault> {
        (read(measured).norm() < LEAST).then_some(ValueFault {
            column: self.columns[0].name,
            message: self.fault,
            remedy: "give the direction as it was read, in any length; remove the row if the sensor showed nothing",
        })
    }

    fn reversed(&self, measured: &Rows) -> Option<Rows> {
        // An axis of the tool is no sensor's.
        self.of_tool.is_none().then(|| rows_of(&-read(measured)))
    }

    fn value(&self, point: &MeasuredPoint) -> Rows {
        rows_of(&(self.predicted)(point))
    }

    fn residual(&self, measured: &Rows, point: &MeasuredPoint) -> Rows {
        Across::new(measured, &(self.predicted)(point)).angles().map(|component| -component)
    }

    fn derivative(&self, point: &MeasuredPoint, by: &PointDerivative) -> Rows {
        Across::new(&point.measured, &(self.predicted)(point)).derivative(&(self.change)(point, by))
    }

    fn by_target(&self, point: &MeasuredPoint, k: usize) -> Rows {
        Across::new(&point.measured, &(self.predicted)(point)).derivative(&(self.by_target)(point, k))
    }

    fn disturb(&self, measured: &mut Rows, noise: &Noise, normal: &mut dyn FnMut() -> f64) {
        let along = read(measured);
        let noisy = along + Vector3::from_fn(|_, _| noise.orientation * normal());
        *measured = rows_of(&noisy.try_normalize(LEAST).unwrap_or(along));
    }
}
