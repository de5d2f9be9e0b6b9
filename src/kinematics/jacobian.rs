//! The error Jacobian: how a frame's pose moves with parameters and variables.
//!
//! Source: elementary twists of the Khalil-Kleinfinger transform (Khalil and Dombre 2002, ch. 11); through loops and
//! actuators by [`Rates`] (implicit differentiation).

use nalgebra::Vector3;

use super::geometry::{Geometry, Placements};
use super::rates::Rates;
use crate::description::raw::JointKind;
use crate::description::robot::FrameIndex;
use crate::model::{R, THETA};
use crate::parameter::Slot;

/// What a column of the Jacobian differentiates by.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum By {
    /// An actuated variable, by index.
    Variable(usize),
    /// A parameter, by slot.
    Slot(Slot),
}

/// Plan of the columns of one frame; made once, evaluated for every configuration without allocating.
#[derive(Debug, Clone)]
pub struct ErrorColumns {
    /// Number of columns.
    pub columns: usize,
    frame: FrameIndex,
    /// Constants on the path: frame, its antecedent, position of the symbol in the transform, column.
    constants: Vec<(FrameIndex, FrameIndex, usize, usize)>,
    /// Joints on the path that move with a driver at a constant rate: joint, column, rate.
    direct: Vec<(FrameIndex, usize, f64)>,
    /// The others: joint, column, driver.
    driven: Vec<(FrameIndex, usize, usize)>,
}

impl ErrorColumns {
    /// Columns of `frame` by variables and parameters. What does not move the frame gives a column of zeros.
    pub fn new(geometry: &Geometry, rates: &Rates, frame: FrameIndex, by: &[By]) -> Self {
        let model = geometry.model;
        let path = model.path(frame);
        let mut plan = Self { columns: by.len(), frame, constants: vec![], direct: vec![], driven: vec![] };
        for (column, by) in by.iter().enumerate() {
            let driver = match *by {
                By::Variable(index) => Some(index),
                By::Slot(slot) => {
                    for &index in &path {
                        let on_path = &model.frames[index];
                        for (symbol, &candidate) in on_path.slots.iter().enumerate() {
                            let moving = on_path.moves() && candidate == on_path.moving_slot();
                            if candidate == slot && !moving {
                                plan.constants.push((index, on_path.antecedent, symbol, column));
                            }
                        }
                    }
                    rates.driver(slot)
                }
            };
            let Some(driver) = driver else { continue };
            for &joint in path.iter().filter(|&&joint| rates.follows(joint, driver)) {
                let on_path = &model.frames[joint];
                match (on_path.motion, *by) {
                    (crate::description::robot::Motion::Variable { direction, .. }, By::Variable(_)) => {
                        plan.direct.push((joint, column, direction));
                    }
                    (crate::description::robot::Motion::Variable { .. }, By::Slot(_)) => {
                        plan.direct.push((joint, column, 1.0))
                    }
                    _ => plan.driven.push((joint, column, driver)),
                }
            }
        }
        plan.constants.sort_unstable();
        plan
    }

    /// Whether [`Rates::evaluate`] must have been called for the configuration.
    pub fn needs_rates(&self) -> bool {
        !self.driven.is_empty()
    }

    /// Columns (displacement of the frame's origin, m; rotation, rad; base axes) per unit of each variable or
    /// parameter (m or rad) at a placed configuration. `rates` must be of that configuration where
    /// [`ErrorColumns::needs_rates`]. `out` has [`ErrorColumns::columns`] entries.
    pub fn evaluate(&self, geometry: &Geometry, placements: &Placements, rates: &Rates, out: &mut [[f64; 6]]) {
        out.fill([0.0; 6]);
        let end = placements.frames[self.frame].translation.vector;
        for &(frame, antecedent, symbol, column) in &self.constants {
            let above = &placements.frames[antecedent];
            let constant = &geometry.constants.frames[frame];
            let origin = above.translation.vector;
            let turned = |axis: Vector3<f64>| above.rotation.matrix() * axis;
            match symbol {
                0 => turn(&mut out[column], above.rotation.matrix().column(1).into_owned(), end - origin, 1.0),
                1 => turn(&mut out[column], turned(constant.z1), end - origin, 1.0),
                2 => slide(&mut out[column], turned(constant.z1), 1.0),
                3 => turn(&mut out[column], turned(constant.x1), end - origin - turned(constant.foot), 1.0),
                4 => slide(&mut out[column], turned(constant.x1), 1.0),
                THETA => turn(
                    &mut out[column],
                    axis(placements, frame),
                    end - placements.frames[frame].translation.vector,
                    1.0,
                ),
                R => slide(&mut out[column], axis(placements, frame), 1.0),
                _ => {}
            }
        }
        for &(joint, column, rate) in &self.direct {
            move_joint(geometry, placements, joint, end, rate, &mut out[column]);
        }
        for &(joint, column, driver) in &self.driven {
            move_joint(geometry, placements, joint, end, rates.rate(joint, driver), &mut out[column]);
        }
    }
}

fn axis(placements: &Placements, frame: FrameIndex) -> Vector3<f64> {
    placements.frames[frame].rotation.matrix().column(2).into_owned()
}

fn move_joint(
    geometry: &Geometry,
    placements: &Placements,
    joint: FrameIndex,
    end: Vector3<f64>,
    rate: f64,
    out: &mut [f64; 6],
) {
    let z = axis(placements, joint);
    match geometry.model.frames[joint].joint {
        JointKind::Prismatic => slide(out, z, rate),
        _ => turn(out, z, end - placements.frames[joint].translation.vector, rate),
    }
}

fn turn(out: &mut [f64; 6], axis: Vector3<f64>, arm: Vector3<f64>, rate: f64) {
    let v = axis.cross(&arm);
    for k in 0..3 {
        out[k] += rate * v[k];
        out[k + 3] += rate * axis[k];
    }
}

fn slide(out: &mut [f64; 6], axis: Vector3<f64>, rate: f64) {
    for k in 0..3 {
        out[k] += rate * axis[k];
    }
}

/// Displacement of a point that moves with a frame, `arm` (base axes, m) away from the frame's origin, from the
/// frame's column.
pub fn shift(column: &[f64; 6], arm: &Vector3<f64>) -> Vector3<f64> {
    let (v, w) = (Vector3::new(column[0], column[1], column[2]), Vector3::new(column[3], column[4], column[5]));
    v + w.cross(arm)
}
