//! Where the base, the tool and the markers are, the robot's geometry being given: the start of every calibration and
//! its baseline.

use std::collections::BTreeSet;

use nalgebra::{Matrix3, Point3, Rotation3, UnitQuaternion, Vector3};

use super::settings::RegistrationSettings;
use crate::description::campaign::Campaign;
use crate::kinematics::{Geometry, Placements, Transform, rotation_vector};
use crate::model::Model;
use crate::parameter::Slot;
use crate::prediction::PredictionError;

/// Slots of the measuring arrangement the campaign asks to estimate.
pub fn arrangement(model: &Model, campaign: &Campaign) -> Vec<Slot> {
    let mut slots: Vec<Slot> = Vec::new();
    if campaign.estimate_base {
        slots.extend(model.base..model.base + 6);
    }
    if campaign.estimate_tool {
        if campaign.readings.iter().any(|reading| reading.marker.is_none()) {
            slots.extend(model.tool.1..model.tool.1 + if campaign.observes.sees_orientation() { 6 } else { 3 });
        }
        let used = |marker: usize| campaign.readings.iter().any(|reading| reading.marker == Some(marker));
        slots.extend((0..model.markers.len()).filter(|&m| used(m)).flat_map(|m| {
            let slot = model.markers[m].slot;
            slot..slot + 3
        }));
    }
    slots
}

/// A start for base, tool and markers, from the readings alone: best rigid fit of the base (Kabsch) and linear fit of
/// the points, in turns. Where the campaign does not estimate the base, the values are returned as given.
///
/// # Errors
/// A configuration that cannot be assembled.
pub fn rough(
    model: &Model,
    campaign: &Campaign,
    values: &[f64],
    settings: &RegistrationSettings,
) -> Result<Vec<f64>, PredictionError> {
    let mut values = values.to_vec();
    let positions = campaign.readings.iter().map(|reading| campaign.observes.measured_position(&reading.measured));
    let Some(measured) = positions.collect::<Option<Vec<Vector3<f64>>>>().filter(|_| campaign.estimate_base) else {
        return Ok(values);
    };
    let frames = frames(model, campaign, &values)?;
    let point_slot = |marker: Option<usize>| marker.map_or(model.tool.1, |m| model.markers[m].slot);
    let markers: BTreeSet<Option<usize>> = campaign.readings.iter().map(|reading| reading.marker).collect();
    for _ in 0..if campaign.estimate_tool { settings.turns } else { 1 } {
        let placed = campaign.readings.iter().zip(&frames);
        let points =
            placed.map(|(reading, frame)| (frame * Point3::from(at(&values, point_slot(reading.marker)))).coords);
        let (rotation, position) = rigid_fit(&points.collect::<Vec<_>>(), &measured);
        put(&mut values, model.base, position);
        put(&mut values, model.base + 3, rotation_vector(&rotation));
        for &marker in markers.iter().filter(|_| campaign.estimate_tool) {
            // p = R_frame^T (R_base^T (m - p_base) - p_frame) is linear in p with orthogonal factors: the mean solves it.
            let (mut sum, mut count) = (Vector3::zeros(), 0.0);
            let readings = campaign.readings.iter().zip(&frames).zip(&measured);
            for ((_, frame), m) in readings.filter(|((reading, _), _)| reading.marker == marker) {
                sum += frame.rotation.inverse() * (rotation.inverse() * (m - position) - frame.translation.vector);
                count += 1.0;
            }
            put(&mut values, point_slot(marker), sum / count);
        }
    }
    if campaign.estimate_tool && campaign.observes.sees_orientation() {
        let base = Rotation3::new(at(&values, model.base + 3));
        let mut sum = Matrix3::zeros();
        for (reading, frame) in campaign.readings.iter().zip(&frames) {
            if let Some(turn) = campaign.observes.measured_orientation(&reading.measured) {
                sum += ((base * frame.rotation).inverse() * turn).into_inner();
            }
        }
        put(&mut values, model.tool.1 + 3, rotation_vector(&nearest_rotation(&sum)));
    }
    Ok(values)
}

/// The frame of each reading's marker or of the tool, base axes.
fn frames(model: &Model, campaign: &Campaign, values: &[f64]) -> Result<Vec<Transform>, PredictionError> {
    let geometry = Geometry::new(model, values)?;
    let mut placements = Placements::default();
    let mut frames = Vec::with_capacity(campaign.readings.len());
    for (index, reading) in campaign.readings.iter().enumerate() {
        geometry.place(campaign.configuration(index), &mut placements).map_err(|source| PredictionError::Assembly {
            row: reading.row,
            pose: campaign.poses[reading.pose].clone(),
            source,
        })?;
        frames.push(placements.frames[reading.marker.map_or(model.tool.0, |m| model.markers[m].frame)]);
    }
    Ok(frames)
}

fn at(values: &[f64], slot: Slot) -> Vector3<f64> {
    Vector3::new(values[slot], values[slot + 1], values[slot + 2])
}

fn put(values: &mut [f64], slot: Slot, vector: Vector3<f64>) {
    values[slot..slot + 3].copy_from_slice(vector.as_slice());
}

/// Rotation R and translation t that minimise the sum of |R a + t - b|^2 (Kabsch 1976).
fn rigid_fit(a: &[Vector3<f64>], b: &[Vector3<f64>]) -> (Rotation3<f64>, Vector3<f64>) {
    let mean = |points: &[Vector3<f64>]| points.iter().sum::<Vector3<f64>>() / points.len().max(1) as f64;
    let (mean_a, mean_b) = (mean(a), mean(b));
    let covariance: Matrix3<f64> = a.iter().zip(b).map(|(a, b)| (b - mean_b) * (a - mean_a).transpose()).sum();
    let rotation = nearest_rotation(&covariance);
    (rotation, mean_b - rotation * mean_a)
}

/// The rotation nearest to a matrix; the identity where it has none.
fn nearest_rotation(matrix: &Matrix3<f64>) -> Rotation3<f64> {
    if matrix.iter().any(|v| !v.is_finite()) {
        return Rotation3::identity();
    }
    let Some(svd) = matrix.try_svd(true, true, f64::EPSILON, 100) else { return Rotation3::identity() };
    let (Some(u), Some(v)) = (svd.u, svd.v_t) else { return Rotation3::identity() };
    let sign = (u * v).determinant().signum();
    // Singular values come in descending order: the last may be mirrored.
    let rotation = u * Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, sign)) * v;
    UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(rotation)).to_rotation_matrix()
}
