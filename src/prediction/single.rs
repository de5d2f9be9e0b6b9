//! What single readings should be at any configuration, and how they change with the variables: what the inverse of the
//! calibrated robot asks over and over, where there is no campaign to compare with.

use nalgebra::{Matrix6, Rotation3, Translation3, Vector3, Vector6};

use super::reading::ReadingAt;
use super::terms::{Declared, TermWorkspace, Terms, amounts_of, declared};
use crate::description::campaign::Campaign;
use crate::elastics::{Elastics, PointLoad, deflection_at_rest, equilibrium};
use crate::kinematics::{AssemblyError, By, Geometry, Transform, rotation_vector, shift};
use crate::math::left_jacobian;
use crate::model::Model;
use crate::state::{ColumnMotion, FrameTwistPlan, FrameTwists, LoadedPoint, Loads, Mechanics, State, StateError};

/// Predictions of the readings of a campaign (its configurations do not count) as poses in the robot's base frame, with
/// load, own weight and the effects that the model has switched on. Effects of the measurement are left out: no command
/// corrects them. Immutable, shared between threads.
#[derive(Debug, Clone)]
pub struct SinglePredictor<'a> {
    /// Markers, wrenches and conditions of the readings; it observes poses.
    pub campaign: &'a Campaign,
    /// Names of the effects left out, as `effect@site`.
    pub left_out: Vec<String>,
    /// The model with its values, shifts by effects included.
    mechanics: Mechanics<'a>,
    terms: Terms,
    amounts: Vec<f64>,
    /// How all frames move with the variables.
    twists: FrameTwistPlan,
    to_base: Transform,
    at_equilibrium: bool,
}

/// Workspace for one thread.
#[derive(Debug, Clone)]
pub struct SingleWorkspace {
    /// The placed configuration.
    pub state: State,
    /// Displacement (m) and rotation (rad) of the reading's point, base axes, by each variable; of the last call of
    /// [`SinglePredictor::differentiate`].
    pub jacobian: Vec<[f64; 6]>,
    terms: TermWorkspace,
    twists: FrameTwists,
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
    /// The configuration cannot be placed.
    #[error(transparent)]
    State(#[from] StateError),
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
            if term.effect.is_of_the_measurement(&term.site) {
                left_out.push(format!("{}@{}", term.effect.name(), term.site.name));
            } else {
                amounts.extend_from_slice(&all_amounts[own]);
                terms.push(term);
            }
        }
        let mechanics = Mechanics::new(model, &values, Loads { weight: true, wrench: true }, &[])?;
        let terms = Terms::new(&mechanics, campaign, terms);
        let by: Vec<By> = (0..model.variables.len()).map(By::Variable).collect();
        let twists = mechanics.twist_plan((0..model.frames.len()).collect(), &by);
        let to_base = mechanics.geometry.base().inverse();
        let at_equilibrium = false;
        Ok(Self { campaign, left_out, mechanics, terms, amounts, twists, to_base, at_equilibrium })
    }

    /// The same with deflections of the equilibrium at the deflected pose in place of the linear ones. The model has no fuzzy
    /// compliance, which is linear.
    #[must_use]
    pub fn at_equilibrium(self) -> Self {
        Self { at_equilibrium: true, ..self }
    }

    /// The model with its values, shifts by effects included.
    pub fn geometry(&self) -> &Geometry<'a> {
        &self.mechanics.geometry
    }

    /// Workspace for one thread.
    pub fn workspace(&self) -> SingleWorkspace {
        SingleWorkspace {
            state: self.mechanics.state(),
            jacobian: vec![[0.0; 6]; self.geometry().model.variables.len()],
            terms: self.terms.workspace(),
            twists: self.twists.twists(),
        }
    }

    /// Puts the robot at the variables `q` (rad and m).
    ///
    /// # Errors
    /// What cannot be assembled, or can move without force.
    pub fn place(&self, q: &[f64], workspace: &mut SingleWorkspace) -> Result<(), SingleError> {
        self.mechanics.place(q, &mut workspace.state)?;
        if self.terms.columns > 0 {
            self.terms.place(&self.mechanics, &mut workspace.state, &mut workspace.terms);
        }
        Ok(())
    }

    fn point(&self, index: usize, wrench: &[f64; 6], state: &State) -> LoadedPoint {
        self.mechanics.point(state, &self.campaign.readings[index], wrench)
    }

    /// A reading at the placed configuration under a wrench (N and N.m, base axes).
    ///
    /// # Errors
    /// [`SingleError::TooGreat`].
    pub fn see(&self, index: usize, wrench: &[f64; 6], workspace: &mut SingleWorkspace) -> Result<Seen, SingleError> {
        let SingleWorkspace { state, terms, .. } = workspace;
        let state: &State = state;
        let (mechanics, geometry) = (&self.mechanics, self.geometry());
        let point = self.point(index, wrench, state);
        let deflection = mechanics.deflection(state, &point);
        let by_wrench = mechanics.deflection_by_wrench(state, &point).displacement;
        let at = ReadingAt { mechanics, state, campaign: self.campaign, index, point: &point };
        let mut predicted = at.predict(&deflection);
        if self.terms.columns > 0 {
            self.terms.evaluate(&at, terms);
            predicted.add(&terms.columns, &self.amounts);
        }
        let (position, orientation) = (predicted.point.position(), predicted.point.orientation);
        if !position.norm().is_finite() {
            return Err(SingleError::TooGreat);
        }
        let axes = state.placements.frames[point.at.frame].rotation * geometry.tool().rotation;
        let seen = Seen {
            real: self.to_base * Transform::from_parts(Translation3::from(position), orientation),
            rigid: Transform::from_parts(Translation3::from(point.position), axes),
            by_weight: deflection.displacement - by_wrench,
            by_wrench,
            turned: deflection.rotation,
        };
        if !self.at_equilibrium {
            return Ok(seen);
        }
        let found = equilibrium(&self.elastics(), &state.placements, &self.load(index, wrench, state), true);
        let found = found.map_err(StateError::Mechanism)?;
        let more = found.displacement - (seen.by_weight + seen.by_wrench);
        let [from, to] = [seen.turned, found.rotation].map(Rotation3::new);
        let (position, turned) = (seen.real.translation.vector + more, to * from.inverse() * seen.real.rotation);
        // The difference counts as the wrench's, if there is one.
        let loaded = wrench.iter().any(|w| *w != 0.0);
        Ok(Seen {
            real: Transform::from_parts(position.into(), turned),
            by_weight: if loaded { seen.by_weight } else { seen.by_weight + more },
            by_wrench: if loaded { seen.by_wrench + more } else { seen.by_wrench },
            turned: found.rotation,
            ..seen
        })
    }

    /// The structure with the values of the model.
    fn elastics(&self) -> Elastics<'_> {
        Elastics::new(self.geometry().model, self.geometry().values(), &[])
    }

    /// A wrench on the point of a reading, as the equilibrium at the deflected pose takes it.
    fn load(&self, index: usize, wrench: &[f64; 6], state: &State) -> PointLoad {
        let loaded = self.point(index, wrench, state);
        let vertex = self.geometry().model.structure.carrier(loaded.at.frame, &loaded.at.point);
        let (force, moment) = loaded.here();
        PointLoad { elsewhere: loaded.elsewhere(), ..PointLoad::at(vertex, loaded.position, force, moment) }
    }

    /// How far (m) the linear deflection of a reading is off that of the equilibrium at the deflected pose, at the placed
    /// configuration under a wrench; 0 of a predictor that finds that anyway, and of one that does not deflect.
    ///
    /// # Errors
    /// No equilibrium is found.
    pub fn linear_error(
        &self,
        index: usize,
        wrench: &[f64; 6],
        work: &mut SingleWorkspace,
    ) -> Result<f64, SingleError> {
        let seen = self.see(index, wrench, work)?;
        if self.at_equilibrium || !self.mechanics.deflects() {
            return Ok(0.0);
        }
        let load = self.load(index, wrench, &work.state);
        let found = deflection_at_rest(&self.elastics(), &work.state.placements, &load, true);
        let [displacement, _] = found.map_err(StateError::Mechanism)?;
        Ok((displacement - (seen.by_weight + seen.by_wrench)).norm())
    }

    /// Derivatives by the variables, into [`SingleWorkspace::jacobian`], of a reading just seen under the same wrench: of
    /// its rigid pose, and, if `elastic`, of its deflection too. Effects are taken to go along with the point.
    pub fn differentiate(
        &self,
        index: usize,
        wrench: &[f64; 6],
        seen: &Seen,
        elastic: bool,
        workspace: &mut SingleWorkspace,
    ) {
        let SingleWorkspace { state, jacobian, twists, .. } = workspace;
        let point = self.point(index, wrench, state);
        let elastic = elastic && self.mechanics.deflects();
        let only = (!elastic).then_some(point.at.frame);
        self.mechanics.evaluate_twists(state, &self.twists, only, twists);
        let arm = state.placements.frames[point.at.frame].rotation * point.at.point;
        let (after, by_turn) = (Rotation3::new(seen.turned), left_jacobian(&seen.turned));
        for (variable, out) in jacobian.iter_mut().enumerate() {
            let column = twists.of(point.at.frame)[variable];
            let mut moved = shift(&column, &arm);
            let mut turn = after * Vector3::new(column[3], column[4], column[5]);
            if elastic {
                let motion = ColumnMotion { twists, column: variable, by: None, driver: Some(variable) };
                let change = self.mechanics.deflection_by_motion(state, &point, &moved, Some(motion));
                moved += change.displacement;
                turn += by_turn * change.rotation;
            }
            *out = [moved.x, moved.y, moved.z, turn.x, turn.y, turn.z];
        }
    }

    /// Displacement and rotation of a reading's point by force and moment there, base axes, at the placed configuration.
    pub fn compliance(&self, index: usize, workspace: &SingleWorkspace) -> Matrix6<f64> {
        let point = self.point(index, &self.campaign.readings[index].wrench, &workspace.state);
        self.mechanics.compliance(&workspace.state, &point)
    }
}

impl Seen {
    /// Displacement of the point by effects, m, base axes.
    pub fn by_effects(&self) -> Vector3<f64> {
        self.real.translation.vector - self.rigid.translation.vector - self.by_weight - self.by_wrench
    }

    /// Displacement (m) and rotation vector (rad) of the point by own weight, preloads and the wrench, base axes.
    pub fn deflection(&self) -> [f64; 6] {
        let (d, r) = (self.by_weight + self.by_wrench, self.turned);
        [d.x, d.y, d.z, r.x, r.y, r.z]
    }

    /// Displacement and rotation vector that bring the point to a pose, base axes.
    pub fn to(&self, target: &Transform) -> Vector6<f64> {
        let moved = target.translation.vector - self.real.translation.vector;
        let turn = rotation_vector(&(target.rotation * self.real.rotation.inverse()));
        Vector6::new(moved.x, moved.y, moved.z, turn.x, turn.y, turn.z)
    }
}
