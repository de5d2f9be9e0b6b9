//! A robot: its names, and its models over many configurations.

use elastogeo::description::campaign::Campaign;
use elastogeo::elastics::{Elastics, Response, Statics, put_fuzzy};
use elastogeo::files::LoadedRobot;
use elastogeo::kinematics::{AssemblyError, By, ErrorColumns, Geometry, Placements, Rates, Transform, shift};
use elastogeo::model::Model;
use elastogeo::prediction::{SinglePredictor, SingleWorkspace};
use elastogeo::simulation::all_points;
use nalgebra::Vector3;
use numpy::PyArrayDyn;
use pyo3::prelude::*;
use rayon::prelude::*;

use crate::arrays::{Rows, of_rows, rows};
use crate::error::{fault, raised};
use crate::faults::Faults;
use crate::inverse::{Search, Targets};
use crate::own::{look_for_sites, own};
use crate::pool::Pool;
use crate::work::brief;

/// What configurations are evaluated with, by the description's values.
struct Nominal<'m> {
    geometry: Geometry<'m>,
    elastics: Elastics<'m>,
    /// Poses under load of the points of the owner's second part.
    predictor: Result<SinglePredictor<'m>, AssemblyError>,
}

impl<'m> Nominal<'m> {
    fn new((loaded, points): &'m (LoadedRobot, Campaign)) -> Result<Self, AssemblyError> {
        let (model, values) = (&loaded.model, loaded.model.registry.nominal());
        Ok(Self {
            geometry: Geometry::nominal(model)?,
            elastics: Elastics::new(model, &values, &[]),
            predictor: SinglePredictor::new(model, &values, points),
        })
    }
}

self_cell::self_cell!(
    /// A robot with its models.
    struct Placed {
        owner: (LoadedRobot, Campaign),
        #[covariant]
        dependent: Nominal,
    }
);

type Motion = (Placements, Rates, ErrorColumns, Vec<[f64; 6]>);
type Yield = (Placements, Statics, Response);

/// Workspaces of the functions of arrays.
#[derive(Default)]
struct Workspaces {
    rigid: Pool<(), Placements>,
    loaded: Pool<(), SingleWorkspace>,
    derivatives: Pool<Point, Motion>,
    compliances: Pool<Point, Yield>,
}

#[pyclass(frozen, module = "elastogeo._native")]
pub struct Robot {
    placed: Placed,
    workspaces: Workspaces,
    faults: Faults,
}

/// Configurations that one task takes: below that many a second thread costs more than it gives.
const TASK: usize = 512;
/// Tasks of each thread between two looks for signals: a tenth of a second at most, of heavy robots with loops.
const TASKS: usize = 4;

/// Name, whether it is an angle, limits.
type Variable = (String, bool, Option<(f64, f64)>);

/// A point of the robot of which poses are asked.
#[derive(Clone, Copy, PartialEq)]
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
        let own = own(py, &effects, &[])?;
        let faults = own.faults.clone();
        let found = brief(py, move || {
            let loaded = own.reader().robot(&name)?;
            look_for_sites(&own.catalogue, &loaded.model);
            let points = all_points(&loaded.model);
            let placed = Placed::try_new((loaded, points), |parts| Nominal::new(parts))?;
            Ok(Self { placed, workspaces: Workspaces::default(), faults: own.faults })
        });
        faults.first(found)
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
    #[pyo3(signature = (q, at=None, weight=false, wrench=None))]
    fn forward<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        at: Option<&str>,
        weight: bool,
        wrench: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let (q, point) = (self.joints(py, q)?, self.point(py, at)?);
        let poses = if weight || wrench.is_some() {
            let wrenches = wrench.map(|wrench| rows(py, wrench, 6, "wrench")).transpose()?;
            let index = match point {
                Point::Tool => 0,
                Point::Marker(marker) => marker + 1,
                Point::Frame(_) => {
                    return Err(fault(py, "frames are not deflected", "ask for a marker, or for the tool"));
                }
            };
            self.faults.first(self.loaded_at(py, &q.values, wrenches.as_ref(), index))?
        } else {
            self.rigid(py, &q.values, point)?
        };
        of_rows(py, poses, q.is_single, &[4, 4])
    }

    /// Derivatives (n, 6, variables) of the rigid position and rotation of a point, base axes.
    #[pyo3(signature = (q, at=None))]
    fn jacobian<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        at: Option<&str>,
    ) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let (q, point) = (self.joints(py, q)?, self.point(py, at)?);
        let found = self.derivatives(py, &q.values, point)?;
        of_rows(py, found, q.is_single, &[6, self.model().variables.len()])
    }

    /// Compliances (n, 6, 6) at a point, base axes.
    #[pyo3(signature = (q, at=None))]
    fn compliance<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        at: Option<&str>,
    ) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let (q, point) = (self.joints(py, q)?, self.point(py, at)?);
        let found = self.compliances(py, &q.values, point)?;
        of_rows(py, found, q.is_single, &[6, 6])
    }

    /// Joints (n, variables) nearest a start, of positions (n, 3) and rotation vectors (n, 3) of the tool, base frame.
    fn solve<'py>(
        &self,
        py: Python<'py>,
        positions: &Bound<'py, PyAny>,
        rotations: Option<&Bound<'py, PyAny>>,
        starts: &Bound<'py, PyAny>,
        search: Search,
    ) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let positions = rows(py, positions, 3, "target")?;
        let rotations = rotations.map(|rotations| rows(py, rotations, 3, "target")).transpose()?;
        let starts = rows(py, starts, self.model().variables.len(), "start")?;
        let predictor = if search.weight { Some(self.predictor(py)?) } else { None };
        let targets = Targets { positions: &positions, rotations: rotations.as_ref(), starts: &starts };
        let found = self.faults.first(targets.solve(py, self.geometry(), predictor, &search))?;
        of_rows(py, found, positions.is_single, &[self.model().variables.len()])
    }
}

impl Robot {
    fn loaded(&self) -> &LoadedRobot {
        &self.placed.borrow_owner().0
    }

    fn model(&self) -> &Model {
        &self.loaded().model
    }

    fn geometry(&self) -> &Geometry<'_> {
        &self.nominal().geometry
    }

    fn nominal(&self) -> &Nominal<'_> {
        self.placed.borrow_dependent()
    }

    fn predictor(&self, py: Python<'_>) -> PyResult<&SinglePredictor<'_>> {
        self.nominal().predictor.as_ref().map_err(|error| raised(py, &error.clone().into()))
    }

    fn joints(&self, py: Python<'_>, q: &Bound<'_, PyAny>) -> PyResult<Rows> {
        rows(py, q, self.model().variables.len(), "q")
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

    /// `width` numbers for each configuration, in order, whatever the number of threads. The interpreter's lock is free
    /// meanwhile, and signals are heeded.
    fn each<K: Copy + PartialEq + Send + Sync, W: Send>(
        &self,
        py: Python<'_>,
        q: &[f64],
        width: usize,
        (pool, of): (&Pool<K, W>, K),
        workspace: impl Fn() -> W + Sync,
        one: impl Fn(usize, &[f64], &mut W, &mut [f64]) -> Result<(), elastogeo::Error> + Sync,
    ) -> PyResult<Vec<f64>> {
        let variables = self.model().variables.len().max(1);
        let mut out = vec![0.0; q.len() / variables * width];
        let task = |first: usize, q: &[f64], out: &mut [f64]| -> Result<(), elastogeo::Error> {
            pool.with(of, &workspace, |own| {
                for (row, (q, out)) in q.chunks(variables).zip(out.chunks_mut(width)).enumerate() {
                    one(first + row, q, own, out).map_err(|error| error.at(format!("row {}", first + row)))?;
                }
                Ok(())
            })
        };
        if q.len() <= TASK * variables {
            brief(py, || task(0, q, &mut out))?;
            return Ok(out);
        }
        let block = TASK * TASKS * rayon::current_num_threads();
        for (number, (q, out)) in q.chunks(block * variables).zip(out.chunks_mut(block * width)).enumerate() {
            brief(py, || {
                let tasks = q.par_chunks(TASK * variables).zip(out.par_chunks_mut(TASK * width)).enumerate();
                let done = tasks.map(|(at, (q, out))| task(number * block + at * TASK, q, out));
                done.collect::<Vec<_>>().into_iter().collect::<Result<(), _>>()
            })?;
            py.check_signals()?;
        }
        Ok(out)
    }

    fn rigid(&self, py: Python<'_>, q: &[f64], point: Point) -> PyResult<Vec<f64>> {
        let (geometry, (frame, local)) = (self.geometry(), self.place_of(point));
        let tool = geometry.tool();
        self.each(py, q, 16, (&self.workspaces.rigid, ()), Placements::default, |_, q, placements, out| {
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

    /// Under own weight, and under one wrench, one for each configuration, or none.
    fn loaded_at(&self, py: Python<'_>, q: &[f64], wrenches: Option<&Rows>, index: usize) -> PyResult<Vec<f64>> {
        let count = q.len() / self.model().variables.len().max(1);
        let mut loads = wrenches.map_or(Vec::new(), |wrenches| wrenches.values.chunks_exact(6).collect());
        if wrenches.is_some_and(|wrenches| !wrenches.is_single) && loads.len() != count {
            let message = format!("wrench: {} rows, and {count} configurations", loads.len());
            return Err(fault(py, message, "give one wrench of shape (6,), or one for each configuration"));
        }
        if wrenches.is_some_and(|wrenches| wrenches.is_single) {
            let one = loads.first().copied().unwrap_or_default();
            loads.resize(count, one);
        }
        let predictor = self.predictor(py)?;
        let failed = elastogeo::compensation::Refusal::from;
        let own = (&self.workspaces.loaded, ());
        self.each(
            py,
            q,
            16,
            own,
            || predictor.workspace(),
            |row, q, work, out| {
                predictor.place(q, work).map_err(failed)?;
                let load = loads.get(row).and_then(|&load| load.try_into().ok()).unwrap_or([0.0; 6]);
                put(&predictor.see(index, &load, work).map_err(failed)?.real, out);
                Ok(())
            },
        )
    }

    fn derivatives(&self, py: Python<'_>, q: &[f64], point: Point) -> PyResult<Vec<f64>> {
        let (model, geometry) = (self.model(), self.geometry());
        let variables = model.variables.len();
        let (frame, local) = self.place_of(point);
        let workspace = || {
            let by: Vec<By> = (0..variables).map(By::Variable).collect();
            let rates = Rates::new(model);
            let columns = ErrorColumns::new(geometry, &rates, frame, &by);
            (Placements::default(), rates, columns, vec![[0.0; 6]; variables])
        };
        let own = (&self.workspaces.derivatives, point);
        self.each(py, q, 6 * variables, own, workspace, |_, q, (placements, rates, columns, found), out| {
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

    fn compliances(&self, py: Python<'_>, q: &[f64], point: Point) -> PyResult<Vec<f64>> {
        let (model, geometry, elastics) = (self.model(), self.geometry(), &self.nominal().elastics);
        if !elastics.is_compliant() && model.fuzzy.is_none() {
            return Err(fault(
                py,
                "the description declares nothing elastic",
                "give `joint_stiffness`, `beams` or `base_stiffness`",
            ));
        }
        let (frame, local) = self.place_of(point);
        let vertex = model.structure.carrier(frame, &local);
        let workspace = || (Placements::default(), Statics::new(false), Response::new(elastics, vertex));
        let own = (&self.workspaces.compliances, point);
        self.each(py, q, 36, own, workspace, |_, q, (placements, statics, response), out| {
            geometry.place(q, placements)?;
            elastics.prepare(placements, statics)?;
            response.evaluate(elastics, statics);
            put_fuzzy(geometry, placements, response);
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
    let rows = pose.to_homogeneous().transpose();
    if out.len() == rows.len() {
        out.copy_from_slice(rows.as_slice());
    }
}
