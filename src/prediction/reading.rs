//! One reading at a placed state, and what it should be.

use nalgebra::{Point3, Rotation3, Vector3};

use crate::description::campaign::{Campaign, Reading};
use crate::kinematics::{Geometry, Placements};
use crate::observation::{MeasuredPoint, PointDerivative, Twist};
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

    /// Prediction with what load does to the point, base axes.
    pub fn predict(&self, deflection: &Twist) -> Predicted {
        let geometry = &self.mechanics.geometry;
        let base = geometry.base();
        let in_frame = base * self.state.placements.frames[self.point.at.frame];
        let turned = base.rotation * deflection.rotation;
        let point = MeasuredPoint {
            undeflected: (in_frame * Point3::from(self.point.at.point)).coords,
            displacement: base.rotation * deflection.displacement,
            orientation: Rotation3::new(turned) * in_frame.rotation * geometry.tool().rotation,
            anchor: self.campaign.anchor(self.reading()),
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
        self.point.displacement += Vector3::new(sum[0], sum[1], sum[2]);
        self.point.orientation = Rotation3::new(Vector3::new(sum[3], sum[4], sum[5])) * self.point.orientation;
    }
}

/// Displacement and rotation of a column, `[x, y, z, rx, ry, rz]`, as a change of what is added to the undeflected point.
pub(super) fn by_column(column: &[f64; 6]) -> PointDerivative {
    let [x, y, z, rx, ry, rz] = *column;
    PointDerivative::of_deflection(Twist::new(Vector3::new(x, y, z), Vector3::new(rx, ry, rz)))
}

/// The measured point of a reading with nothing deflected, m, base frame.
pub fn undeflected_point(geometry: &Geometry, placements: &Placements, reading: &Reading) -> Point3<f64> {
    let (frame, point) = match reading.marker {
        Some(marker) => (geometry.model.markers[marker].frame, geometry.marker(marker)),
        None => (geometry.model.tool.0, geometry.tool().translation.vector.into()),
    };
    placements.frames[frame] * point
}
