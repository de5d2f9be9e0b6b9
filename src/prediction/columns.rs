//! Derivatives of predictions: base, robot, tool and markers in the order of the asked slots.

use nalgebra::{Matrix3, Rotation3, Vector3};

use super::{Deflected, Predicted, measured_point};
use crate::description::campaign::{Campaign, Reading};
use crate::elements::Motion;
use crate::kinematics::{By, ErrorColumns, Geometry, Placements, Rates, shift};
use crate::math::left_jacobian;
use crate::observation::{MeasuredPoint, Observes, PointDerivative, Twist};
use crate::parameter::{Group, Slot};

/// Where each asked parameter enters.
pub struct Columns {
    observes: Observes,
    /// For each measured frame: its plan.
    plans: Vec<(usize, ErrorColumns)>,
    /// Columns of the robot's own parameters, and their slots.
    robot: Vec<usize>,
    slots: Vec<Slot>,
    /// Component of the base's pose, column.
    base: Vec<(usize, usize)>,
    /// Component of the tool's pose, column.
    tool: Vec<(usize, usize)>,
    /// Marker, component, column.
    markers: Vec<(usize, usize, usize)>,
    base_jacobian: Matrix3<f64>,
    tool_jacobian: Matrix3<f64>,
}

impl Columns {
    pub fn new(geometry: &Geometry, pattern: &Rates, campaign: &Campaign, slots: &[Slot], all: bool) -> Self {
        let model = geometry.model;
        let mut columns = Self {
            observes: campaign.observes,
            plans: Vec::new(),
            robot: Vec::new(),
            slots: Vec::new(),
            base: Vec::new(),
            tool: Vec::new(),
            markers: Vec::new(),
            base_jacobian: left_jacobian(&vector(geometry, model.base + 3)),
            tool_jacobian: left_jacobian(&vector(geometry, model.tool.1 + 3)),
        };
        let mut by = Vec::new();
        for (column, &slot) in slots.iter().enumerate() {
            match model.registry[slot].group {
                Group::Base => columns.base.push((slot - model.base, column)),
                Group::Tool if (model.tool.1..model.tool.1 + 6).contains(&slot) => {
                    columns.tool.push((slot - model.tool.1, column));
                }
                Group::Tool => {
                    let marker = model.markers.iter().position(|marker| (marker.slot..marker.slot + 3).contains(&slot));
                    columns.markers.extend(marker.map(|m| (m, slot - model.markers[m].slot, column)));
                }
                Group::Geometry => {
                    columns.robot.push(column);
                    columns.slots.push(slot);
                    by.push(By::Slot(slot));
                }
                Group::Elastic | Group::Effect => {}
            }
        }
        let mut frames = vec![model.tool.0];
        frames.extend(
            campaign.readings.iter().filter_map(|reading| reading.marker).map(|marker| model.markers[marker].frame),
        );
        if all {
            // What gives sits between all frames: each moves with the parameters.
            frames = (0..model.frames.len()).collect();
        }
        frames.sort_unstable();
        frames.dedup();
        columns.plans =
            frames.into_iter().map(|frame| (frame, ErrorColumns::new(geometry, pattern, frame, &by))).collect();
        columns
    }

    /// Room for the columns of each measured frame.
    pub fn buffers(&self) -> Vec<Vec<[f64; 6]>> {
        self.plans.iter().map(|_| vec![[0.0; 6]; self.robot.len()]).collect()
    }

    /// Columns of each measured frame at a placed configuration.
    pub fn evaluate(
        &self,
        geometry: &Geometry,
        q: &[f64],
        placements: &Placements,
        rates: &mut Rates,
        out: &mut [Vec<[f64; 6]>],
    ) {
        if self.plans.iter().any(|(_, plan)| plan.needs_rates()) {
            rates.evaluate(geometry, q, placements);
        }
        for ((_, plan), out) in self.plans.iter().zip(out) {
            plan.evaluate(geometry, placements, rates, out);
        }
    }

    /// Adds to column `column` of the rows of one reading how it changes with its point.
    pub fn put(&self, column: usize, point: &MeasuredPoint, by: PointDerivative, width: usize, rows: &mut [f64]) {
        let derivative = self.observes.derivative(point, &by);
        for (row, value) in rows.chunks_exact_mut(width).zip(derivative) {
            row[column] += value;
        }
    }

    /// Rows of one reading, row-major of the given width.
    #[allow(clippy::too_many_arguments)] // one call site, inside the prediction's inner loop
    pub fn rows(
        &self,
        geometry: &Geometry,
        placements: &Placements,
        frames: &[Vec<[f64; 6]>],
        reading: &Reading,
        predicted: &Predicted,
        width: usize,
        rows: &mut [f64],
    ) {
        rows.fill(0.0);
        let (frame, point) = measured_point(geometry, reading);
        let base = geometry.base();
        let to_frame = &placements.frames[frame];
        let in_measurement = base.rotation.matrix() * to_frame.rotation.matrix();
        let arm = to_frame.rotation.matrix() * point.coords;
        let mut put = |column: usize, by: PointDerivative| self.put(column, &predicted.point, by, width, rows);
        let of_frames = |displacement: Vector3<f64>, rotation: Vector3<f64>| {
            PointDerivative::of_frames(Twist::new(displacement, rotation))
        };
        // What load turns, it turns after the robot has.
        let after = turned(predicted);
        let plan = self.plans.iter().position(|(planned, _)| *planned == frame).unwrap_or(0);
        for (&column, moved) in self.robot.iter().zip(&frames[plan]) {
            let turn = Vector3::new(moved[3], moved[4], moved[5]);
            put(column, of_frames(base.rotation * shift(moved, &arm), after * (base.rotation * turn)));
        }
        let from_base = predicted.point.undeflected - base.translation.vector;
        for &(k, column) in &self.base {
            match k {
                0..=2 => put(column, of_frames(axis(k), Vector3::zeros())),
                _ => {
                    let turn = self.base_jacobian.column(k - 3).into_owned();
                    // The deflection turns with the base.
                    let deflection = Twist::new(turn.cross(&predicted.point.displacement), Vector3::zeros());
                    put(column, PointDerivative { undeflected: Twist::new(turn.cross(&from_base), turn), deflection });
                }
            }
        }
        for &(k, column) in &self.tool {
            match k {
                0..=2 if reading.marker.is_none() => put(column, of_frames(in_measurement * axis(k), Vector3::zeros())),
                3.. => {
                    let turn = after * (in_measurement * self.tool_jacobian.column(k - 3));
                    put(column, of_frames(Vector3::zeros(), turn));
                }
                _ => {}
            }
        }
        for &(marker, k, column) in &self.markers {
            if reading.marker == Some(marker) {
                put(column, of_frames(in_measurement * axis(k), Vector3::zeros()));
            }
        }
    }
}

impl Columns {
    /// Adds to the rows of one reading how its deflection changes with what moves frames and point. The columns were
    /// planned for all frames.
    #[allow(clippy::too_many_arguments)] // one call site, inside the prediction's inner loop
    pub fn with_motion(
        &self,
        geometry: &Geometry,
        placements: &Placements,
        rates: &Rates,
        frames: &[Vec<[f64; 6]>],
        reading: &Reading,
        predicted: &Predicted,
        mut change: impl FnMut(&Vector3<f64>, Option<(usize, &Motion)>) -> Deflected,
        width: usize,
        rows: &mut [f64],
    ) {
        let (frame, point) = measured_point(geometry, reading);
        let turned = placements.frames[frame].rotation;
        let arm = turned.matrix() * point.coords;
        let base = geometry.base().rotation;
        let jacobian = left_jacobian(&predicted.turned);
        let mut put = |column: usize, changed: Deflected| {
            let by = Twist::new(base * changed.displacement, jacobian * (base * changed.rotation));
            self.put(column, &predicted.point, PointDerivative::of_deflection(by), width, rows);
        };
        for (k, &column) in self.robot.iter().enumerate() {
            let own = &frames[frame][k];
            let moved = shift(own, &arm);
            let driver = rates.driver(self.slots[k]);
            let joints = |joint| driver.map_or(0.0, |driver| rates.rate(joint, driver));
            let motion = Motion { by: Some(self.slots[k]), frames: &|frame| frames[frame][k], joints: &joints };
            put(column, change(&moved, Some((k, &motion))));
        }
        let tool = self.tool.iter().filter(|(k, _)| *k < 3 && reading.marker.is_none()).copied();
        let markers = self.markers.iter().filter(|(marker, _, _)| reading.marker == Some(*marker));
        for (k, column) in tool.chain(markers.map(|&(_, k, column)| (k, column))) {
            put(column, change(&(turned * axis(k)), None));
        }
    }

    /// Adds the columns of elastic parameters to the rows of one reading.
    pub fn deflected(
        &self,
        geometry: &Geometry,
        by: impl Iterator<Item = (usize, Deflected)>,
        predicted: &Predicted,
        width: usize,
        rows: &mut [f64],
    ) {
        let base = geometry.base().rotation;
        let jacobian = left_jacobian(&predicted.turned);
        for (column, change) in by {
            let by = Twist::new(base * change.displacement, jacobian * (base * change.rotation));
            self.put(column, &predicted.point, PointDerivative::of_deflection(by), width, rows);
        }
    }
}

/// The turn by load.
fn turned(predicted: &Predicted) -> Matrix3<f64> {
    if predicted.turned == Vector3::zeros() {
        Matrix3::identity()
    } else {
        Rotation3::new(predicted.turned).into_inner()
    }
}

fn axis(k: usize) -> Vector3<f64> {
    let mut axis = Vector3::zeros();
    axis[k] = 1.0;
    axis
}

fn vector(geometry: &Geometry, slot: Slot) -> Vector3<f64> {
    let values = geometry.values();
    Vector3::new(values[slot], values[slot + 1], values[slot + 2])
}
