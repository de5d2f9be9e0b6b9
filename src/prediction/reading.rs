//! One reading at a placed state, and what it should be.

use nalgebra::{Point3, Rotation3, Vector3};

use crate::description::campaign::{Campaign, Reading};
use crate::kinematics::{Geometry, Placements, Transform};
use crate::math::rotation_vector;
use crate::model::Model;
use crate::observation::{MOST_TARGET_VALUES, MeasuredPoint, PointDerivative, TargetValues, Twist};
use crate::parameter::Slot;
use crate::state::{LoadedPoint, Mechanics, State};

/// A reading of a campaign at a placed state.
#[derive(Clone, Copy)]
pub(super) struct ReadingAt<'a> {
    pub mechanics: &'a Mechanics<'a>,
    pub state: &'a State,
    pub campaign: &'a Campaign,
    /// Of the reading in the campaign: its conditions.
    pub index: usize,
    /// Its point, under its wrench.
    pub point: &'a LoadedPoint,
}

/// What a reading should be.
#[derive(Debug, Clone, Copy)]
pub(super) struct Predicted {
    /// The measured point, measurement frame.
    pub point: MeasuredPoint,
    /// Rotation vector by which load turns the tool, measurement frame.
    pub turned: Vector3<f64>,
}

impl ReadingAt<'_> {
    pub fn reading(&self) -> &Reading {
        &self.campaign.readings[self.index]
    }

    /// Pose of the base in the measurement frame.
    pub fn base(&self) -> Transform {
        let geometry = &self.mechanics.geometry;
        geometry.placement(geometry.model.base_slot(self.point.session))
    }

    /// Slot of the scale of the instrument, where it is unknown and in the reading.
    pub fn scale_slot(&self) -> Option<Slot> {
        let of_instrument = self.mechanics.geometry.model.scale_slot(self.point.session);
        of_instrument.filter(|_| self.reading().observes.is_scaled())
    }

    /// What the instrument shows of a length of one.
    pub fn scale(&self) -> f64 {
        self.scale_slot().map_or(1.0, |slot| 1.0 + self.mechanics.geometry.values()[slot])
    }

    /// Values of what the reading refers to.
    fn target(&self) -> TargetValues {
        let geometry = &self.mechanics.geometry;
        target_values(geometry.model, self.campaign, self.reading().target, geometry.values())
    }

    /// Prediction with what load does to the point, base axes.
    pub fn predict(&self, deflection: &Twist) -> Predicted {
        let geometry = &self.mechanics.geometry;
        let model = geometry.model;
        let base = self.base();
        let tool = geometry.placement(model.tool_slot(self.point.session));
        let scale = self.scale();
        let in_frame = base * self.state.placements.frames[self.point.at.frame];
        let turned = base.rotation * deflection.rotation;
        let body = Rotation3::new(turned) * in_frame.rotation;
        let point = MeasuredPoint {
            undeflected: scale * (in_frame * Point3::from(self.point.at.point)).coords,
            displacement: scale * (base.rotation * deflection.displacement),
            turned,
            orientation: body * tool.rotation,
            body,
            gravity: base.rotation * model.structure.gravity.try_normalize(0.0).unwrap_or_default(),
            load: self.reading().load,
            measured: self.reading().measured,
            target: self.target(),
        };
        Predicted { point, turned }
    }
}

impl Predicted {
    /// Adds amounts of displacements and rotations (measurement frame).
    pub fn add(&mut self, columns: &[[f64; 6]], amounts: &[f64]) {
        let mut sum = [0.0; 6];
        for (column, amount) in columns.iter().zip(amounts) {
            (0..6).for_each(|k| sum[k] += column[k] * amount);
        }
        let [x, y, z, rx, ry, rz] = sum;
        self.move_by(&Twist::new(Vector3::new(x, y, z), Vector3::new(rx, ry, rz)));
    }

    /// Displaces the point and turns its body, measurement frame.
    pub fn move_by(&mut self, by: &Twist) {
        let turn = Rotation3::new(by.rotation);
        self.point.displacement += by.displacement;
        self.point.turned = rotation_vector(&(turn * Rotation3::new(self.point.turned)));
        self.point.orientation = turn * self.point.orientation;
        self.point.body = turn * self.point.body;
    }
}

/// Displacement and rotation of a column, `[x, y, z, rx, ry, rz]`, as a change of what is added to the undeflected point.
pub(super) fn by_column(column: &[f64; 6]) -> PointDerivative {
    let [x, y, z, rx, ry, rz] = *column;
    PointDerivative::of_deflection(Twist::new(Vector3::new(x, y, z), Vector3::new(rx, ry, rz)))
}

/// The measured point of a reading with nothing deflected, m, base frame.
pub fn undeflected_point(geometry: &Geometry, placements: &Placements, reading: &Reading) -> Point3<f64> {
    let model = geometry.model;
    let frame = reading.marker.map_or(model.tool.0, |marker| model.markers[marker].frame);
    placements.frames[frame] * geometry.point(model.point_slot(reading.marker, reading.session))
}

/// Values of what readings refer to, with these `values` of all parameters (by slot, SI); zeros where there is no such target.
pub fn target_values(
    model: &Model,
    campaign: &Campaign,
    target: impl Into<Option<usize>>,
    values: &[f64],
) -> TargetValues {
    let target = target.into();
    let Some(known) = target.and_then(|target| campaign.targets.get(target)) else { return [0.0; MOST_TARGET_VALUES] };
    let mut own = known.assumed();
    own.iter_mut()
        .zip(model.target_values(target))
        .for_each(|(own, slot)| *own = slot.map_or(*own, |slot| values[slot]));
    own
}

/// The unit normal that a face shares with one before it.
pub fn earlier_normal(model: &Model, campaign: &Campaign, index: usize, values: &[f64]) -> Option<Vector3<f64>> {
    let normal = |target: usize| model.target_values(target).iter().take(3).copied().collect::<Option<Vec<Slot>>>();
    let own = normal(index).filter(|_| campaign.targets[index].is_face())?;
    let is_shared = |other: usize| campaign.targets[other].is_face() && normal(other).as_ref() == Some(&own);
    let is_earlier = (0..index).any(is_shared);
    is_earlier.then(|| Vector3::from_fn(|k, _| values[own[k]])).and_then(|normal| normal.try_normalize(0.0))
}
