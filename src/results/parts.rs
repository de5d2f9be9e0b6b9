//! Errors by session, station, file, kind, marker and target, and the worst readings. Lengths in mm, angles in deg.

use indexmap::IndexSet;
use serde::Serialize;

use super::errors::ReadingErrors;
use super::units::{deg, mm};
use crate::description::campaign::{Campaign, Reading};
use crate::estimation::errors_of;
use crate::math::norm;
use crate::model::Model;

/// Errors of a part of the readings.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PartErrors {
    /// `session`, `station`, `file`, `kind`, `marker` or `target`.
    pub part: &'static str,
    /// Name of the part.
    pub name: String,
    /// Errors of its readings.
    #[serde(flatten)]
    pub errors: ReadingErrors,
}

/// Errors of the readings `among` (by index) by session, station, file, kind, marker and target, where there
/// are several.
pub fn parts(model: &Model, campaign: &Campaign, residual: &[f64], among: impl Fn(usize) -> bool) -> Vec<PartErrors> {
    type Name<'a> = Box<dyn Fn(&Reading) -> String + 'a>;
    let sessions = &campaign.sessions;
    let by: [(&'static str, Name); 6] = [
        ("session", Box::new(|reading| sessions.names.get(reading.session.session).cloned().unwrap_or_default())),
        ("station", Box::new(|reading| sessions.stations.get(reading.session.station).cloned().unwrap_or_default())),
        ("file", Box::new(|reading| campaign.file(reading).unwrap_or_default().to_string())),
        ("kind", Box::new(|reading| reading.observes.name().to_string())),
        ("marker", Box::new(|reading| marker(model, reading).to_string())),
        ("target", Box::new(|reading| target(campaign, reading).unwrap_or_default())),
    ];
    let mut parts = Vec::new();
    for (part, name) in by {
        let names: IndexSet<String> = campaign.readings.iter().map(&name).collect();
        for own in names.iter().filter(|name| names.len() > 1 && !name.is_empty()) {
            let is_own = |index: usize| among(index) && name(&campaign.readings[index]) == *own;
            let errors = ReadingErrors::new(&errors_of(campaign, residual, is_own));
            parts.extend(errors.map(|errors| PartErrors { part, name: own.clone(), errors }));
        }
    }
    parts
}

/// The marker of a reading, or the body that it reads; `TCP` is the tool centre point.
fn marker<'a>(model: &'a Model, reading: &Reading) -> &'a str {
    reading.marker.map_or("TCP", |marker| model.markers.get(marker).map_or("", |marker| &marker.name))
}

/// What a reading refers to: a socket, an anchor, the sensor of a joint.
pub fn target(campaign: &Campaign, reading: &Reading) -> Option<String> {
    campaign.target_of(reading).map(|target| target.name.clone())
}

/// A reading with a great error.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct WorstReading {
    /// File and line, or the row.
    pub at: String,
    /// Name of the configuration.
    pub pose: String,
    /// `TCP` is the tool centre point.
    pub marker: String,
    /// What it refers to, as a socket or the sensor of a joint.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub target: Option<String>,
    /// Whether it was held out.
    pub held_out: bool,
    /// Residual over its noise: by this they are in order.
    pub sigmas: f64,
    /// Length of the position's error; of a distance its amount.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error: Option<f64>,
    /// Angle by which the orientation or direction is off, deg; absent where the reading holds none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub orientation_error_deg: Option<f64>,
}

/// Most readings shown as the worst.
const WORST: usize = 5;

/// The readings whose residuals are greatest in terms of their noise, the worst first.
pub fn worst(model: &Model, campaign: &Campaign, residual: &[f64], held_out: &[bool]) -> Vec<WorstReading> {
    let readings = campaign.by_reading(residual, 1).enumerate();
    let mut found: Vec<WorstReading> = readings
        .map(|(index, (reading, own))| {
            let sigmas = reading.observes.sigmas(&reading.noise);
            let weighted: Vec<f64> = own.iter().zip(sigmas).map(|(v, sigma)| v / sigma).collect();
            let (lengths, others) = own.split_at(reading.observes.length_rows().min(own.len()));
            let is_angle = !others.is_empty() && reading.observes.by_variable().is_none();
            WorstReading {
                at: campaign.address(reading),
                pose: campaign.poses[reading.pose].clone(),
                marker: marker(model, reading).to_string(),
                target: target(campaign, reading),
                held_out: held_out.get(index) == Some(&true),
                sigmas: norm(&weighted),
                error: (!lengths.is_empty()).then(|| mm(norm(lengths))),
                orientation_error_deg: is_angle.then(|| deg(norm(others))),
            }
        })
        .collect();
    found.sort_by(|a, b| b.sigmas.total_cmp(&a.sigmas));
    found.truncate(WORST);
    found
}
