//! Derivatives of predictions: base, robot, tool and markers in the order of the asked slots.

use nalgebra::{Matrix3, Rotation3, Vector3};

use super::reading::{Predicted, ReadingAt};
use crate::description::campaign::Campaign;
use crate::kinematics::{By, Geometry, shift};
use crate::math::left_jacobian;
use crate::model::Model;
use crate::observation::{MeasuredPoint, Observes, PointDerivative, Twist};
use crate::parameter::{Group, Slot};
use crate::state::{ColumnMotion, FrameTwistPlan, FrameTwists, LoadedPoint, Mechanics, State};

/// Where each asked parameter enters.
pub(super) struct Columns {
    twists: FrameTwistPlan,
    /// The robot's own parameters.
    robot: Vec<RobotColumn>,
    /// Component of the base's pose, column.
    base: Vec<(usize, usize)>,
    /// Component of the tool's pose, column.
    tool: Vec<(usize, usize)>,
    /// Marker, component, column.
    markers: Vec<(usize, usize, usize)>,
    /// Columns of elastic parameters.
    elastic: Vec<usize>,
    base_jacobian: Matrix3<f64>,
    tool_jacobian: Matrix3<f64>,
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
    pub width: usize,
    pub rows: &'a mut [f64],
}

impl ReadingRows<'_> {
    /// Adds to a column how the reading changes with its point.
    pub fn add(&mut self, column: usize, point: &MeasuredPoint, by: PointDerivative) {
        let derivative = self.observes.derivative(point, &by);
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
        let (mut robot, mut base, mut tool, mut markers) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        for (column, &slot) in slots.iter().enumerate() {
            match model.registry[slot].group {
                Group::Base => base.push((slot - model.base, column)),
                Group::Tool if (model.tool.1..model.tool.1 + 6).contains(&slot) => {
                    tool.push((slot - model.tool.1, column));
                }
                Group::Tool => {
                    let marker = model.markers.iter().position(|marker| (marker.slot..marker.slot + 3).contains(&slot));
                    markers.extend(marker.map(|m| (m, slot - model.markers[m].slot, column)));
                }
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
        Self {
            twists: mechanics.twist_plan(frames, &by),
            robot,
            base,
            tool,
            markers,
            elastic: elastic(model, slots),
            base_jacobian: left_jacobian(&vector(geometry, model.base + 3)),
            tool_jacobian: left_jacobian(&vector(geometry, model.tool.1 + 3)),
        }
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
        let geometry = &at.mechanics.geometry;
        let (base, marker) = (geometry.base(), at.point.marker);
        let to_frame = &at.state.placements.frames[at.point.at.frame];
        let in_measurement = base.rotation.matrix() * to_frame.rotation.matrix();
        let arm = to_frame.rotation.matrix() * at.point.at.point;
        let mut put = |column: usize, by: PointDerivative| rows.add(column, &predicted.point, by);
        let of_frames = |displacement: Vector3<f64>, rotation: Vector3<f64>| {
            PointDerivative::of_frames(Twist::new(displacement, rotation))
        };
        // What load turns, it turns after the robot has.
        let after = turned(predicted);
        for (of, moved) in self.robot.iter().zip(twists.of(at.point.at.frame)) {
            let turn = Vector3::new(moved[3], moved[4], moved[5]);
            put(of.column, of_frames(base.rotation * shift(moved, &arm), after * (base.rotation * turn)));
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
                0..=2 if marker.is_none() => put(column, of_frames(in_measurement * axis(k), Vector3::zeros())),
                3.. => {
                    let turn = after * (in_measurement * self.tool_jacobian.column(k - 3));
                    put(column, of_frames(Vector3::zeros(), turn));
                }
                _ => {}
            }
        }
        for &(own, k, column) in &self.markers {
            if marker == Some(own) {
                put(column, of_frames(in_measurement * axis(k), Vector3::zeros()));
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
        let to_measurement = DeflectionAxes::new(mechanics, predicted);
        for (k, of) in self.robot.iter().enumerate() {
            let moved = shift(&twists.of(point.at.frame)[k], &arm);
            let motion = ColumnMotion { twists, column: k, by: Some(of.slot), driver: of.driver };
            let change = mechanics.deflection_by_motion(state, point, &moved, Some(motion));
            rows.add(of.column, &predicted.point, to_measurement.derivative(&change));
        }
        let tool = self.tool.iter().filter(|(k, _)| *k < 3 && point.marker.is_none()).copied();
        let markers = self.markers.iter().filter(|(own, _, _)| point.marker == Some(*own));
        for (k, column) in tool.chain(markers.map(|&(_, k, column)| (k, column))) {
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
        let to_measurement = DeflectionAxes::new(mechanics, predicted);
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
    fn new(mechanics: &Mechanics, predicted: &Predicted) -> Self {
        Self { base: mechanics.geometry.base().rotation, jacobian: left_jacobian(&predicted.turned) }
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

fn axis(k: usize) -> Vector3<f64> {
    let mut axis = Vector3::zeros();
    axis[k] = 1.0;
    axis
}

fn vector(geometry: &Geometry, slot: Slot) -> Vector3<f64> {
    let values = geometry.values();
    Vector3::new(values[slot], values[slot + 1], values[slot + 2])
}
