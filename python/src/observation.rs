//! Kinds of readings that a Python program declares: objects with the attributes of `elastogeo.Observation`.

use std::cell::Cell;
use std::f64::consts::TAU;
use std::panic::resume_unwind;

use elastogeo::observation::{
    MOST_ROWS, MeasuredPoint, Noise, Observation, Observes, PointDerivative, Rows, ValueColumn,
};
use nalgebra::{Rotation3, Vector3};
use pyo3::prelude::*;

use crate::faults::Faults;
use crate::words::kept;
use crate::work::Stopped;

/// What the model predicts of a measured point, SI.
#[pyclass(frozen, get_all, module = "elastogeo._native")]
pub struct Point {
    position: [f64; 3],
    orientation: [[f64; 3]; 3],
    gravity: [f64; 3],
    target: Vec<f64>,
}

impl Point {
    fn new(point: &MeasuredPoint) -> Self {
        Self {
            position: point.position().into(),
            orientation: std::array::from_fn(|i| std::array::from_fn(|k| point.orientation[(i, k)])),
            gravity: point.gravity.into(),
            target: point.target.to_vec(),
        }
    }
}

/// A kind declared in Python.
struct PythonObservation {
    name: &'static str,
    about: &'static str,
    columns: &'static [ValueColumn],
    target: Option<&'static str>,
    sees_orientation: bool,
    /// The method `value`, and what checks its result.
    value: Py<PyAny>,
    said: Py<PyAny>,
    faults: Faults,
}

/// A kind of readings of a Python program, made once for each object that declares one.
#[pyclass(frozen, module = "elastogeo._native")]
pub struct Kind(&'static PythonObservation);

#[pymethods]
impl Kind {
    #[new]
    fn new(py: Python<'_>, kind: &Bound<'_, PyAny>) -> PyResult<Self> {
        type Declared = (String, String, Vec<(String, String)>, Option<String>, bool);
        let (name, about, columns, target, sees_orientation): Declared = kind.call_method0("_declared")?.extract()?;
        let column = |(name, unit): &(String, String)| match unit.as_str() {
            "m" => ValueColumn::length(kept(name)),
            _ => ValueColumn::angle(kept(name)),
        };
        let columns: Vec<ValueColumn> = columns.iter().map(column).collect();
        // A kind lives as long as the program: readings hold on to it.
        Ok(Self(Box::leak(Box::new(PythonObservation {
            name: kept(&name),
            about: kept(&about),
            columns: Box::leak(columns.into_boxed_slice()),
            target: target.as_deref().map(kept),
            sees_orientation,
            value: kind.getattr("value")?.unbind(),
            said: py.import("elastogeo.observations")?.getattr("_said")?.unbind(),
            faults: Faults::new(),
        }))))
    }
}

impl Kind {
    pub fn observes(&self) -> Observes {
        Observes::new(self.0)
    }

    /// Where its exceptions are kept.
    pub fn faults(&self) -> &Faults {
        &self.0.faults
    }
}

/// Step of a central difference, m and rad: the cube root of the rounding, at a size of one.
const STEP: f64 = 6e-6;

/// Derivatives of a value by displacement (m) and rotation (rad) of the point.
type ByTwist = [Rows; 6];

thread_local! {
    /// The last point whose derivatives were asked for, and of which kind: each parameter asks for them once more.
    static LAST: Cell<Option<(*const PythonObservation, MeasuredPoint, ByTwist)>> = const { Cell::new(None) };
}

impl PythonObservation {
    /// Difference of two values: of angles the one within half a turn.
    fn difference(&self, a: &Rows, b: &Rows) -> Rows {
        let lengths = self.length_rows();
        let turns = |k: usize, difference: f64| if k < lengths { 0.0 } else { TAU * (difference / TAU).round() };
        std::array::from_fn(|k| a[k] - b[k] - turns(k, a[k] - b[k]))
    }

    /// Central difference of values along a change of the point.
    fn slope(&self, moved: impl Fn(f64) -> MeasuredPoint) -> Rows {
        self.difference(&self.value(&moved(STEP)), &self.value(&moved(-STEP))).map(|change| change / (2.0 * STEP))
    }

    /// Derivatives by displacement, and by rotation where it shows.
    fn by_twist(&self, point: &MeasuredPoint) -> ByTwist {
        // A kind that replaces another has its name, and not its place.
        let known = LAST.get().filter(|(kind, last, _)| std::ptr::eq(*kind, self) && last == point);
        if let Some((_, _, by)) = known {
            return by;
        }
        let axis = |k: usize| Vector3::ith(k % 3, 1.0);
        let shifted = |k: usize, step: f64| MeasuredPoint { undeflected: point.undeflected + step * axis(k), ..*point };
        let turned = |k: usize, step: f64| {
            let turn = Rotation3::new(step * axis(k));
            MeasuredPoint { orientation: turn * point.orientation, body: turn * point.body, ..*point }
        };
        let by = std::array::from_fn(|k| match k {
            0..3 => self.slope(|step| shifted(k, step)),
            _ if self.sees_orientation => self.slope(|step| turned(k, step)),
            _ => [0.0; MOST_ROWS],
        });
        LAST.set(Some((std::ptr::from_ref(self), *point, by)));
        by
    }
}

impl Observation for PythonObservation {
    fn name(&self) -> &'static str {
        self.name
    }

    fn about(&self) -> &'static str {
        self.about
    }

    fn columns(&self) -> &'static [ValueColumn] {
        self.columns
    }

    fn target_column(&self) -> Option<&'static str> {
        self.target
    }

    fn sees_orientation(&self) -> bool {
        self.sees_orientation
    }

    fn residuals_named(&self) -> &'static str {
        "values"
    }

    fn value(&self, point: &MeasuredPoint) -> Rows {
        let value = Python::attach(|py| {
            let said = self.value.call1(py, (Point::new(point),));
            let said = said.and_then(|said| self.said.call1(py, (said, self.columns.len()))?.extract::<Vec<f64>>(py));
            said.map_err(|raised| self.faults.keep(raised))
        });
        // Nothing can be computed without it: the work ends here, and what was kept is raised.
        let Ok(value) = value else { resume_unwind(Box::new(Stopped)) };
        std::array::from_fn(|k| value.get(k).copied().unwrap_or(0.0))
    }

    fn residual(&self, measured: &Rows, point: &MeasuredPoint) -> Rows {
        self.difference(measured, &self.value(point))
    }

    fn derivative(&self, point: &MeasuredPoint, by: &PointDerivative) -> Rows {
        let (by_twist, total) = (self.by_twist(point), by.total());
        let twist = [total.displacement.as_slice(), total.rotation.as_slice()].concat();
        std::array::from_fn(|row| twist.iter().zip(&by_twist).map(|(part, by)| part * by[row]).sum())
    }

    fn by_target(&self, point: &MeasuredPoint, k: usize) -> Rows {
        self.slope(|step| {
            let mut shifted = *point;
            shifted.target[k] += step;
            shifted
        })
    }

    fn sigmas(&self, noise: &Noise) -> Rows {
        let lengths = self.length_rows();
        std::array::from_fn(|k| if k < lengths { noise.position[k.min(2)] } else { noise.orientation })
    }

    fn is_comparable(&self, same_point: bool, same_target: bool) -> bool {
        same_point && same_target
    }
}
