//! The machine behind a sealed campaign: what it would really show, exactly and not to first order.

use nalgebra::{Point3, Rotation3, Vector3};

use super::shapes::{Shape, Situation};
use crate::description::campaign::Campaign;
use crate::description::raw::JointKind;
use crate::description::robot::Motion;
use crate::elastics::Elastics;
use crate::kinematics::{Geometry, Placements};
use crate::model::Model;
use crate::prediction::PredictionError;
use crate::state::{Loads, Mechanics};

/// Step of differences, rad and m.
const STEP: f64 = 1e-6;
/// Temperature at which lengths hold, degC.
const COLD: f64 = 20.0;
/// By how much of the campaign's length the links lag the temperature measured.
const LAG: f64 = 0.06;

/// A machine: true values of its constants, and causes with their sizes.
#[derive(Debug, Clone)]
pub struct Plant<'m> {
    /// Model.
    pub model: &'m Model,
    /// Values of all constants.
    pub values: Vec<f64>,
    /// Causes: shape, size.
    pub causes: Vec<(Shape, f64)>,
}

/// The joint moved by a variable.
pub fn joint_of(model: &Model, variable: usize) -> usize {
    let own = |frame: &crate::model::Frame| matches!(frame.motion, Motion::Variable { index, .. } if index == variable);
    let driven = || model.actuators.iter().find(|actuator| actuator.variable == variable).map(|a| a.joint);
    model.frames.iter().position(own).or_else(driven).unwrap_or(0)
}

/// Masses: frame, kg, point in it; beams at their middles.
fn masses(model: &Model, values: &[f64]) -> Vec<(usize, f64, Vector3<f64>)> {
    let structure = &model.structure;
    let of = |slot: usize| (values[slot], Vector3::new(values[slot + 1], values[slot + 2], values[slot + 3]));
    let mut all: Vec<(usize, f64, Vector3<f64>)> =
        structure.masses.iter().map(|mass| (mass.frame, of(mass.slot).0, of(mass.slot).1)).collect();
    for (ends, per_length) in Elastics::new(model, values, &[]).masses_per_length() {
        if let Some(frame) = structure.frame_of(*ends) {
            let [a, b] = ends.map(|end| structure.at_home(end));
            let middle = structure.home[frame].inverse() * Point3::from(0.5 * (a + b));
            all.push((frame, per_length * (b - a).norm(), middle.coords));
        }
    }
    all
}

impl Plant<'_> {
    /// The readings of a campaign's plan, without noise. Moments of the plan's wrenches must be zero.
    ///
    /// # Errors
    /// A configuration that cannot be assembled.
    pub fn readings(&self, campaign: &Campaign, sigma: f64) -> Result<Vec<[f64; 3]>, PredictionError> {
        let model = self.model;
        let mut values = self.values.clone();
        let mut gain = 1.0;
        for (shape, size) in &self.causes {
            match shape {
                Shape::Constants(slots) => slots.iter().for_each(|&(slot, share)| values[slot] += size * share),
                Shape::Gain => gain += size,
                _ => {}
            }
        }
        let mut truly = campaign.clone();
        for reading in &mut truly.readings {
            reading.wrench = reading.wrench.map(|w| w * gain);
        }
        let difference = campaign.observes.is_difference();
        let wrench = truly.readings.iter().any(|reading| reading.wrench != [0.0; 6]);
        let mechanics = Mechanics::new(model, &values, Loads { weight: !difference, wrench }, &[])?;
        let mut state = mechanics.state();
        let weights = masses(model, &values);
        let count = model.variables.len();
        let joints: Vec<usize> = (0..count).map(|v| joint_of(model, v)).collect();
        let times = campaign.conditions.time.as_ref();
        let span = times.map_or(1.0, |all| all.iter().copied().fold(1.0, f64::max));
        let mut out = Vec::with_capacity(campaign.readings.len());
        let mut there = Placements::default();
        let greatest = self.greatest(&truly, &values, &weights, &joints)?;
        for (index, reading) in truly.readings.iter().enumerate() {
            let q = truly.configuration(index);
            let time = times.map_or(0.0, |all| all[index] / span);
            let warm = |time: f64| self.temperature(campaign, time * span) - COLD;
            let mut own = values.clone();
            let mut shift = [0.0; 6];
            for (shape, size) in &self.causes {
                if let Shape::Growth(slots) = shape {
                    // The metal follows the air with some delay.
                    let felt = 0.5 * (warm((time - LAG).max(0.0)) + warm((time - 2.0 * LAG).max(0.0)));
                    slots.iter().for_each(|&slot| own[slot] += size * values[slot] * felt);
                }
                if let Some(moved) = shape.wanders(time) {
                    (0..6).for_each(|k| shift[k] += size * moved[k]);
                }
            }
            let geometry = Geometry::new(model, &own)?;
            let marker = reading.marker.unwrap_or(0);
            let (frame, point) = (model.markers[marker].frame, geometry.marker(marker));
            let force = Vector3::new(reading.wrench[0], reading.wrench[1], reading.wrench[2]);
            // The structure's own values stay; frames grow with the temperature.
            let placed = mechanics.place_by(&geometry, q, &mut state);
            placed.map_err(|source| PredictionError::at(campaign, index, source))?;
            let still = &state.placements;
            let at = still.frames[frame] * point;
            let mut loaded = mechanics.point(&state, reading.marker, &reading.wrench);
            loaded.position = at.coords;
            let sag = mechanics.deflection(&state, &loaded).displacement;
            let (rest_load, rates) = loads(&geometry, q, &joints, &weights, None)?;
            let (full_load, _) = loads(&geometry, q, &joints, &weights, Some((frame, point, force)))?;
            let angles: Vec<f64> = joints.iter().map(|&joint| still.joints[joint]).collect();
            let side: Vec<f64> =
                (0..count).map(|v| campaign.conditions.sides(v).map_or(0.0, |all| all[index])).collect();
            let mut position = |load: &[f64], force: Vector3<f64>| -> Result<Vector3<f64>, PredictionError> {
                let situation = Situation { q, joints: &angles, load, greatest: &greatest, side: &side, time };
                let mut turned = q.to_vec();
                for (shape, size) in &self.causes {
                    if let Some((variable, angle)) = shape.turns(&situation) {
                        turned[variable] += size * angle / rates[variable];
                    }
                }
                geometry.place(&turned, &mut there)?;
                let mut at = (there.frames[frame] * point).coords;
                for (shape, size) in &self.causes {
                    let tilt = match shape {
                        Shape::Tilt { frame: pivot, unequal } => {
                            let foot = still.frames[*pivot];
                            let moment = moment_about(still, model, &weights, *pivot, frame, point, force);
                            let local = foot.rotation.inverse() * moment;
                            let turn = Vector3::new(local.x * (1.0 + unequal), local.y * (1.0 - unequal), 0.0);
                            Some((foot.translation.vector, foot.rotation * turn))
                        }
                        Shape::Rocking { shares, more } => {
                            let moment = moment_about(still, model, &weights, 0, frame, point, force);
                            let size = moment.norm().max(1e-9);
                            let turn = Vector3::new(moment.x * shares[0], moment.y * shares[1], 0.0);
                            Some((Vector3::zeros(), turn * (1.0 + more * size / (size + 5e3))))
                        }
                        _ => None,
                    };
                    if let Some((pivot, turn)) = tilt {
                        at += (turn * *size).cross(&(at - pivot));
                    }
                }
                Ok(at)
            };
            let loaded = position(&full_load, force)?;
            let mut moved = sag;
            moved += if difference { loaded - position(&rest_load, Vector3::zeros())? } else { loaded };
            for (shape, size) in &self.causes {
                if let Some(by) = shape.smooth(q, force.norm()) {
                    moved += by * *size;
                }
                if let Shape::Slip { marker, at, by } = shape
                    && reading.marker == Some(*marker)
                    && (if difference { index as f64 / truly.readings.len() as f64 } else { time }) > *at
                {
                    moved += still.frames[frame].rotation * by * *size;
                }
            }
            let base = geometry.base();
            let mut seen = if difference { base.rotation * moved } else { (base * Point3::from(moved)).coords };
            let turn = Rotation3::new(Vector3::new(shift[3], shift[4], shift[5]));
            if !difference {
                let foot = base.translation.vector;
                seen = foot + turn * (seen - foot) + Vector3::new(shift[0], shift[1], shift[2]);
            }
            for (shape, size) in &self.causes {
                match shape {
                    Shape::Scale => seen *= 1.0 + size,
                    Shape::Wrong(which) => {
                        let own = which.iter().filter(|(reading, _)| *reading == index);
                        own.for_each(|(_, by)| seen += by * sigma * *size);
                    }
                    _ => {}
                }
            }
            out.push([seen.x, seen.y, seen.z]);
        }
        Ok(out)
    }

    fn temperature(&self, campaign: &Campaign, time: f64) -> f64 {
        let (Some(all), Some(times)) = (&campaign.conditions.temperature, &campaign.conditions.time) else {
            return COLD;
        };
        // Between the readings' times.
        let after = times.iter().position(|t| *t >= time).unwrap_or(times.len() - 1);
        let before = after.saturating_sub(1);
        let part = ((time - times[before]) / (times[after] - times[before]).max(1e-9)).clamp(0.0, 1.0);
        all[before] * (1.0 - part) + all[after] * part
    }

    /// Greatest load of own weight on the joint of each variable over a campaign, N.m.
    ///
    /// # Errors
    /// A configuration that cannot be assembled.
    pub fn own_loads(&self, campaign: &Campaign) -> Result<Vec<f64>, PredictionError> {
        let mut unloaded = campaign.clone();
        unloaded.readings.iter_mut().for_each(|reading| reading.wrench = [0.0; 6]);
        self.all_loads(&unloaded)
    }

    /// The same under own weight and the applied wrenches.
    ///
    /// # Errors
    /// A configuration that cannot be assembled.
    pub fn all_loads(&self, campaign: &Campaign) -> Result<Vec<f64>, PredictionError> {
        let joints: Vec<usize> = (0..self.model.variables.len()).map(|v| joint_of(self.model, v)).collect();
        self.greatest(campaign, &self.values, &masses(self.model, &self.values), &joints)
    }

    fn greatest(
        &self,
        campaign: &Campaign,
        values: &[f64],
        weights: &[(usize, f64, Vector3<f64>)],
        joints: &[usize],
    ) -> Result<Vec<f64>, PredictionError> {
        let geometry = Geometry::new(self.model, values)?;
        let mut greatest = vec![0.0_f64; joints.len()];
        for (index, reading) in campaign.readings.iter().enumerate() {
            let marker = reading.marker.unwrap_or(0);
            let (frame, point) = (self.model.markers[marker].frame, geometry.marker(marker));
            let force = Vector3::new(reading.wrench[0], reading.wrench[1], reading.wrench[2]);
            let q = campaign.configuration(index);
            let (load, _) = loads(&geometry, q, joints, weights, Some((frame, point, force)))?;
            greatest.iter_mut().zip(load).for_each(|(greatest, load)| *greatest = greatest.max(load.abs()));
        }
        Ok(greatest)
    }
}

/// Loads on the joints of the variables by virtual work, and turn of each joint by its variable.
fn loads(
    geometry: &Geometry,
    q: &[f64],
    joints: &[usize],
    weights: &[(usize, f64, Vector3<f64>)],
    applied: Option<(usize, Point3<f64>, Vector3<f64>)>,
) -> Result<(Vec<f64>, Vec<f64>), PredictionError> {
    let gravity = geometry.model.structure.gravity;
    let (mut low, mut high) = (Placements::default(), Placements::default());
    let (mut loads, mut rates) = (Vec::new(), Vec::new());
    for (variable, &joint) in joints.iter().enumerate() {
        let mut moved = q.to_vec();
        moved[variable] -= STEP;
        geometry.place(&moved, &mut low)?;
        moved[variable] += 2.0 * STEP;
        geometry.place(&moved, &mut high)?;
        let path = |frame: usize, point: Point3<f64>| (high.frames[frame] * point) - (low.frames[frame] * point);
        let mut work: f64 =
            weights.iter().map(|&(frame, mass, at)| mass * path(frame, Point3::from(at)).dot(&gravity)).sum();
        if let Some((frame, point, force)) = applied {
            work += path(frame, point).dot(&force);
        }
        let turn = high.joints[joint] - low.joints[joint];
        loads.push(work / turn);
        rates.push(turn / (2.0 * STEP));
    }
    Ok((loads, rates))
}

/// Moment of all weight after a frame, and of a force at a point, about the frame's origin, base axes.
fn moment_about(
    placements: &Placements,
    model: &Model,
    weights: &[(usize, f64, Vector3<f64>)],
    pivot: usize,
    frame: usize,
    point: Point3<f64>,
    force: Vector3<f64>,
) -> Vector3<f64> {
    let foot = placements.frames[pivot].translation.vector;
    let mut moment = ((placements.frames[frame] * point).coords - foot).cross(&force);
    for &(body, mass, at) in weights {
        if pivot == 0 || body == pivot || model.path(body).contains(&pivot) {
            let arm = (placements.frames[body] * Point3::from(at)).coords - foot;
            moment += arm.cross(&(model.structure.gravity * mass));
        }
    }
    moment
}

/// Lengths of the body that moves with a frame: those of the frames that it carries.
pub fn lengths_of(model: &Model, frame: usize) -> Vec<usize> {
    let carried = model.frames.iter().enumerate().skip(1).filter(|(_, other)| other.antecedent == frame);
    let slots = carried.flat_map(|(_, f)| {
        [2, 4, 6].into_iter().filter(|k| *k != 6 || f.joint != JointKind::Prismatic).map(|k| f.slots[k])
    });
    slots.filter(|&slot| model.registry[slot].nominal.abs() > 1e-3).collect()
}
