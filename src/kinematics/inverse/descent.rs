//! Damped Gauss-Newton steps from one start of the inverse model to the nearest configuration that meets the target.

use nalgebra::{SMatrix, SVector, Vector3};

use super::super::geometry::{Geometry, Placements};
use super::super::jacobian::{By, ErrorColumns, shift};
use super::super::limits::beyond_limits;
use super::super::rates::Rates;
use super::super::rotation_vector;
use super::least_step::LeastSteps;
use super::target::{Hold, Target};
use crate::description::raw::JointKind;
use crate::description::robot::Motion;
use crate::model::Stage;

type Matrix6 = SMatrix<f64, 6, 6>;
type Vector6 = SVector<f64, 6>;

const MAX_STEPS: usize = 120;
/// Squared weighted error below which steps go on only as long as they help.
const MET: f64 = 1e-26;
/// Largest step of a variable, in its scale.
const LARGEST_STEP: f64 = 1.0;

/// A target seen from a robot: everything that does not change from start to start.
pub struct Problem<'a> {
    pub geometry: &'a Geometry<'a>,
    target: &'a Target,
    plan: ErrorColumns,
    rates: Rates,
    /// Length that makes a position error comparable to an angle: about the robot's reach, m.
    pub length: f64,
    /// A unit of each variable: 1 rad, or a length.
    pub scale: Vec<f64>,
    /// Whether a whole turn of the variable leaves every frame in place.
    pub turns: Vec<bool>,
    pub limits: Vec<[f64; 2]>,
}

/// Working memory of one descent.
pub struct Memory {
    pub placements: Placements,
    rates: Rates,
    columns: Vec<[f64; 6]>,
}

/// What keeps the variables in.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Within {
    /// Limits of lengths only: angles are brought back by whole turns afterwards.
    Lengths,
    /// All limits, those of passive joints and of sums included.
    Limits,
    /// Nothing.
    Nothing,
}

/// The target's errors at a configuration.
#[derive(Debug, Clone, Copy)]
pub struct Errors {
    pub position: Vector3<f64>,
    pub orientation: Vector3<f64>,
}

impl<'a> Problem<'a> {
    pub fn new(geometry: &'a Geometry<'a>, target: &'a Target, at: &Placements) -> Self {
        let model = geometry.model;
        let rates = Rates::new(model);
        let by: Vec<By> = (0..model.variables.len()).map(By::Variable).collect();
        let plan = ErrorColumns::new(geometry, &rates, model.tool.0, &by);
        let mut length = geometry.tool().translation.vector.norm();
        for frame in model.path(model.tool.0) {
            let antecedent = at.frames[model.frames[frame].antecedent].translation.vector;
            length += (at.frames[frame].translation.vector - antecedent).norm();
        }
        let length = if length > 0.0 { length } else { 1.0 };
        let limits: Vec<[f64; 2]> = model
            .variables
            .iter()
            .map(|variable| variable.limits.unwrap_or([f64::NEG_INFINITY, f64::INFINITY]))
            .collect();
        let scale = model
            .variables
            .iter()
            .zip(&limits)
            .map(|(variable, [low, high])| {
                let span = high - low;
                match variable.is_angle {
                    true => 1.0,
                    false if span.is_finite() && span > 0.0 => 0.5 * span,
                    false => length,
                }
            })
            .collect();
        Self { geometry, target, plan, rates, length, scale, turns: whole_turns(geometry), limits }
    }

    pub fn memory(&self) -> Memory {
        Memory {
            placements: Placements::default(),
            rates: self.rates.clone(),
            columns: vec![[0.0; 6]; self.plan.columns],
        }
    }

    /// Errors at a configuration; none where the mechanism cannot be put together.
    pub fn errors(&self, q: &[f64], memory: &mut Memory) -> Option<Errors> {
        self.geometry.place(q, &mut memory.placements).ok()?;
        let end = memory.placements.frames[self.geometry.model.tool.0] * self.geometry.tool();
        let position = self.target.position.coords - end.translation.vector;
        let orientation = match &self.target.rotation {
            Some(rotation) => rotation_vector(&(rotation * end.rotation.inverse())),
            None => Vector3::zeros(),
        };
        let mut errors = Errors { position, orientation };
        if self.target.hold != Hold::POSE {
            let held = self.held(&errors.weighted(1.0));
            errors = Errors { position: held.fixed_rows::<3>(0).into(), orientation: held.fixed_rows::<3>(3).into() };
        }
        errors.weighted(self.length).norm_squared().is_finite().then_some(errors)
    }

    /// A motion in base axes, its rotation to the target's, without what the target lets go.
    fn held(&self, motion: &Vector6) -> Vector6 {
        let mut held = *motion;
        if let Some(rotation) = &self.target.rotation {
            held.fixed_rows_mut::<3>(3).copy_from(&(rotation.inverse() * motion.fixed_rows::<3>(3)));
        }
        self.target.hold.of_motion(held)
    }

    /// Derivatives of the weighted errors, reversed, by the scaled variables, at the configuration just placed.
    fn jacobian(&self, q: &[f64], memory: &mut Memory) {
        let Memory { placements, rates, columns } = memory;
        if self.plan.needs_rates() {
            rates.evaluate(self.geometry, q, placements);
        }
        self.plan.evaluate(self.geometry, placements, rates, columns);
        let frame = &placements.frames[self.geometry.model.tool.0];
        let arm = frame.rotation * self.geometry.tool().translation.vector;
        for (column, scale) in columns.iter_mut().zip(&self.scale) {
            let moved = shift(column, &arm) * (scale / self.length);
            column[..3].copy_from_slice(moved.as_slice());
            for turned in &mut column[3..] {
                *turned *= if self.target.rotation.is_some() { *scale } else { 0.0 };
            }
            if self.target.hold != Hold::POSE {
                let held = self.held(&Vector6::from_column_slice(column));
                column.copy_from_slice(held.as_slice());
            }
            if column.iter().any(|value| !value.is_finite()) {
                *column = [0.0; 6]; // exactly at a loop's singularity: this variable waits
            }
        }
    }

    /// Number of independent motions of the variables that leave the target met, to first order.
    pub fn self_motions(&self, q: &[f64], memory: &mut Memory) -> usize {
        if self.errors(q, memory).is_none() {
            return 0;
        }
        self.jacobian(q, memory);
        let mut gram = Matrix6::zeros();
        for column in &memory.columns {
            let column = Vector6::from_column_slice(column);
            gram += column * column.transpose();
        }
        let values = gram.symmetric_eigenvalues();
        let largest = values.max();
        memory.columns.len() - values.iter().filter(|&&value| value > 1e-12 * largest).count().min(q.len())
    }

    fn box_of(&self, k: usize, within: Within) -> [f64; 2] {
        match within {
            Within::Lengths if !self.turns[k] => self.limits[k],
            Within::Limits => self.limits[k],
            _ => [f64::NEG_INFINITY, f64::INFINITY],
        }
    }

    /// Whether the joints that no variable moves directly, and sums of joints, keep their limits at the configuration just
    /// placed. Boxes to keep out of do not steer the steps: an arm may have to pass through one on its way to a solution.
    pub fn passive_within(&self, q: &[f64], placements: &Placements) -> bool {
        beyond_limits(self.geometry.model, q, placements).next().is_none()
    }

    /// A variable at its limit that should go further stays.
    fn hold_at_limits(&self, q: &[f64], within: Within, memory: &mut Memory, slope: impl Fn(&[f64; 6]) -> f64) {
        for (k, (value, column)) in q.iter().zip(&mut memory.columns).enumerate() {
            let [low, high] = self.box_of(k, within);
            let slope = slope(column);
            if *value <= low && slope < 0.0 || *value >= high && slope > 0.0 {
                *column = [0.0; 6];
            }
        }
    }

    /// Levenberg's steps from `q`, in place; the errors where they end. None where `q` cannot be placed.
    pub fn descend(&self, q: &mut [f64], within: Within, memory: &mut Memory) -> Option<Errors> {
        for (k, value) in q.iter_mut().enumerate() {
            let [low, high] = self.box_of(k, within);
            *value = value.max(low).min(high);
        }
        let mut errors = self.errors(q, memory)?;
        let mut inside = within != Within::Limits || self.passive_within(q, &memory.placements);
        let mut merit = errors.weighted(self.length).norm_squared();
        let mut damping = 1e-1;
        let mut trial = q.to_vec();
        for _ in 0..MAX_STEPS {
            self.errors(q, memory)?;
            self.jacobian(q, memory);
            let f = errors.weighted(self.length);
            let slope = |column: &[f64; 6]| Vector6::from_column_slice(column).dot(&f);
            self.hold_at_limits(q, within, memory, slope);
            let steepest = memory.columns.iter().map(|column| slope(column).powi(2)).sum::<f64>().sqrt();
            if steepest <= 1e-9 * merit.sqrt() * f64::min(1.0, merit.sqrt() * 1e3) || merit == 0.0 {
                break;
            }
            let mut improved = false;
            for _ in 0..30 {
                let Some(step) = damped(&memory.columns, &f, damping * merit) else {
                    damping = 10.0 * damping + 1e-6;
                    continue;
                };
                let largest = step.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
                let shorter = f64::min(1.0, LARGEST_STEP / largest.max(f64::MIN_POSITIVE));
                for (k, step) in step.iter().enumerate() {
                    let [low, high] = self.box_of(k, within);
                    trial[k] = (q[k] + shorter * step * self.scale[k]).max(low).min(high);
                }
                if let Some(found) = self.errors(&trial, memory) {
                    let fits = within != Within::Limits || self.passive_within(&trial, &memory.placements);
                    let reached = found.weighted(self.length).norm_squared();
                    if reached < merit && (fits || !inside) {
                        improved = merit > MET || reached < 0.5 * merit;
                        (merit, errors, inside) = (reached, found, fits);
                        q.copy_from_slice(&trial);
                        damping = f64::max(0.2 * damping, 1e-8);
                        break;
                    }
                }
                if merit < MET || largest < 1e-15 {
                    break;
                }
                damping *= 5.0;
            }
            if !improved {
                break;
            }
        }
        Some(errors)
    }
}

impl Errors {
    /// Position in units of `length`, orientation in rad.
    pub fn weighted(&self, length: f64) -> Vector6 {
        let (p, w) = (self.position / length, self.orientation);
        Vector6::new(p.x, p.y, p.z, w.x, w.y, w.z)
    }
}

/// A damped step for the errors; `None` where that cannot be computed.
fn damped(columns: &[[f64; 6]], f: &Vector6, damping: f64) -> Option<Vec<f64>> {
    let all = || columns.iter().map(|column| Vector6::from_column_slice(column));
    let mut step = vec![0.0; columns.len()];
    LeastSteps::new(all(), 6, damping)?.step(all(), f, |k, value| step[k] = value);
    Some(step)
}

/// Which variables may turn by whole turns without moving anything: every revolute joint that follows one follows it by
/// a whole number, and no prismatic joint follows it.
fn whole_turns(geometry: &Geometry) -> Vec<bool> {
    let model = geometry.model;
    let whole = |variable: usize| {
        // Turns of each joint per turn of the variable; of a joint in a loop, some whole number, written 1.
        let mut turns = vec![0.0; model.frames.len()];
        for (joint, frame) in model.frames.iter().enumerate() {
            if let Motion::Variable { index, direction } = frame.motion
                && index == variable
            {
                turns[joint] = direction;
            }
        }
        for stage in &model.stages {
            match stage {
                Stage::Actuator(which) => {
                    if model.actuators[*which].variable == variable {
                        return false;
                    }
                }
                Stage::Coupling(which, joint) => {
                    let terms: Vec<f64> =
                        model.couplings[*which].iter().map(|(factor, other)| factor * turns[*other]).collect();
                    if terms.iter().any(|term| term.fract() != 0.0) {
                        return false;
                    }
                    turns[*joint] = f64::from(u8::from(terms.iter().any(|term| *term != 0.0)));
                }
                Stage::Loops(group) => {
                    if group.inputs.iter().any(|&joint| turns[joint] != 0.0) {
                        group.unknowns.iter().for_each(|&joint| turns[joint] = 1.0);
                    }
                }
            }
        }
        model.frames.iter().zip(&turns).all(|(frame, &turns)| {
            let slides = frame.joint == JointKind::Prismatic;
            turns == 0.0 || !slides || frame.motion == Motion::Passive
        })
    };
    (0..model.variables.len()).map(|variable| model.variables[variable].is_angle && whole(variable)).collect()
}
