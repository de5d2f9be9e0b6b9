//! One point: Newton's steps from the nominal commands until the prediction meets the target.

use nalgebra::{DMatrix, Vector6};

use super::{Desired, Hold, Refusal, Settings};
use crate::kinematics::{Geometry, LeastSteps, Transform, beyond_limits, entered};
use crate::math::linear::singular_values;
use crate::model::Model;
use crate::prediction::{SinglePredictor, SingleWorkspace};

/// Commands that meet a target.
#[derive(Debug, Clone, PartialEq)]
pub struct Corrected {
    /// Commands, rad and m.
    pub joints: Vec<f64>,
    /// Distance from the target that the prediction keeps at them, m.
    pub position: f64,
    /// Angle from what is held of the target's axes, rad.
    pub orientation: f64,
    /// The target less where the point is, m along the base's axes and rad about the target's: what is not held is let go.
    pub off: [f64; 6],
    /// Steps taken.
    pub iterations: usize,
    /// Condition number at the nominal commands: greatest over least singular value, m and rad on levers of 1 m.
    pub condition: f64,
}

/// Finds the commands at which the reading `index`, under a wrench (N and N.m, base axes), is predicted at its target.
///
/// # Errors
/// [`Refusal`].
pub fn correct(
    predictor: &SinglePredictor,
    index: usize,
    desired: &Desired,
    wrench: &[f64; 6],
    settings: &Settings,
    work: &mut SingleWorkspace,
) -> Result<Corrected, Refusal> {
    let model = predictor.geometry().model;
    let mut start = desired.nominal.clone();
    let mut fixed = vec![false; start.len()];
    let point = Point { predictor, index, wrench, target: &desired.target };
    let mut found = point.steered(&start, &fixed, settings, work)?;
    // Where more joints move than are needed, those that would leave their limits stay there, and the others make up for them.
    loop {
        let before = fixed.clone();
        for (k, variable) in model.variables.iter().enumerate() {
            let Some([low, high]) = variable.limits else { continue };
            if !(low..=high).contains(&found.joints[k]) && !fixed[k] {
                (start[k], fixed[k]) = (found.joints[k].clamp(low, high), true);
            }
        }
        if fixed == before {
            break;
        }
        match point.steered(&start, &fixed, settings, work) {
            Ok(again) => found = Corrected { condition: found.condition, ..again },
            Err(_) => break,
        }
    }
    if fixed.contains(&true) {
        predictor.place(&found.joints, work)?;
    }
    within_limits(predictor.geometry(), &found.joints, work)?;
    small_enough(model, &desired.nominal, &found.joints, settings, found.condition)?;
    Ok(found)
}

/// A point under its wrench that is to meet its target.
struct Point<'a> {
    predictor: &'a SinglePredictor<'a>,
    index: usize,
    wrench: &'a [f64; 6],
    target: &'a Transform,
}

impl Point<'_> {
    /// The commands nearest to given ones, of which some are fixed, whatever the limits.
    fn steered(
        &self,
        start: &[f64],
        fixed: &[bool],
        settings: &Settings,
        work: &mut SingleWorkspace,
    ) -> Result<Corrected, Refusal> {
        let Self { predictor, index, wrench, target } = *self;
        let model = predictor.geometry().model;
        let held = Held { hold: settings.hold, target };
        let mut q = start.to_vec();
        let mut trial = q.clone();
        predictor.place(&q, work)?;
        let mut seen = predictor.see(index, wrench, work)?;
        let mut error = held.of(&seen.to(target));
        predictor.differentiate(index, wrench, &seen, false, work);
        let singular = Refusal::Singular { condition: f64::INFINITY };
        let mut steps = Steps::new(model, &held, fixed, &work.jacobian).ok_or(singular.clone())?;
        let condition = steps.condition(&work.jacobian).ok_or(singular.clone())?;
        if condition > settings.worst_condition {
            return Err(Refusal::Singular { condition });
        }
        let sizes = |error: &Vector6<f64>| [0, 3].map(|k| error.fixed_rows::<3>(k).norm());
        let met = |error: &Vector6<f64>| sizes(error).iter().all(|size| *size <= settings.residual);
        let (mut iterations, mut is_new) = (0, false);
        while !met(&error) {
            let (mut share, mut remaining) = (1.0, f64::INFINITY);
            while share > 1e-2 {
                steps.step(&work.jacobian, &error, |k, step| trial[k] = q[k] + share * step);
                // A trial that cannot be assembled is too long a step.
                let reached = predictor.place(&trial, work).and_then(|()| predictor.see(index, wrench, work));
                if let Ok((found, now)) = reached.map(|found| (found, held.of(&found.to(target))))
                    && now.norm() < error.norm()
                {
                    remaining = now.norm() / error.norm();
                    (seen, error) = (found, now);
                    q.copy_from_slice(&trial);
                    break;
                }
                share *= 0.5;
            }
            iterations += 1;
            if iterations == settings.max_steps || remaining.is_infinite() && is_new {
                let [position, orientation] = sizes(&error);
                return Err(Refusal::Stuck { position, orientation, iterations });
            }
            is_new = remaining > settings.slow && !met(&error);
            if is_new {
                predictor.place(&q, work)?;
                seen = if remaining.is_infinite() { predictor.see(index, wrench, work)? } else { seen };
                predictor.differentiate(index, wrench, &seen, true, work);
                steps = Steps::new(model, &held, fixed, &work.jacobian).ok_or(singular.clone())?;
            }
        }
        let [position, orientation] = sizes(&error);
        let off = held.in_its_axes(&seen.to(target)).into();
        Ok(Corrected { joints: q, position, orientation, off, iterations, condition })
    }
}

/// Refuses a correction beyond [`Settings::largest`].
fn small_enough(model: &Model, nominal: &[f64], q: &[f64], settings: &Settings, condition: f64) -> Result<(), Refusal> {
    for (k, variable) in model.variables.iter().enumerate() {
        let moved = (q[k] - nominal[k]).abs();
        if moved > settings.largest * scale(model, k) {
            let by = length_or_angle(moved, variable.is_angle);
            return Err(Refusal::TooFar { variable: variable.name.clone(), by, condition });
        }
    }
    Ok(())
}

/// A value of a variable in mm or deg.
fn length_or_angle(value: f64, is_angle: bool) -> String {
    if is_angle { format!("{:.3} deg", value.to_degrees()) } else { format!("{:.3} mm", value * 1e3) }
}

/// A unit of a variable: 1 rad, or half of what its limits leave it (1 m without).
fn scale(model: &Model, k: usize) -> f64 {
    let variable = &model.variables[k];
    match variable.limits {
        Some([low, high]) if !variable.is_angle && (high - low).is_finite() && high > low => 0.5 * (high - low),
        _ => 1.0,
    }
}

/// Variables, passive joints and boxes to keep out of, at the configuration just placed.
fn within_limits(geometry: &Geometry, q: &[f64], work: &SingleWorkspace) -> Result<(), Refusal> {
    let model = geometry.model;
    let mut beyond = Vec::new();
    for (value, variable) in q.iter().zip(&model.variables) {
        let Some([low, high]) = variable.limits else { continue };
        if !(low..=high).contains(value) {
            let [value, low, high] = [*value, low, high].map(|v| length_or_angle(v, variable.is_angle));
            beyond.push(format!("{} would be {value}, from {low} to {high} are allowed", variable.name));
        }
    }
    beyond.extend(beyond_limits(model, q, &work.state.placements).map(|of| {
        let [value, low, high] = [of.value, of.limits[0], of.limits[1]].map(|v| length_or_angle(v, of.is_angle));
        format!("{} would be {value}, from {low} to {high} are allowed", of.name)
    }));
    beyond.extend(entered(geometry, &work.state.placements).map(|entered| entered.to_string()));
    if beyond.is_empty() { Ok(()) } else { Err(Refusal::Limits(beyond)) }
}

/// What is held of a target: rows of zeros for the rest.
struct Held<'a> {
    hold: Hold,
    target: &'a Transform,
}

impl Held<'_> {
    /// Displacement (base axes) and rotation vector (axes of the target).
    fn in_its_axes(&self, motion: &Vector6<f64>) -> Vector6<f64> {
        let mut turned = *motion;
        let turn = self.target.rotation.inverse() * motion.fixed_rows::<3>(3);
        turned.fixed_rows_mut::<3>(3).copy_from(&turn);
        turned
    }

    /// What is held of the derivatives by the variables, each in its scale.
    fn columns<'c>(
        &'c self,
        jacobian: &'c [[f64; 6]],
        scales: &'c [f64],
    ) -> impl ExactSizeIterator<Item = Vector6<f64>> + Clone + 'c {
        jacobian.iter().zip(scales).map(|(column, scale)| self.of(&Vector6::from(*column)) * *scale)
    }

    /// The same without what is not held.
    fn of(&self, motion: &Vector6<f64>) -> Vector6<f64> {
        self.hold.of_motion(self.in_its_axes(motion))
    }
}

/// Newton's steps at one configuration.
struct Steps<'a> {
    held: &'a Held<'a>,
    scales: Vec<f64>,
    least: LeastSteps,
}

impl<'a> Steps<'a> {
    /// Of the derivatives by the variables that are not fixed; none where these are not finite.
    fn new(model: &Model, held: &'a Held<'a>, fixed: &[bool], jacobian: &[[f64; 6]]) -> Option<Self> {
        let scales: Vec<f64> =
            fixed.iter().enumerate().map(|(k, is_fixed)| if *is_fixed { 0.0 } else { scale(model, k) }).collect();
        let least = LeastSteps::new(held.columns(jacobian, &scales), held.hold.count(), 0.0)?;
        Some(Self { held, scales, least })
    }

    /// Condition number of what is held, by the derivatives of [`Steps::new`]; none where nothing moves.
    fn condition(&self, jacobian: &[[f64; 6]]) -> Option<f64> {
        let all: Vec<Vector6<f64>> = self.held.columns(jacobian, &self.scales).collect();
        let rows: Vec<usize> = (0..6).filter(|&row| self.held.hold.0[row]).collect();
        let values = singular_values(&DMatrix::from_fn(rows.len(), all.len(), |row, k| all[k][rows[row]]))?;
        let [greatest, least] = [*values.first()?, *values.last()?];
        (greatest > 0.0 && greatest.is_finite()).then_some(greatest / least)
    }

    /// The step for an error, variable by variable.
    fn step(&self, jacobian: &[[f64; 6]], error: &Vector6<f64>, mut put: impl FnMut(usize, f64)) {
        let columns = self.held.columns(jacobian, &self.scales);
        self.least.step(columns, error, |k, step| put(k, step * self.scales[k]));
    }
}
