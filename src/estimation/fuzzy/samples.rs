//! Deflections as samples of a compliance: inputs in rad and m, loads in N and N.m, displacements in m and rad, in the
//! axes of the rules.

use nalgebra::{DMatrix, Rotation3, Vector3};

use super::task::{AxesOf, FuzzyTask};
use crate::description::campaign::Campaign;
use crate::description::robot::FrameIndex;
use crate::estimation::result::CalibrationError;
use crate::fuzzy;
use crate::math::linear::PivotedQr;
use crate::math::{distinct, extremes};
use crate::prediction::PredictionError;
use crate::state::{Loads, Mechanics, State};

/// Displacements of one point of the tool under loads on it.
pub struct Samples {
    /// The point: a marker, or the tool centre point.
    pub marker: Option<usize>,
    /// Frame whose axes loads and displacements have; `None` is the base.
    pub axes: Option<FrameIndex>,
    /// How many displacement components there are: 3, or 6 with rotations.
    pub rows: usize,
    /// Inputs, rad and m.
    pub x: Vec<Vec<f64>>,
    /// Force and moment at the point.
    pub load: Vec<[f64; 6]>,
    /// Displacement to be explained, m, and rotation, rad.
    pub d: Vec<[f64; 6]>,
    pub pose: Vec<usize>,
    pub held_out: Vec<bool>,
    /// Components of the load that occur among the fitted readings.
    pub columns: Vec<usize>,
    /// Least and greatest of each input among the fitted readings.
    pub range: Vec<[f64; 2]>,
    /// Root mean square displacement (m) and rotation (rad) of a direction among the fitted readings.
    pub sizes: [f64; 2],
}

/// Difference of wrenches (relative) below which readings of several markers are of one load: rounding of files.
const SAME_LOAD: f64 = 1e-6;

/// Part of the greatest column below which markers do not determine a rotation: they stand on a line, to 0.1 mm a metre.
const DEPENDENT: f64 = 1e-4;

fn malformed<T>(text: impl Into<String>) -> Result<T, CalibrationError> {
    Err(CalibrationError::Malformed(text.into()))
}

impl Samples {
    /// The measured displacements, with the geometry at `values`.
    pub fn measured(task: &FuzzyTask, axes: AxesOf, values: &[f64]) -> Result<Self, CalibrationError> {
        let width = task.campaign.observes.rows();
        let readings = task.campaign.readings.iter();
        let all: Vec<f64> = readings.flat_map(|reading| reading.measured.into_iter().take(width)).collect();
        Self::new(task, axes, values, &all)
    }

    /// Displacements (three or six a reading, SI, axes of the measurement frame), with the geometry at `values`.
    pub fn new(task: &FuzzyTask, axes: AxesOf, values: &[f64], displacement: &[f64]) -> Result<Self, CalibrationError> {
        let FuzzyTask { model, campaign, held_out, inputs: of, .. } = *task;
        if !campaign.is_difference() {
            return malformed(
                "a fuzzy compliance is fitted to deflections (`observes: deflection` or `deflection-pose`)",
            );
        }
        let Some(first) = campaign.readings.first() else { return malformed("the campaign has no readings") };
        if held_out.iter().all(|held_out| *held_out) {
            return malformed("no reading is left to fit");
        }
        if of.is_empty() {
            return malformed("nothing that the compliance could depend on changes in the readings");
        }
        let loads = Loads { weight: false, wrench: true };
        let mechanics = Mechanics::new(model, values, loads, &[]).map_err(PredictionError::from)?;
        let several = campaign.readings.iter().any(|reading| reading.marker != first.marker);
        let axes = match axes {
            AxesOf::Frame(frame) => Some(frame),
            AxesOf::Base | AxesOf::Best => None,
        };
        let mut samples = Self {
            marker: if several { None } else { first.marker },
            axes,
            rows: campaign.observes.rows(),
            x: Vec::new(),
            load: Vec::new(),
            d: Vec::new(),
            pose: Vec::new(),
            held_out: Vec::new(),
            columns: Vec::new(),
            range: Vec::new(),
            sizes: [0.0; 2],
        };
        let mut placed = Placed { state: mechanics.state(), mechanics, campaign };
        if several {
            samples.add_bodies(task, &mut placed, displacement)?;
        } else {
            for (index, own) in displacement.chunks(samples.rows).enumerate() {
                placed.place(index)?;
                let [_, force, moment] = placed.load(index);
                samples.add(task, &placed, index, wrench(&force, &moment), own);
            }
        }
        samples.survey();
        Ok(samples)
    }

    /// Adds a displacement (axes of the measurement frame) under a wrench at the point (axes of the base).
    fn add(&mut self, task: &FuzzyTask, placed: &Placed, index: usize, load: [f64; 6], displacement: &[f64]) {
        let placements = &placed.state.placements;
        let turn = self.axes.map_or(Rotation3::identity(), |axes| placements.frames[axes].rotation.inverse());
        let from_measurement = turn * placed.mechanics.geometry.base().rotation.inverse();
        let turned = |turn: &Rotation3<f64>, of: &[f64]| {
            let mut out = [0.0; 6];
            for (out, of) in out.chunks_mut(3).zip(of.chunks(3)) {
                out.copy_from_slice((turn * Vector3::from_column_slice(of)).as_slice());
            }
            out
        };
        let mut x = Vec::new();
        fuzzy::inputs(task.inputs, placements, &mut x);
        self.x.push(x);
        let mut own = turned(&turn, &load);
        // A turn by rounding loads no further component.
        let least = 1e-12 * own.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
        own.iter_mut().filter(|v| v.abs() <= least).for_each(|v| *v = 0.0);
        self.load.push(own);
        self.d.push(turned(&from_measurement, displacement));
        self.pose.push(task.campaign.readings[index].pose);
        self.held_out.push(task.held_out[index]);
    }

    /// Readings of several markers as displacement and rotation of the tool: of each configuration and load those of the
    /// rigid body that fit its markers best.
    fn add_bodies(
        &mut self,
        task: &FuzzyTask,
        placed: &mut Placed,
        displacement: &[f64],
    ) -> Result<(), CalibrationError> {
        let (campaign, width) = (task.campaign, self.rows);
        self.rows = 6;
        let to_base = placed.mechanics.geometry.base().rotation.inverse();
        let mut bodies: Vec<Body> = Vec::new();
        let mut first_of_pose = 0;
        for (index, reading) in campaign.readings.iter().enumerate() {
            placed.place(index)?;
            let tool = placed.tool();
            let [at, force, moment] = placed.load(index);
            let load = wrench(&force, &(moment + (at - tool).cross(&force)));
            if bodies.last().is_none_or(|body| body.pose != reading.pose) {
                first_of_pose = bodies.len();
            }
            let held_out = task.held_out[index];
            let known =
                bodies[first_of_pose..].iter().position(|body| body.held_out == held_out && body.is_under(&load));
            let body = match known {
                Some(known) => first_of_pose + known,
                None => {
                    bodies.push(Body { pose: reading.pose, held_out, load, first: index, rows: Vec::new() });
                    bodies.len() - 1
                }
            };
            // d = t + phi x r, and phi itself where it is read.
            let by_turn = -(at - tool).cross_matrix();
            let own = &displacement[index * width..(index + 1) * width];
            for (half, own) in own.chunks(3).enumerate() {
                let d = to_base * Vector3::from_column_slice(own);
                for k in 0..3 {
                    let mut row = [0.0; 6];
                    row[3 * half + k] = 1.0;
                    if half == 0 {
                        (0..3).for_each(|j| row[3 + j] = by_turn[(k, j)]);
                    }
                    bodies[body].rows.push((row, d[k]));
                }
            }
        }
        for body in bodies {
            let Some(found) = body.moved() else {
                let name = campaign.poses.get(body.pose).map_or("", String::as_str);
                return malformed(format!(
                    "rules for several markers need three or more, not on a line, under one load at one point (`load_point`): \
                     configuration `{name}` has not"
                ));
            };
            let to_measurement = to_base.inverse();
            let halves = [0, 3].map(|k| to_measurement * Vector3::new(found[k], found[k + 1], found[k + 2]));
            let displacement: Vec<f64> = halves.iter().flat_map(|half| half.iter().copied()).collect();
            placed.place(body.first)?;
            self.add(task, placed, body.first, body.load, &displacement);
        }
        Ok(())
    }

    /// These samples alone; `held_out` says of each whether it is.
    pub fn only(&self, of: &[usize], held_out: Vec<bool>) -> Self {
        fn chosen<T: Clone>(all: &[T], of: &[usize]) -> Vec<T> {
            of.iter().map(|&k| all[k].clone()).collect()
        }
        let mut samples = Self {
            x: chosen(&self.x, of),
            load: chosen(&self.load, of),
            d: chosen(&self.d, of),
            pose: chosen(&self.pose, of),
            held_out,
            columns: Vec::new(),
            range: Vec::new(),
            ..*self
        };
        samples.survey();
        samples
    }

    /// Loads and ranges among the fitted samples.
    fn survey(&mut self) {
        let fitted = self.indices(false, |_| true);
        let range = |k: usize| extremes(fitted.iter().map(|&sample| self.x[sample][k]));
        self.range = (0..self.x.first().map_or(0, Vec::len)).map(range).collect();
        self.sizes = [0, 3].map(|first| {
            let squares = fitted.iter().flat_map(|&sample| &self.d[sample][first..first + 3]).map(|v| v * v);
            (squares.sum::<f64>() / (3 * fitted.len().max(1)) as f64).sqrt()
        });
        self.columns = (0..6).filter(|&k| fitted.iter().any(|&sample| self.load[sample][k] != 0.0)).collect();
    }

    /// Of each sample among `of` the part of the configurations to which it belongs, of `parts` that are left out in turns:
    /// in order of appearance, so that neighbouring configurations fall into different parts.
    pub fn parts(&self, of: &[usize], parts: usize) -> Vec<usize> {
        let poses: Vec<usize> = distinct(of.iter().map(|&k| self.pose[k]));
        of.iter().map(|&k| poses.partition_point(|pose| *pose < self.pose[k]) % parts.max(1)).collect()
    }

    /// Samples that are fitted (or not) and for which `among` holds.
    pub fn indices(&self, held_out: bool, among: impl Fn(usize) -> bool) -> Vec<usize> {
        (0..self.x.len()).filter(|&k| self.held_out[k] == held_out && among(k)).collect()
    }
}

/// Readings of one configuration under one load.
struct Body {
    pose: usize,
    held_out: bool,
    /// At the tool centre point, base axes.
    load: [f64; 6],
    /// First of its readings.
    first: usize,
    /// Rows of displacement and rotation of the tool, and what was read, base axes.
    rows: Vec<([f64; 6], f64)>,
}

impl Body {
    fn is_under(&self, load: &[f64; 6]) -> bool {
        let size = load.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
        self.load.iter().zip(load).all(|(a, b)| (a - b).abs() <= SAME_LOAD * size)
    }

    /// Displacement and rotation of the tool by least squares; none where the markers do not determine them.
    fn moved(&self) -> Option<DMatrix<f64>> {
        let a = DMatrix::from_fn(self.rows.len(), 6, |i, j| self.rows[i].0[j]);
        let qr = PivotedQr::new(a);
        let right = DMatrix::from_fn(self.rows.len(), 1, |i, _| self.rows[i].1);
        (qr.rank(DEPENDENT) == 6).then(|| qr.solve(6, right))
    }
}

/// Readings placed one after the other.
struct Placed<'a> {
    mechanics: Mechanics<'a>,
    state: State,
    campaign: &'a Campaign,
}

impl Placed<'_> {
    fn place(&mut self, index: usize) -> Result<(), CalibrationError> {
        let q = self.campaign.configuration(index);
        let placed = self.mechanics.place(q, &mut self.state);
        placed.map_err(|source| PredictionError::at(self.campaign, index, source).into())
    }

    /// Where the measured point of the placed reading is, and force and moment on the tool there, base axes.
    fn load(&self, index: usize) -> [Vector3<f64>; 3] {
        let reading = &self.campaign.readings[index];
        let point = self.mechanics.point(&self.state, reading, &reading.wrench);
        [point.position, point.force, point.moment]
    }

    fn tool(&self) -> Vector3<f64> {
        let geometry = &self.mechanics.geometry;
        let tool = geometry.tool().translation.vector;
        (self.state.placements.frames[geometry.model.tool.0] * nalgebra::Point3::from(tool)).coords
    }
}

fn wrench(force: &Vector3<f64>, moment: &Vector3<f64>) -> [f64; 6] {
    [force.x, force.y, force.z, moment.x, moment.y, moment.z]
}
