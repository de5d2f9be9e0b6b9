//! Residuals of all readings, stage by stage.

use nalgebra::{Point3, Vector3};
use serde::Serialize;

use crate::description::campaign::{Campaign, Reading};
use crate::diagnosis::Diagnosis;
use crate::estimation::Calibration;
use crate::kinematics::{Geometry, Placements};
use crate::model::Model;
use crate::prediction::{PredictionError, residuals, undeflected_point};

/// A stage at which residuals are shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum StageKey {
    /// The description as it is.
    Described,
    /// Base, tool and markers fitted alone.
    Registered,
    /// As the calibration found.
    Calibrated,
    /// What effects compete for.
    Competed,
    /// With the causes of the diagnosis.
    Explained,
}

/// Residuals of all readings at one stage.
#[derive(Debug, Clone, PartialEq)]
pub struct Stage {
    /// Which.
    pub key: StageKey,
    /// As [`crate::prediction::Linearised::residual`].
    pub residual: Vec<f64>,
}

/// All readings as a report shows them.
#[derive(Debug, Clone, PartialEq)]
pub struct Readings {
    /// Stages, in order.
    pub stages: Vec<Stage>,
    /// Where each reading was taken: the measured point with nothing deflected, m, base frame.
    pub points: Vec<Vector3<f64>>,
    /// First row of each reading in the residuals.
    pub first_rows: Vec<usize>,
    /// Residuals turned into the base frame are these columns times those of the measurement frame; for each part of the
    /// readings that shares a base.
    pub to_base: Vec<nalgebra::Matrix3<f64>>,
    /// What the suspected effects, with all that is re-fitted with them, take out of each residual: `competed` less
    /// `explained`; empty where nothing is suspected.
    pub pattern: Vec<f64>,
}

impl Readings {
    /// A stage by its key.
    pub fn stage(&self, key: StageKey) -> Option<&Stage> {
        self.stages.iter().find(|stage| stage.key == key)
    }

    /// The stage that shows what calibration leaves: what the effects competed for.
    pub fn left(&self) -> &[f64] {
        self.stage(StageKey::Competed).or(self.stages.last()).map_or(&[], |stage| &stage.residual)
    }

    /// Position part of a reading's residual, m, base frame; none of a distance.
    pub fn in_base(&self, campaign: &Campaign, stage: &Stage, reading: usize) -> Option<Vector3<f64>> {
        let (first, of) = (*self.first_rows.get(reading)?, campaign.readings.get(reading)?);
        let own = stage.residual.get(first..first + 3).filter(|_| of.observes.length_rows() >= 3)?;
        Some(self.to_base[of.session.part(campaign.sessions.base)] * Vector3::new(own[0], own[1], own[2]))
    }
}

/// Gathers the residuals: with the description as it is, as the calibration found (if there is one), and without and with
/// the causes of the diagnosis.
///
/// # Errors
/// A configuration that cannot be assembled.
pub fn readings(
    model: &Model,
    campaign: &Campaign,
    calibration: Option<&Calibration>,
    diagnosis: &Diagnosis,
) -> Result<Readings, PredictionError> {
    let at = |model: &Model, values: &[f64]| residuals(model, campaign, values);
    let mut stages = vec![Stage { key: StageKey::Described, residual: at(model, &model.registry.nominal())? }];
    if let Some(found) = calibration {
        stages.push(Stage { key: StageKey::Registered, residual: found.registered.clone() });
        stages.push(Stage { key: StageKey::Calibrated, residual: found.residual.clone() });
    }
    let competed = at(model, &diagnosis.calibrated)?;
    let mut pattern = Vec::new();
    stages.push(Stage { key: StageKey::Competed, residual: competed });
    if diagnosis.entries().next().is_some() {
        let with = diagnosis.applied(model);
        let explained = at(&with, &with.completed(&diagnosis.values))?;
        let before = stages.last().map(|stage| stage.residual.clone()).unwrap_or_default();
        pattern = before.iter().zip(&explained).map(|(before, after)| before - after).collect();
        stages.push(Stage { key: StageKey::Explained, residual: explained });
    }
    let geometry = Geometry::new(model, &diagnosis.calibrated)?;
    let mut placements = Placements::default();
    let mut points = Vec::with_capacity(campaign.readings.len());
    for (index, reading) in campaign.readings.iter().enumerate() {
        geometry.place(campaign.configuration(index), &mut placements)?;
        points.push(undeflected_point(&geometry, &placements, reading).coords);
    }
    let shared = campaign.sessions.base;
    let count = campaign.sessions.parts(shared).len();
    let base_of = |reading: &Reading| geometry.placement(model.base_slot(reading.session));
    let mut to_base = vec![nalgebra::Matrix3::identity(); count];
    for reading in &campaign.readings {
        to_base[reading.session.part(shared)] = base_of(reading).rotation.inverse().into_inner();
    }
    // Where it was measured, not where it should be: a reading that is simply wrong stands off.
    for (point, reading) in points.iter_mut().zip(&campaign.readings) {
        if let Some(measured) = reading.observes.measured_position(&reading.measured) {
            *point = (base_of(reading).inverse() * Point3::from(measured)).coords;
        }
    }
    Ok(Readings { stages, points, first_rows: campaign.first_rows(), to_base, pattern })
}
