//! What single readings should be at any configuration, and how they change with the variables: what the inverse of the
//! calibrated robot asks over and over, where there is no campaign to compare with.

use nalgebra::{Matrix6, Point3, Rotation3, Translation3, Vector3, Vector6};

use super::deflection::{Deflected, Deflections, Work};
use super::terms::{Declared, TermWork, Terms, amounts_of, declared};
use super::{measured_point, predict, rest};
use crate::description::campaign::{Campaign, Reading};
use crate::elastics::Mechanism;
use crate::elements::Motion;
use crate::kinematics::{AssemblyError, By, ErrorColumns, Geometry, Placements, Rates, Transform, shift};
use crate::math::left_jacobian;
use crate::model::Model;

/// Predictions of the readings of a campaign (its configurations left aside) as poses in the robot's base frame, with
/// load, own weight and the effects that the model has switched on. Effects of the measurement are left out: no command
/// corrects them. Immutable, shared between threads.
#[derive(Debug, Clone)]
pub struct SinglePredictor<'a> {
    /// The model with its values, shifts by effects included.
    pub geometry: Geometry<'a>,
    /// Markers, wrenches and conditions of the readings.
    pub campaign: &'a Campaign,
    /// Names of the effects left out, as `effect@site`.
    pub left_out: Vec<String>,
    deflections: Deflections<'a>,
    terms: Terms,
    amounts: Vec<f64>,
    pattern: Rates,
    /// For each frame: its columns by the variables.
    plans: Vec<ErrorColumns>,
    to_base: Transform,
}

/// Room for one thread.
#[derive(Debug, Clone)]
pub struct SingleWork {
    /// Frames and joints as placed.
    pub placements: Placements,
    /// Displacement (m) and rotation (rad) of the reading's point, base axes, by each variable; of the last call of
    /// [`SinglePredictor::differentiate`].
    pub jacobian: Vec<[f64; 6]>,
    q: Vec<f64>,
    rates: Rates,
    loaded: Work,
    added: TermWork,
    columns: Vec<Vec<[f64; 6]>>,
}

/// A reading's point as predicted; axes are the tool's.
#[derive(Debug, Clone, Copy)]
pub struct Seen {
    /// Where it really is, base frame.
    pub real: Transform,
    /// Where it would be with nothing deflected and no effects, base frame.
    pub rigid: Transform,
    /// Displacement by own weight and preloads, m, base axes.
    pub by_weight: Vector3<f64>,
    /// Displacement by the wrench, m, base axes.
    pub by_wrench: Vector3<f64>,
    /// Rotation vector by all loads, rad, base axes.
    turned: Vector3<f64>,
}

/// Why a reading cannot be predicted at a configuration.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SingleError {
    /// A loop or actuator cannot close.
    #[error(transparent)]
    Assembly(#[from] AssemblyError),
    /// The structure can move without force.
    #[error(transparent)]
    Mechanism(#[from] Mechanism),
    /// The wrench is too great.
    #[error("the deflection is not finite; the wrench is too great")]
    TooGreat,
}

impl<'a> SinglePredictor<'a> {
    /// Predictions by `model` with `values` (all slots, SI) of the readings of `campaign`, which must hold
    /// absolute readings.
    ///
    /// # Errors
    /// The loops cannot be assembled with these values.
    pub fn new(model: &'a Model, values: &[f64], campaign: &'a Campaign) -> Result<Self, AssemblyError> {
        let Declared { terms: all, amounts: slots, shifts } = declared(model);
        let all_amounts = amounts_of(&slots, values);
        let mut values = values.to_vec();
        shifts.iter().for_each(|&(slot, amount)| values[slot] += amount);
        let (mut terms, mut amounts, mut left_out) = (Vec::new(), Vec::new(), Vec::new());
        let mut first = 0;
        for term in all {
            let own = first..first + term.parameters.len();
            first = own.end;
            if term.effect.is_of_the_measurement() {
                left_out.push(format!("{}@{}", term.effect.name(), term.site.name));
            } else {
                amounts.extend_from_slice(&all_amounts[own]);
                terms.push(term);
            }
        }
        let geometry = Geometry::new(model, &values)?;
        let pattern = Rates::new(model);
        let deflections = Deflections::new(model, &values, campaign, &[]).under_any_wrench();
        let terms = Terms::new(&geometry, &pattern, campaign, terms);
        let by: Vec<By> = (0..model.variables.len()).map(By::Variable).collect();
        let plans = (0..model.frames.len()).map(|frame| ErrorColumns::new(&geometry, &pattern, frame, &by)).collect();
        let to_base = geometry.base().inverse();
        Ok(Self { geometry, campaign, left_out, deflections, terms, amounts, pattern, plans, to_base })
    }

    /// Room for one thread.
    pub fn work(&self) -> SingleWork {
        let variables = self.geometry.model.variables.len();
        SingleWork {
            placements: Placements::default(),
            jacobian: vec![[0.0; 6]; variables],
            q: vec![0.0; variables],
            rates: self.pattern.clone(),
            loaded: self.deflections.work(),
            added: self.terms.work(),
            columns: vec![vec![[0.0; 6]; variables]; self.plans.len()],
        }
    }

    /// Puts the robot at the variables `q` (rad and m).
    ///
    /// # Errors
    /// What cannot be assembled, or can move without force.
    pub fn place(&self, q: &[f64], work: &mut SingleWork) -> Result<(), SingleError> {
        self.geometry.place(q, &mut work.placements)?;
        self.deflections.place(&self.geometry, q, &work.placements, &mut work.loaded)?;
        work.q.copy_from_slice(q);
        if self.terms.columns > 0 {
            self.terms.place(&self.geometry, q, &work.placements, &mut work.rates, &mut work.added);
        }
        Ok(())
    }

    fn reading(&self, index: usize, wrench: &[f64; 6]) -> Reading {
        Reading { wrench: *wrench, ..self.campaign.readings[index] }
    }

    /// A reading at the placed configuration under a wrench (N and N.m, base axes).
    ///
    /// # Errors
    /// [`SingleError::TooGreat`].
    pub fn see(&self, index: usize, wrench: &[f64; 6], work: &mut SingleWork) -> Result<Seen, SingleError> {
        let reading = self.reading(index, wrench);
        let point = rest(&self.geometry, &work.placements, &reading);
        let deflected = self.deflections.of(&work.loaded, &reading, &point);
        let by_wrench = self.deflections.by_wrench(&work.loaded, &reading, &point);
        let mut predicted = predict(&self.geometry, self.campaign, &work.placements, &reading, &deflected);
        if self.terms.columns > 0 {
            self.terms.evaluate(
                &self.geometry,
                self.campaign,
                index,
                &reading,
                &work.q,
                &work.placements,
                &work.rates,
                &by_wrench,
                &mut work.added,
            );
            predicted.add(&work.added.columns, &self.amounts);
        }
        if !predicted.point.position().norm().is_finite() {
            return Err(SingleError::TooGreat);
        }
        let (frame, _) = measured_point(&self.geometry, &reading);
        let axes = work.placements.frames[frame].rotation * self.geometry.tool().rotation;
        Ok(Seen {
            real: self.to_base
                * Transform::from_parts(Translation3::from(predicted.point.position()), predicted.point.orientation),
            rigid: Transform::from_parts(Translation3::from(point.coords), axes),
            by_weight: deflected.displacement - by_wrench,
            by_wrench,
            turned: deflected.rotation,
        })
    }

    /// Derivatives by the variables, into [`SingleWork::jacobian`], of a reading just seen under the same wrench: of its
    /// rigid pose, and, if `elastic`, of its deflection too. Effects are taken to go along with the point.
    pub fn differentiate(&self, index: usize, wrench: &[f64; 6], seen: &Seen, elastic: bool, work: &mut SingleWork) {
        let reading = self.reading(index, wrench);
        let (measured, local) = measured_point(&self.geometry, &reading);
        let elastic = elastic && self.deflections.is_active();
        let needed = |frame: usize| elastic || frame == measured;
        if self.terms.columns == 0
            && self.plans.iter().enumerate().any(|(frame, plan)| needed(frame) && plan.needs_rates())
        {
            work.rates.evaluate(&self.geometry, &work.q, &work.placements);
        }
        for (frame, plan) in self.plans.iter().enumerate().filter(|(frame, _)| needed(*frame)) {
            plan.evaluate(&self.geometry, &work.placements, &work.rates, &mut work.columns[frame]);
        }
        let arm = work.placements.frames[measured].rotation * local.coords;
        let point = Point3::from(seen.rigid.translation.vector);
        if elastic {
            self.deflections.prepare_motion(&mut work.loaded);
        }
        let (after, jacobian) = (Rotation3::new(seen.turned), left_jacobian(&seen.turned));
        for variable in 0..work.jacobian.len() {
            let column = work.columns[measured][variable];
            let mut moved = shift(&column, &arm);
            let mut turn = after * Vector3::new(column[3], column[4], column[5]);
            if elastic {
                let SingleWork { placements, rates, loaded, columns, .. } = &mut *work;
                let frames = |frame: usize| columns[frame][variable];
                let joints = |joint: usize| rates.rate(joint, variable);
                let motion = Motion { by: None, frames: &frames, joints: &joints };
                let change: Deflected =
                    self.deflections.by_motion(loaded, placements, &reading, &point, &moved, Some((variable, &motion)));
                moved += change.displacement;
                turn += jacobian * change.rotation;
            }
            work.jacobian[variable] = [moved.x, moved.y, moved.z, turn.x, turn.y, turn.z];
        }
    }

    /// Displacement and rotation of a reading's point by force and moment there, base axes, at the placed configuration.
    pub fn compliance(&self, index: usize, work: &SingleWork) -> Matrix6<f64> {
        let reading = &self.campaign.readings[index];
        self.deflections.compliance(&work.loaded, reading, &rest(&self.geometry, &work.placements, reading))
    }
}

impl Seen {
    /// Displacement of the point by effects, m, base axes.
    pub fn by_effects(&self) -> Vector3<f64> {
        self.real.translation.vector - self.rigid.translation.vector - self.by_weight - self.by_wrench
    }

    /// Displacement and rotation vector that bring the point to a pose, base axes.
    pub fn to(&self, target: &Transform) -> Vector6<f64> {
        let moved = target.translation.vector - self.real.translation.vector;
        let turn = crate::kinematics::rotation_vector(&(target.rotation * self.real.rotation.inverse()));
        Vector6::new(moved.x, moved.y, moved.z, turn.x, turn.y, turn.z)
    }
}
