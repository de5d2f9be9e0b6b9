//! Errors of readings.

use serde::Serialize;

use crate::description::campaign::{Campaign, Reading};
use crate::math::{mean_rms_max, norm};

/// Errors over a set of readings, m (rad for orientations).
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Errors {
    /// Number of readings.
    pub readings: usize,
    /// Mean, root mean square and greatest Euclidean position error (of a distance: its absolute error).
    pub distance: [f64; 3],
    /// Root mean square and greatest error of a coordinate.
    pub coordinate: [f64; 2],
    /// Mean, root mean square and greatest orientation error, where a reading tells one.
    pub orientation: Option<[f64; 3]>,
    /// Mean, root mean square and greatest error of torques (N.m) and forces (N) of joints.
    pub load: Option<[f64; 3]>,
}

/// Errors of the readings for which `among` holds, from residuals as [`crate::prediction::Linearised::residual`].
///
/// ```
/// use elastogeo::estimation::errors_of;
/// use elastogeo::prediction::residuals;
///
/// let loaded = elastogeo::files::load_campaign("ir663-simulated", None)?;
/// let model = &loaded.robot.model;
/// let found = residuals(model, &loaded.campaign, &model.registry.nominal())?;
/// let errors = errors_of(&loaded.campaign, &found, |_| true);
/// assert_eq!(errors.readings, 43);
/// assert!((0.5e-3..1.5e-3).contains(&errors.distance[1])); // not calibrated yet
/// # Ok::<(), elastogeo::Error>(())
/// ```
pub fn errors_of(campaign: &Campaign, residual: &[f64], among: impl Fn(usize) -> bool) -> Errors {
    let readings = campaign.by_reading(residual, 1).enumerate().filter(|(index, _)| among(*index));
    let is_load = |reading: &Reading| reading.observes.by_variable().is_some();
    let (loads, placed): (Vec<_>, Vec<_>) = readings.map(|(_, own)| own).partition(|(reading, _)| is_load(reading));
    let load = (!loads.is_empty()).then(|| mean_rms_max(loads.iter().map(|(_, own)| own[0].abs())));
    let chosen: Vec<(usize, &[f64])> =
        placed.into_iter().map(|(reading, own)| (reading.observes.length_rows(), own)).collect();
    let with_lengths = || chosen.iter().filter(|(lengths, _)| *lengths > 0).map(|(lengths, own)| &own[..*lengths]);
    let coordinate = mean_rms_max(with_lengths().flat_map(|own| own.iter().copied()));
    let turned = || chosen.iter().filter(|(lengths, own)| own.len() > *lengths);
    let orientation = turned().next().map(|_| mean_rms_max(turned().map(|(lengths, own)| norm(&own[*lengths..]))));
    Errors {
        readings: chosen.len() + loads.len(),
        distance: mean_rms_max(with_lengths().map(norm)),
        coordinate: [coordinate[1], coordinate[2]],
        orientation,
        load,
    }
}
