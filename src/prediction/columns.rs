//! Derivatives of predictions: base, robot, tool and markers in the order of the asked slots.

use nalgebra::{Matrix3, Rotation3, Vector3};

use super::reading::{Predicted, ReadingAt};
use crate::description::campaign::Campaign;
use crate::kinematics::{By, Geometry, shift};
use crate::math::left_jacobian;
use crate::model::Model;
use crate::observation::{MeasuredPoint, Observes, PointDerivative, Rows, Twist};
use crate::parameter::{Group, Slot};
use crate::state::{ColumnMotion, FrameTwistPlan, FrameTwists, LoadedPoint, Mechanics, State};

/// Where each asked parameter enters.
pub(super) struct Columns {
    twists: FrameTwistPlan,
    /// The robot's own parameters.
    robot: Vec<RobotColumn>,
    /// Of poses of the base, of tools and markers, and of what readings refer to.
    arrangement: Vec<ArrangementColumn>,
    /// Columns of elastic parameters.
    elastic: Vec<usize>,
}

/// A parameter of the measuring arrangement. It changes the readings whose own it is.
#[derive(Debug, Clone, Copy)]
struct ArrangementColumn {
    column: usize,
    slot: Slot,
}

/// A parameter of the robot's geometry.
#[derive(Debug, Clone, Copy)]
struct RobotColumn {
    column: usize,
    slot: Slot,
    /// As it moves joints.
    driver: Option<usize>,
}

/// Rows of one reading in the derivatives, row-major.
pub(super) struct ReadingRows<'a> {
    pub observes: Observes,
    /// What the instrument shows of a length of one.
    pub scale: f64,
    pub width: usize,
    pub rows: &'a mut [f64],
}

impl ReadingRows<'_> {
    /// Adds to a column how the reading changes with its point.
    pub fn add(&mut self, column: usize, point: &MeasuredPoint, mut by: PointDerivative) {
        by.undeflected.displacement *= self.scale;
        by.deflection.displacement *= self.scale;
        self.put(column, self.observes.derivative(point, &by));
    }

    fn put(&mut self, column: usize, derivative: Rows) {
        for (row, value) in self.rows.chunks_exact_mut(self.width).zip(derivative) {
            row[column] += value;
        }
    }
}

/// The elastic ones among some slots.
pub(super) fn elastic(model: &Model, slots: &[Slot]) -> Vec<usize> {
    (0..slots.len()).filter(|&column| model.registry[slots[column]].group == Group::Elastic).collect()
}

impl Columns {
    /// Columns by `slots`; of `all` frames where the deflection changes with their motion.
    pub fn new(mechanics: &Mechanics, campaign: &Campaign, slots: &[Slot], all: bool) -> Self {
        let geometry = &mechanics.geometry;
        let model = geometry.model;
        let (mut robot, mut arrangement) = (Vec::new(), Vec::new());
        for (column, &slot) in slots.iter().enumerate() {
            match model.registry[slot].group {
                Group::Base | Group::Tool | Group::Arrangement => arrangement.push(ArrangementColumn { column, slot }),
                Group::Geometry => robot.push(RobotColumn { column, slot, driver: mechanics.driver(slot) }),
                Group::Elastic | Group::Effect => {}
            }
        }
        let measured = campaign.readings.iter().filter_map(|reading| reading.marker);
        let frames = if all {
            // Elastic elements sit between all frames: each moves with the parameters.
            (0..model.frames.len()).collect()
        } else {
            std::iter::once(model.tool.0).chain(measured.map(|marker| model.markers[marker].frame)).collect()
        };
        let by: Vec<By> = robot.iter().map(|of| By::Slot(of.slot)).collect();
        Self { twists: mechanics.twist_plan(frames, &by), robot, arrangement, elastic: elastic(model, slots) }
    }

    /// Workspace of the frames' columns.
    pub fn twists(&self) -> FrameTwists {
        self.twists.twists()
    }

    /// Columns of the frames at a placed configuration.
    pub fn evaluate(&self, mechanics: &Mechanics, state: &mut State, out: &mut FrameTwists) {
        mechanics.evaluate_twists(state, &self.twists, None, out);
    }

    /// Derivatives of one reading as its frame, base, tool and marker move; the deflection keeps its axes in the base.
    pub fn by_frames(&self, at: &ReadingAt, twists: &FrameTwists, predicted: &Predicted, rows: &mut ReadingRows) {
        let base = at.base();
        let to_frame = &at.state.placements.frames[at.point.at.frame];
        let arm = to_frame.rotation.matrix() * at.point.at.point;
        // What load turns, it turns after the robot has.
        let after = turned(predicted);
        for (of, moved) in self.robot.iter().zip(twists.of(at.point.at.frame)) {
            let turn = Vector3::new(moved[3], moved[4], moved[5]);
            let by = of_frames(base.rotation * shift(moved, &arm), after * (base.rotation * turn));
            rows.add(of.column, &predicted.point, by);
        }
        self.by_arrangement(at, predicted, rows);
    }

    /// Derivatives by base, tool, marker, scale and target.
    fn by_arrangement(&self, at: &ReadingAt, predicted: &Predicted, rows: &mut ReadingRows) {
        if self.arrangement.is_empty() {
            return;
        }
        let geometry = &at.mechanics.geometry;
        let (model, session, point) = (geometry.model, at.point.session, &predicted.point);
        let own = Own {
            base: model.base_slot(session),
            point: model.point_slot(at.point.marker, session),
            tool: model.tool_slot(session) + 3,
            scale: at.scale_slot(),
            targets: model.target_values(at.reading().target),
        };
        let base = at.base();
        let in_measurement = base.rotation.matrix() * at.state.placements.frames[at.point.at.frame].rotation.matrix();
        let scale = at.scale();
        let from_base = point.undeflected / scale - base.translation.vector;
        for &ArrangementColumn { column, slot } in &self.arrangement {
            if rows.observes.ignores_arrangement() {
                if let Some(k) = own.targets.iter().position(|own| *own == Some(slot)) {
                    rows.put(column, rows.observes.by_target(point, k));
                }
            } else if let Some(k) = offset(slot, own.base, 6) {
                let by = if k < 3 {
                    of_frames(axis(k), Vector3::zeros())
                } else {
                    let turn: Vector3<f64> = left_jacobian(&vector(geometry, own.base + 3)).column(k - 3).into();
                    // The deflection turns with the base: both rotations together turn by as much as it does.
                    let after = turned(predicted) * turn;
                    let deflection = Twist::new(turn.cross(&point.displacement) / scale, turn - after);
                    PointDerivative { undeflected: Twist::new(turn.cross(&from_base), after), deflection }
                };
                rows.add(column, point, by);
            } else if let Some(k) = offset(slot, own.point, 3) {
                rows.add(column, point, of_frames(in_measurement * axis(k), Vector3::zeros()));
            } else if let Some(k) = offset(slot, own.tool, 3) {
                let turn = turned(predicted) * (in_measurement * left_jacobian(&vector(geometry, own.tool)).column(k));
                rows.add(column, point, of_frames(Vector3::zeros(), turn));
            } else if own.scale == Some(slot) {
                let moved = |part: Vector3<f64>| Twist::new(part / scale, Vector3::zeros());
                let by =
                    PointDerivative { undeflected: moved(point.undeflected), deflection: moved(point.displacement) };
                rows.put(column, rows.observes.derivative(point, &by));
            } else if let Some(k) = own.targets.iter().position(|own| *own == Some(slot)) {
                rows.put(column, rows.observes.by_target(point, k));
            }
        }
    }

    /// Adds how the deflection of a point changes with what moves frames and
    /// point. The columns were made for all frames.
    pub fn by_motion(
        &self,
        mechanics: &Mechanics,
        state: &mut State,
        point: &LoadedPoint,
        twists: &FrameTwists,
        predicted: &Predicted,
        rows: &mut ReadingRows,
    ) {
        let turned = state.placements.frames[point.at.frame].rotation;
        let arm = turned.matrix() * point.at.point;
        let to_measurement = DeflectionAxes::new(mechanics, point, predicted);
        for (k, of) in self.robot.iter().enumerate() {
            let moved = shift(&twists.of(point.at.frame)[k], &arm);
            let motion = ColumnMotion { twists, column: k, by: Some(of.slot), driver: of.driver };
            let change = mechanics.deflection_by_motion(state, point, &moved, Some(motion));
            rows.add(of.column, &predicted.point, to_measurement.derivative(&change));
        }
        let own = mechanics.geometry.model.point_slot(point.marker, point.session);
        for &ArrangementColumn { column, slot } in &self.arrangement {
            let Some(k) = offset(slot, own, 3) else { continue };
            let change = mechanics.deflection_by_motion(state, point, &(turned * axis(k)), None);
            rows.add(column, &predicted.point, to_measurement.derivative(&change));
        }
    }

    /// Adds the columns of elastic parameters.
    pub fn by_elastic(
        &self,
        mechanics: &Mechanics,
        state: &mut State,
        point: &LoadedPoint,
        predicted: &Predicted,
        rows: &mut ReadingRows,
    ) {
        let to_measurement = DeflectionAxes::new(mechanics, point, predicted);
        let changes = mechanics.deflection_by_parameters(state, point);
        for (&column, change) in self.elastic.iter().zip(changes) {
            rows.add(column, &predicted.point, to_measurement.derivative(&change));
        }
    }
}

/// What takes a change of the deflection (base axes) to one of the measured point.
struct DeflectionAxes {
    base: Rotation3<f64>,
    jacobian: Matrix3<f64>,
}

impl DeflectionAxes {
    fn new(mechanics: &Mechanics, point: &LoadedPoint, predicted: &Predicted) -> Self {
        let geometry = &mechanics.geometry;
        let base = geometry.placement(geometry.model.base_slot(point.session));
        Self { base: base.rotation, jacobian: left_jacobian(&predicted.turned) }
    }

    fn derivative(&self, change: &Twist) -> PointDerivative {
        let rotation = self.jacobian * (self.base * change.rotation);
        PointDerivative::of_deflection(Twist::new(self.base * change.displacement, rotation))
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

/// Slots that are a reading's own.
struct Own<'a> {
    base: Slot,
    point: Slot,
    tool: Slot,
    scale: Option<Slot>,
    targets: &'a [Option<Slot>],
}

/// Place of a slot among `count` ones from `first`.
fn offset(slot: Slot, first: Slot, count: usize) -> Option<usize> {
    slot.checked_sub(first).filter(|k| *k < count)
}

fn of_frames(displacement: Vector3<f64>, rotation: Vector3<f64>) -> PointDerivative {
    PointDerivative::of_frames(Twist::new(displacement, rotation))
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
