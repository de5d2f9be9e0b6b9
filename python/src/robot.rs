//! A robot: its names, and its models over many configurations.

use elastogeo::elastics::{Elastics, Response, Statics};
use elastogeo::files::{LoadedRobot, Reader};
use elastogeo::kinematics::{By, ErrorColumns, Geometry, Placements, Rates, Transform, shift};
use elastogeo::model::Model;
use elastogeo::prediction::SinglePredictor;
use elastogeo::simulation::all_points;
use nalgebra::Vector3;
use pyo3::prelude::*;
use pyo3::types::PyByteArray;
use rayon::prelude::*;

use crate::arrays::{bytes, rows};
use crate::effect::{Faults, Own, catalogue};
use crate::error::{fault, raised};
use crate::work::brief;

type Nominal<'m> = Geometry<'m>;

self_cell::self_cell!(
    /// A robot with its geometry assembled.
    struct Placed {
        owner: LoadedRobot,
        #[covariant]
        dependent: Nominal,
    }
);

#[pyclass(frozen, module = "elastogeo._native")]
pub struct Robot {
    placed: Placed,
    faults: Faults,
}

/// Configurations that one task takes: below that many a second thread costs more than it gives.
const TASK: usize = 512;

/// Name, whether it is an angle, limits.
type Variable = (String, bool, Option<(f64, f64)>);

/// A point of the robot of which poses are asked.
#[derive(Clone, Copy)]
enum Point {
    Tool,
    Frame(usize),
    Marker(usize),
}

#[pymethods]
impl Robot {
    #[new]
    #[pyo3(signature = (name, effects=Vec::new()))]
    fn new(py: Python<'_>, name: String, effects: Vec<Bound<'_, PyAny>>) -> PyResult<Self> {
        let Own { catalogue, faults } = catalogue(py, &effects)?;
        brief(py, move || {
            let loaded = Reader::new(catalogue).robot(&name)?;
            let placed = Placed::try_new(loaded, |loaded| Geometry::nominal(&loaded.model))?;
            Ok(Self { placed, faults })
        })
    }

    #[getter]
    fn name(&self) -> String {
        self.model().name.clone()
    }

    /// Name, whether it is an angle, limits; of each variable.
    #[getter]
    fn variables(&self) -> Vec<Variable> {
        let variables = self.model().variables.iter();
        variables.map(|v| (v.name.clone(), v.is_angle, v.limits.map(|[low, high]| (low, high)))).collect()
    }

    #[getter]
    fn frames(&self) -> Vec<String> {
        self.model().frames.iter().skip(1).map(|frame| frame.name.clone()).collect()
    }

    #[getter]
    fn markers(&self) -> Vec<String> {
        self.model().markers.iter().map(|marker| marker.name.clone()).collect()
    }

    /// Name, unit, nominal value as it is reported (SI), tolerance, whether it is free; of each parameter.
    #[getter]
    fn parameters(&self) -> Vec<(String, &'static str, f64, f64, bool)> {
        let all = self.model().registry.all().iter();
        all.map(|p| (p.name.clone(), p.shown_kind().unit(), p.shown(p.nominal), p.tolerance, p.free)).collect()
    }

    /// Sizes in SI of the description's units of length, angle, force and torque.
    #[getter]
    fn units(&self) -> [f64; 4] {
        let units = &self.loaded().raw.units;
        [units.length.factor(), units.angle.factor(), units.force.factor(), units.torque.factor()]
    }

    /// Poses (n, 4, 4) of a point, base frame: rigid, or under own weight and wrenches (n, 6).
    #[pyo3(signature = (q, at=None, loads=None))]
    fn forward<'py>(
        &self,
        py: Python<'py>,
        q: &[u8],
        at: Option<&str>,
        loads: Option<&[u8]>,
    ) -> PyResult<Bound<'py, PyByteArray>> {
        let width = self.model().variables.len();
        let (q, point) = (rows(py, q, width, "q")?, self.point(py, at)?);
        let poses = match loads {
            None => brief(py, || self.rigid(&q, point))?,
            Some(loads) => {
                let loads = rows(py, loads, 6, "wrench")?;
                let index = match point {
                    Point::Tool => 0,
                    Point::Marker(marker) => marker + 1,
                    Point::Frame(_) => {
                        return Err(fault(py, "frames are not deflected", "ask for a marker, or for the tool"));
                    }
                };
                self.faults.first(brief(py, || self.loaded_at(&q, &loads, index)))?
            }
        };
        bytes(py, &poses)
    }

    /// Derivatives (n, 6, variables) of the rigid position and rotation of a point, base axes.
    #[pyo3(signature = (q, at=None))]
    fn jacobian<'py>(&self, py: Python<'py>, q: &[u8], at: Option<&str>) -> PyResult<Bound<'py, PyByteArray>> {
        let (q, point) = (rows(py, q, self.model().variables.len(), "q")?, self.point(py, at)?);
        let found = brief(py, || self.derivatives(&q, point))?;
        bytes(py, &found)
    }

    /// Compliances (n, 6, 6) at a point, base axes.
    #[pyo3(signature = (q, at=None))]
    fn compliance<'py>(&self, py: Python<'py>, q: &[u8], at: Option<&str>) -> PyResult<Bound<'py, PyByteArray>> {
        let (q, point) = (rows(py, q, self.model().variables.len(), "q")?, self.point(py, at)?);
        let found = brief(py, || self.compliances(&q, point))?;
        bytes(py, &found)
    }
}

impl Robot {
    fn loaded(&self) -> &LoadedRobot {
        self.placed.borrow_owner()
    }

    fn model(&self) -> &Model {
        &self.loaded().model
    }

    fn geometry(&self) -> &Geometry<'_> {
        self.placed.borrow_dependent()
    }

    fn point(&self, py: Python<'_>, at: Option<&str>) -> PyResult<Point> {
        let model = self.model();
        let Some(at) = at else { return Ok(Point::Tool) };
        let found = model.frame(at).map(Point::Frame).or_else(|| model.marker(at).map(Point::Marker));
        found.ok_or_else(|| {
            let frames = model.frames.iter().map(|frame| frame.name.as_str());
            let valid = frames.chain(model.markers.iter().map(|marker| marker.name.as_str()));
            let unknown = elastogeo::diagnostic::Diagnostic::error(format!("no frame or marker is called `{at}`"));
            raised(py, &unknown.suggest(at, valid).into())
        })
    }

    /// The frame of a point, and where it is in that.
    fn place_of(&self, point: Point) -> (usize, Vector3<f64>) {
        let (model, geometry) = (self.model(), self.geometry());
        match point {
            Point::Tool => (model.tool.0, geometry.tool().translation.vector),
            Point::Frame(frame) => (frame, Vector3::zeros()),
            Point::Marker(marker) => {
                (model.markers.get(marker).map_or(0, |marker| marker.frame), geometry.marker(marker).coords)
            }
        }
    }

    /// `width` numbers for each configuration, in order, whatever the number of threads.
    fn each<W>(
        &self,
        q: &[f64],
        width: usize,
        workspace: impl Fn() -> W + Sync,
        one: impl Fn(usize, &[f64], &mut W, &mut [f64]) -> Result<(), elastogeo::Error> + Sync,
    ) -> Result<Vec<f64>, elastogeo::Error> {
        let variables = self.model().variables.len().max(1);
        let count = q.len() / variables;
        let mut out = vec![0.0; count * width];
        let task = |(task, (q, out)): (usize, (&[f64], &mut [f64]))| -> Result<(), elastogeo::Error> {
            let mut own = workspace();
            for (row, (q, out)) in q.chunks(variables).zip(out.chunks_mut(width)).enumerate() {
                let row = task * TASK + row;
                one(row, q, &mut own, out).map_err(|error| error.at(format!("row {row}")))?;
            }
            Ok(())
        };
        if count <= TASK {
            task((0, (q, &mut out)))?;
        } else {
            let tasks = q.par_chunks(TASK * variables).zip(out.par_chunks_mut(TASK * width)).enumerate();
            tasks.map(task).collect::<Vec<_>>().into_iter().collect::<Result<(), _>>()?;
        }
        Ok(out)
    }

    fn rigid(&self, q: &[f64], point: Point) -> Result<Vec<f64>, elastogeo::Error> {
        let (geometry, (frame, local)) = (self.geometry(), self.place_of(point));
        let tool = geometry.tool();
        self.each(q, 16, Placements::default, |_, q, placements, out| {
            geometry.place(q, placements)?;
            let placed = frame_at(placements, frame)?;
            let pose = match point {
                Point::Tool => placed * tool,
                _ => {
                    Transform::from_parts((placed.translation.vector + placed.rotation * local).into(), placed.rotation)
                }
            };
            put(&pose, out);
            Ok(())
        })
    }

    fn loaded_at(&self, q: &[f64], loads: &[f64], index: usize) -> Result<Vec<f64>, elastogeo::Error> {
        let model = self.model();
        let points = all_points(model);
        let predictor = SinglePredictor::new(model, &model.registry.nominal(), &points)?;
        let failed = elastogeo::compensation::Refusal::from;
        self.each(
            q,
            16,
            || predictor.workspace(),
            |row, q, work, out| {
                predictor.place(q, work).map_err(failed)?;
                let load = loads.chunks_exact(6).nth(row).and_then(|load| load.try_into().ok()).unwrap_or([0.0; 6]);
                put(&predictor.see(index, &load, work).map_err(failed)?.real, out);
                Ok(())
            },
        )
    }

    fn derivatives(&self, q: &[f64], point: Point) -> Result<Vec<f64>, elastogeo::Error> {
        let (model, geometry) = (self.model(), self.geometry());
        let variables = model.variables.len();
        let by: Vec<By> = (0..variables).map(By::Variable).collect();
        let (frame, local) = self.place_of(point);
        let workspace = || {
            let rates = Rates::new(model);
            let columns = ErrorColumns::new(geometry, &rates, frame, &by);
            (Placements::default(), rates, columns, vec![[0.0; 6]; variables])
        };
        self.each(q, 6 * variables, workspace, |_, q, (placements, rates, columns, found), out| {
            geometry.place(q, placements)?;
            if columns.needs_rates() {
                rates.evaluate(geometry, q, placements);
            }
            columns.evaluate(geometry, placements, rates, found);
            let arm = frame_at(placements, frame)?.rotation * local;
            for (variable, column) in found.iter().enumerate() {
                let moved = shift(column, &arm);
                let twist = moved.iter().chain(column.iter().skip(3));
                for (value, out) in twist.zip(out.iter_mut().skip(variable).step_by(variables)) {
                    *out = *value;
                }
            }
            Ok(())
        })
    }

    fn compliances(&self, q: &[f64], point: Point) -> Result<Vec<f64>, elastogeo::Error> {
        let (model, geometry) = (self.model(), self.geometry());
        if model.fuzzy.is_some() {
            return Err(elastogeo::Error::input(
                "the description's compliance is by rules",
                "ask for `stiffness` at single configurations",
            ));
        }
        let elastics = Elastics::new(model, &model.registry.nominal(), &[]);
        let (frame, local) = self.place_of(point);
        let vertex = model.structure.carrier(frame, &local);
        let workspace = || (Placements::default(), Statics::new(false), Response::new(&elastics, vertex));
        self.each(q, 36, workspace, |_, q, (placements, statics, response), out| {
            geometry.place(q, placements)?;
            elastics.prepare(placements, statics)?;
            response.evaluate(&elastics, statics);
            let frame = frame_at(placements, frame)?;
            let at = frame.translation.vector + frame.rotation * local;
            let found = response.compliance_at(&at);
            for (out, value) in out.iter_mut().zip(found.transpose().iter()) {
                *out = *value;
            }
            Ok(())
        })
    }
}

fn frame_at(placements: &Placements, frame: usize) -> Result<Transform, elastogeo::Error> {
    let found = placements.frames.get(frame).copied();
    found.ok_or_else(|| elastogeo::Error::input("a frame is not placed", "report it, with the description"))
}

/// A homogeneous matrix, by row.
fn put(pose: &Transform, out: &mut [f64]) {
    for (out, value) in out.iter_mut().zip(pose.to_homogeneous().transpose().iter()) {
        *out = *value;
    }
}
