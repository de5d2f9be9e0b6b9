//! The machine behind a sealed campaign: what it would really show, exactly and not to first order. Positions in m,
//! measurement frame; loads in N and N.m, base axes.

use nalgebra::{Point3, Rotation3, Vector3};

use super::loads::{Applied, JointLoads, Weights};
use super::shapes::Shape;
use super::situation::Situation;
use crate::description::campaign::{Campaign, Reading};
use crate::kinematics::{Geometry, Placements};
use crate::model::Model;
use crate::prediction::PredictionError;
use crate::state::{Loads, Mechanics, State};

/// Temperature at which lengths hold, degC.
const COLD: f64 = 20.0;
/// By how much of the campaign's length the links lag the temperature measured.
const LAG: f64 = 0.06;
/// Moment at which the foot has half of the compliance that great moments add, N.m.
const ROCKING_MOMENT: f64 = 5e3;

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

impl Plant<'_> {
    /// The readings of a campaign's plan, without noise. Moments of the plan's wrenches must be zero.
    ///
    /// # Errors
    /// A configuration that cannot be assembled.
    pub fn readings(&self, campaign: &Campaign, sigma: f64) -> Result<Vec<[f64; 3]>, PredictionError> {
        let (values, campaign) = self.changed(campaign);
        let wrench = campaign.readings.iter().any(Reading::is_loaded);
        let loads = Loads { weight: !campaign.is_difference(), wrench };
        let weights = Weights::new(self.model, &values);
        let times = campaign.conditions.time.as_ref();
        let machine = Machine {
            plant: self,
            values: &values,
            campaign: &campaign,
            mechanics: Mechanics::new(self.model, &values, loads, &[])?,
            greatest: weights.greatest(&Geometry::new(self.model, &values)?, &campaign)?,
            weights,
            span: times.map_or(1.0, |all| all.iter().copied().fold(1.0, f64::max)),
        };
        let mut state = machine.mechanics.state();
        (0..campaign.readings.len()).map(|index| machine.reading(index, sigma, &mut state)).collect()
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
        let geometry = Geometry::new(self.model, &self.values)?;
        Ok(Weights::new(self.model, &self.values).greatest(&geometry, campaign)?)
    }

    /// Constants with the causes that change them, and the campaign with the wrenches that are really applied.
    fn changed(&self, campaign: &Campaign) -> (Vec<f64>, Campaign) {
        let (mut values, mut campaign, mut gain) = (self.values.clone(), campaign.clone(), 1.0);
        for (shape, size) in &self.causes {
            match shape {
                Shape::Constants(slots) => slots.iter().for_each(|&(slot, share)| values[slot] += size * share),
                Shape::Gain => gain += size,
                _ => {}
            }
        }
        campaign.readings.iter_mut().for_each(|reading| reading.wrench = reading.wrench.map(|w| w * gain));
        (values, campaign)
    }
}

/// A plant with what its readings share.
struct Machine<'a> {
    plant: &'a Plant<'a>,
    values: &'a [f64],
    campaign: &'a Campaign,
    mechanics: Mechanics<'a>,
    weights: Weights,
    /// Greatest load on the joint of each variable.
    greatest: Vec<f64>,
    /// Length of the campaign, s.
    span: f64,
}

/// A configuration of the machine, without the causes that turn joints.
struct Placed<'a> {
    geometry: &'a Geometry<'a>,
    placements: &'a Placements,
    q: &'a [f64],
    /// Of the joints of the variables, rad.
    angles: Vec<f64>,
    /// Side of approach of each variable.
    side: Vec<f64>,
    /// Move of each variable from the configuration before.
    last_move: Vec<f64>,
    /// Turn of each joint by its variable.
    rates: Vec<f64>,
    /// Share of the campaign's length.
    time: f64,
}

impl Machine<'_> {
    fn reading(&self, index: usize, sigma: f64, state: &mut State) -> Result<[f64; 3], PredictionError> {
        let (reading, q) = (&self.campaign.readings[index], self.campaign.configuration(index));
        let time = self.campaign.conditions.time.as_ref().map_or(0.0, |all| all[index] / self.span);
        let values = self.warm_values(time);
        let geometry = Geometry::new(self.plant.model, &values)?;
        let applied = Applied::of(&geometry, reading);
        // The structure's own values stay; frames grow with the temperature.
        let result = self.mechanics.place_by(&geometry, q, state);
        result.map_err(|source| PredictionError::at(self.campaign, index, source))?;
        let placements = &state.placements;
        let mut point = self.mechanics.point(state, reading.marker, &reading.wrench);
        point.position = (placements.frames[applied.frame] * applied.point).coords;
        let mut moved = self.mechanics.deflection(state, &point).displacement;
        let JointLoads { loads: own_loads, rates } = self.weights.loads(&geometry, q, None)?;
        let JointLoads { loads, .. } = self.weights.loads(&geometry, q, Some(applied))?;
        let sides = |v: usize| self.campaign.conditions.sides(v).map_or(0.0, |all| all[index]);
        let last_move = &self.campaign.conditions.last_move;
        let moves = |v: usize| last_move.get(v).map(|all| all[index]).filter(|moved| moved.is_finite()).unwrap_or(0.0);
        let placed = Placed {
            geometry: &geometry,
            placements,
            q,
            angles: self.weights.joints.iter().map(|&joint| placements.joints[joint]).collect(),
            side: (0..self.weights.joints.len()).map(sides).collect(),
            last_move: (0..self.weights.joints.len()).map(moves).collect(),
            rates,
            time,
        };
        let loaded = self.position(&placed, &loads, &applied)?;
        let unloaded = Applied { force: Vector3::zeros(), ..applied };
        let is_difference = self.campaign.is_difference();
        moved += if is_difference { loaded - self.position(&placed, &own_loads, &unloaded)? } else { loaded };
        self.displace(index, &placed, &applied, &mut moved);
        Ok(self.shown(index, &geometry, moved, time, sigma))
    }

    /// Constants with the lengths of links as warm as they are.
    fn warm_values(&self, time: f64) -> Vec<f64> {
        let mut values = self.values.to_vec();
        let warm = |time: f64| self.temperature(time * self.span) - COLD;
        for (shape, size) in &self.plant.causes {
            if let Shape::Growth(slots) = shape {
                // The metal follows the air with some delay.
                let felt = 0.5 * (warm((time - LAG).max(0.0)) + warm((time - 2.0 * LAG).max(0.0)));
                slots.iter().for_each(|&slot| values[slot] += size * self.values[slot] * felt);
            }
        }
        values
    }

    /// Temperature at a time (s), between those of the readings.
    fn temperature(&self, time: f64) -> f64 {
        let conditions = &self.campaign.conditions;
        let (Some(all), Some(times)) = (&conditions.temperature, &conditions.time) else { return COLD };
        let after = times.iter().position(|t| *t >= time).unwrap_or(times.len() - 1);
        let before = after.saturating_sub(1);
        let part = ((time - times[before]) / (times[after] - times[before]).max(1e-9)).clamp(0.0, 1.0);
        all[before] * (1.0 - part) + all[after] * part
    }

    /// The point under loads on the joints and a force, base frame, with joints and bodies as the causes turn them.
    fn position(&self, placed: &Placed, load: &[f64], applied: &Applied) -> Result<Vector3<f64>, PredictionError> {
        let Placed { q, angles, side, last_move, time, .. } = placed;
        let situation = Situation { q, joints: angles, load, greatest: &self.greatest, side, last_move, time: *time };
        let mut turned = q.to_vec();
        for (shape, size) in &self.plant.causes {
            if let Some((variable, angle)) = shape.turns(&situation) {
                turned[variable] += size * angle / placed.rates[variable];
            }
        }
        let mut placements = Placements::default();
        placed.geometry.place(&turned, &mut placements)?;
        let mut at = (placements.frames[applied.frame] * applied.point).coords;
        for (shape, size) in &self.plant.causes {
            if let Some((pivot, turn)) = self.tilt(shape, placed.placements, applied) {
                at += (turn * *size).cross(&(at - pivot));
            }
        }
        Ok(at)
    }

    /// By what a unit of a shape tilts the bodies after a frame: pivot, and rotation vector.
    fn tilt(&self, shape: &Shape, placed: &Placements, applied: &Applied) -> Option<(Vector3<f64>, Vector3<f64>)> {
        let moment = |pivot: usize| self.weights.moment_about(self.plant.model, placed, pivot, applied);
        match shape {
            Shape::Tilt { frame, unequal } => {
                let foot = placed.frames[*frame];
                let local = foot.rotation.inverse() * moment(*frame);
                let turn = Vector3::new(local.x * (1.0 + unequal), local.y * (1.0 - unequal), 0.0);
                Some((foot.translation.vector, foot.rotation * turn))
            }
            Shape::Rocking { shares, more } => {
                let moment = moment(0);
                let size = moment.norm().max(1e-9);
                let turn = Vector3::new(moment.x * shares[0], moment.y * shares[1], 0.0);
                Some((Vector3::zeros(), turn * (1.0 + more * size / (size + ROCKING_MOMENT))))
            }
            _ => None,
        }
    }

    /// Displaces the point (base frame) by the causes that no joint and no body carries.
    fn displace(&self, index: usize, placed: &Placed, applied: &Applied, moved: &mut Vector3<f64>) {
        let share = index as f64 / self.campaign.readings.len() as f64;
        let time = if self.campaign.is_difference() { share } else { placed.time };
        let Reading { marker: measured, .. } = self.campaign.readings[index];
        for (shape, size) in &self.plant.causes {
            if let Some(by) = shape.smooth(placed.q, applied.force.norm()) {
                *moved += by * *size;
            }
            if let Shape::Odd(odd) = shape
                && let Some(by) = odd.pushes(&placed.last_move)
            {
                *moved += by * *size;
            }
            if let Shape::Slip { marker, at, by } = shape
                && measured.unwrap_or(0) == *marker
                && time > *at
            {
                *moved += placed.placements.frames[applied.frame].rotation * by * *size;
            }
        }
    }

    /// What the instrument shows of a point or a difference of points (base frame).
    fn shown(&self, index: usize, geometry: &Geometry, moved: Vector3<f64>, time: f64, sigma: f64) -> [f64; 3] {
        let base = geometry.base();
        let mut shown = if self.campaign.is_difference() {
            base.rotation * moved
        } else {
            let mut shift = [0.0; 6];
            for (shape, size) in &self.plant.causes {
                if let Some(wandered) = shape.wanders(time) {
                    (0..6).for_each(|k| shift[k] += size * wandered[k]);
                }
            }
            let foot = base.translation.vector;
            let turn = Rotation3::new(Vector3::new(shift[3], shift[4], shift[5]));
            let seen = (base * Point3::from(moved)).coords;
            foot + turn * (seen - foot) + Vector3::new(shift[0], shift[1], shift[2])
        };
        for (shape, size) in &self.plant.causes {
            match shape {
                Shape::Scale => shown *= 1.0 + size,
                Shape::Odd(odd) => {
                    let share = index as f64 / self.campaign.readings.len() as f64;
                    if let Some(by) = odd.shows(share, &shown) {
                        shown += by * *size;
                    }
                }
                Shape::Outliers(which) => {
                    let own = which.iter().filter(|(reading, _)| *reading == index);
                    own.for_each(|(_, by)| shown += by * sigma * *size);
                }
                _ => {}
            }
        }
        [shown.x, shown.y, shown.z]
    }
}
