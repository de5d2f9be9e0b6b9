//! Where the base, the tool and the markers are, the robot's geometry being given: the start of every calibration and
//! its baseline.

use nalgebra::Vector3;

use super::placing::{Group, placed};
use super::problem::{CampaignProblem, row_sigmas};
use super::robust;
use super::settings::RegistrationSettings;
use crate::description::campaign::{Campaign, InSession, Reading, Sharing, Target};
use crate::description::robot::FrameIndex;
use crate::kinematics::{Geometry, Placements, Transform};
use crate::least_squares::{self, Bounds, Loss};
use crate::math::distinct;
use crate::math::quantiles::TUKEY;
use crate::model::Model;
use crate::observation::{MeasuredPoint, Observes};
use crate::parameter::Slot;
use crate::prediction::{PredictionError, Predictor, earlier_normal, residuals, target_values, undeflected_point};

/// Slots of the measuring arrangement the campaign asks to estimate.
pub fn arrangement(model: &Model, campaign: &Campaign) -> Vec<Slot> {
    let mut slots: Vec<Slot> = Vec::new();
    let placed = campaign.select(|_, reading| !reading.observes.ignores_arrangement());
    if campaign.estimate_base {
        slots
            .extend(parts(&placed, campaign.sessions.base).flat_map(|of| model.base_slot(of)..model.base_slot(of) + 6));
    }
    if campaign.estimate_tool {
        let rotation = if campaign.sees_orientation() { 6 } else { 3 };
        let mut points: Vec<(Option<usize>, InSession)> = Vec::new();
        for of in parts(&placed, campaign.sessions.tool) {
            let own =
                |reading: &&Reading| reading.session.part(campaign.sessions.tool) == of.part(campaign.sessions.tool);
            let markers: Vec<Option<usize>> = distinct(placed.readings.iter().filter(own).map(|r| r.marker));
            points.extend(markers.into_iter().map(|marker| (marker, of)));
        }
        for (marker, of) in points {
            let first = model.point_slot(marker, of);
            slots.extend(first..first + if marker.is_none() { rotation } else { 3 });
        }
    }
    if campaign.estimate_scale {
        slots.extend(parts(&placed, campaign.sessions.scale).filter_map(|of| model.scale_slot(of)));
    }
    let lengths = campaign.constraints.iter().filter_map(|constraint| constraint.length);
    let targets: Vec<usize> = distinct(campaign.readings.iter().filter_map(|reading| reading.target).chain(lengths));
    let of_targets = targets.into_iter().flat_map(|target| model.target_values(target).iter().flatten().copied());
    slots.extend(of_targets);
    slots.sort_unstable();
    slots.dedup();
    slots
}

/// A reading's place in each part that is shared so, once each.
fn parts(campaign: &Campaign, shared: Sharing) -> impl Iterator<Item = InSession> {
    let mut known: Vec<usize> = Vec::new();
    let mut all = Vec::new();
    for reading in &campaign.readings {
        let part = reading.session.part(shared);
        if !known.contains(&part) {
            known.push(part);
            all.push(reading.session);
        }
    }
    all.into_iter()
}

/// A start for base, tool and markers, from the readings alone, however far from the description they are: a global
/// search with the robot rigid ([`placed`]), for each part of the readings that has a base of its own; then for what readings
/// refer to, from where the robot is when they are taken. Where the campaign does not estimate the base, or its readings are
/// differences in which base and tool drop out, base and points stay as given.
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
    let shared = campaign.sessions.base;
    let mut known: Vec<Slot> = Vec::new();
    let with_base = campaign.estimate_base && !campaign.is_difference();
    for of in parts(campaign, shared).filter(|_| with_base) {
        let is_own = |reading: &Reading| reading.session.part(shared) == of.part(shared);
        let Some(observes) = best_kind(model, campaign, is_own) else { continue };
        let own = campaign.select(|_, reading| is_own(reading) && reading.observes == observes);
        let points: Vec<Slot> = own.readings.iter().map(|r| model.point_slot(r.marker, r.session)).collect();
        let sees_tool = observes.sees_orientation() && own.readings.iter().any(|reading| reading.marker.is_none());
        let is_free = campaign.estimate_tool && !points.iter().any(|point| known.contains(point));
        let group = Group {
            campaign: &own,
            observes,
            frames: frames(model, &own, &values)?,
            base: model.base_slot(of),
            are_points_free: is_free,
            tool_rotation: sees_tool.then_some((model.tool_slot(of) + 3, is_free)),
            points,
        };
        placed(&group, &mut values, settings);
        known.extend(group.points);
    }
    start_targets(model, campaign, false, &mut values)?;
    start_distances(model, campaign, &mut values);
    Ok(values)
}

/// `values` with what readings refer to placed anew from where their points are with them, whatever the campaign says it is near to; `None`
/// where that moves nothing by more than its common error. A start from an uncalibrated robot may lie in another minimum: a small sphere in
/// that of a plane.
///
/// # Errors
/// A configuration that cannot be assembled.
pub(super) fn placed_anew(
    model: &Model,
    campaign: &Campaign,
    values: &[f64],
) -> Result<Option<Vec<f64>>, PredictionError> {
    let mut anew = values.to_vec();
    start_targets(model, campaign, true, &mut anew)?;
    let is_far = |slot: usize| (anew[slot] - values[slot]).abs() > model.registry[slot].tolerance;
    let is_finite = anew.iter().zip(values).all(|(new, old)| new.is_finite() || !old.is_finite());
    Ok((is_finite && (0..anew.len()).any(is_far)).then_some(anew))
}

/// Starts for unknown distances: the mean of those between the targets that share one.
fn start_distances(model: &Model, campaign: &Campaign, values: &mut [f64]) {
    let point = |target: usize, values: &[f64]| {
        Vector3::from_column_slice(&target_values(model, campaign, target, values)[..3])
    };
    let mut sums: Vec<(Slot, f64, f64)> = Vec::new();
    for constraint in &campaign.constraints {
        let length = constraint.length.and_then(|length| model.target_values(length).first().copied().flatten());
        let Some(slot) = length else { continue };
        let [a, b] = constraint.targets.map(|target| point(target, values));
        let distance = (a - b).norm();
        match sums.iter_mut().find(|(known, ..)| *known == slot) {
            Some((_, sum, count)) => (*sum, *count) = (*sum + distance, *count + 1.0),
            None => sums.push((slot, distance, 1.0)),
        }
    }
    sums.into_iter().for_each(|(slot, sum, count)| values[slot] = sum / count);
}

/// Values with base, tool, markers and what readings refer to fitted to the readings, the robot as `values` (by slot) say, and
/// the residuals there, as [`crate::prediction::Linearised::residual`]. Quicker than [`super::calibrate`] with nothing free, and less exact: to
/// compare descriptions and ways to read a campaign, not to report.
///
/// # Errors
/// A configuration that cannot be assembled, or no readings.
///
/// ```
/// use elastogeo::estimation::{RegistrationSettings, errors_of, registered};
///
/// let loaded = elastogeo::files::load_campaign("kr270-simulated", None)?;
/// let (model, campaign) = (&loaded.robot.model, &loaded.campaign);
/// let (_, residual) = registered(model, campaign, &model.registry.nominal(), &RegistrationSettings::default())?;
/// let rms = errors_of(campaign, &residual, |_| true).distance[1];
/// assert!((1e-3..4e-3).contains(&rms)); // m: the robot itself is not calibrated
/// # Ok::<(), elastogeo::Error>(())
/// ```
pub fn registered(
    model: &Model,
    campaign: &Campaign,
    values: &[f64],
    settings: &RegistrationSettings,
) -> Result<(Vec<f64>, Vec<f64>), PredictionError> {
    let mut values = rough(model, campaign, values, settings)?;
    let slots = arrangement(model, campaign);
    let is_placed =
        campaign.estimate_base && !campaign.estimate_scale && !campaign.targets.iter().any(Target::is_estimated);
    if !slots.is_empty() && !is_placed && !campaign.is_difference() {
        let count = slots.len();
        let predictor = Predictor::new(model, campaign, slots)?;
        let problem = CampaignProblem::new(predictor, &values, row_sigmas(campaign), Vec::new());
        let limits = least_squares::Settings { max_iterations: 30, cost_tolerance: 1e-9, ..Default::default() };
        if let Ok(found) = least_squares::minimize(&problem, &vec![0.0; count], &Bounds::none(count), &limits) {
            values = problem.values(&found.x);
        }
    }
    let found = residuals(model, campaign, &values)?;
    Ok((values, found))
}

/// Values with what no description holds fitted to the readings (where some of these are outliers, with a loss that they do not move), and which parameters these are: where contacts and anchors are, zeros,
/// gains and offsets, the instrument's scale, and bases and tools of a session or station of their own. The robot, and a base and tool
/// that all readings share, stay as `values` say.
///
/// # Errors
/// A configuration that cannot be assembled.
pub fn with_campaign_fitted(
    model: &Model,
    campaign: &Campaign,
    values: &[f64],
    settings: &RegistrationSettings,
) -> Result<(Vec<f64>, Vec<Slot>), PredictionError> {
    let mut own = campaign.clone();
    own.estimate_base &= own.sessions.base != Sharing::All && !campaign.is_difference();
    own.estimate_tool &= own.sessions.tool != Sharing::All && !campaign.is_difference();
    let slots = arrangement(model, &own);
    if slots.is_empty() {
        return Ok((values.to_vec(), slots));
    }
    let start = rough(model, &own, values, settings)?;
    let predictor = Predictor::new(model, &own, slots.clone())?;
    let problem = CampaignProblem::new(predictor, &start, row_sigmas(&own), Vec::new());
    let (count, limits) = (slots.len(), least_squares::Settings::default());
    let found = least_squares::minimize(&problem, &vec![0.0; count], &Bounds::none(count), &limits);
    let Ok(found) = found else { return Ok((start, slots)) };
    if !has_outliers(found.residual.as_slice()) {
        return Ok((problem.values(&found.x), slots));
    }
    // A wrong reading would move what is fitted, and be spread over the sound ones.
    let limits = least_squares::Settings { loss: Loss::Tukey(TUKEY), ..limits };
    let robust = robust::minimize(&problem, &Bounds::none(count), &limits, &mut |_| {});
    Ok((problem.values(&robust.unwrap_or(found).x), slots))
}

/// Robust standard deviations beyond which a residual is an outlier: 2e-9 of normal noise.
const OUTLYING: f64 = 6.0;

fn has_outliers(residual: &[f64]) -> bool {
    let scale = robust::deviation(residual.iter().copied()).unwrap_or(0.0);
    scale > 0.0 && residual.iter().any(|own| own.abs() > OUTLYING * scale)
}

/// The kind of those readings that says most about where the base is: poses, then positions, then lengths from known points.
fn best_kind(model: &Model, campaign: &Campaign, is_own: impl Fn(&Reading) -> bool) -> Option<Observes> {
    let is_known = |reading: &Reading| model.target_values(reading.target).iter().all(Option::is_none);
    let places = |reading: &&Reading| {
        reading.observes.measured_position(&reading.measured).is_some()
            || reading.observes.target_column().is_none()
            || is_known(reading)
    };
    let shows_place = |observes: Observes| !observes.ignores_arrangement() && !observes.is_difference();
    let is_placed = |reading: &&Reading| is_own(reading) && shows_place(reading.observes);
    let kinds = || campaign.readings.iter().filter(is_placed).filter(places).map(|r| r.observes);
    kinds().find(|kind| kind.holds_pose()).or_else(|| kinds().max_by_key(|kind| kind.length_rows()))
}

/// The frame of each reading's marker or of the tool, base axes.
fn frames(model: &Model, campaign: &Campaign, values: &[f64]) -> Result<Vec<Transform>, PredictionError> {
    at_each(model, campaign, values, |_, placements, reading| placements.frames[frame(model, reading)])
}

fn frame(model: &Model, reading: &Reading) -> FrameIndex {
    reading.marker.map_or(model.tool.0, |marker| model.markers[marker].frame)
}

/// Something of each reading at its configuration.
fn at_each<T>(
    model: &Model,
    campaign: &Campaign,
    values: &[f64],
    of: impl Fn(&Geometry, &Placements, &Reading) -> T,
) -> Result<Vec<T>, PredictionError> {
    let geometry = Geometry::new(model, values)?;
    let mut placements = Placements::default();
    let mut all = Vec::with_capacity(campaign.readings.len());
    for (index, reading) in campaign.readings.iter().enumerate() {
        geometry.place(campaign.configuration(index), &mut placements).map_err(|source| PredictionError::Assembly {
            at: campaign.address(reading),
            pose: campaign.poses[reading.pose].clone(),
            source,
        })?;
        all.push(of(&geometry, &placements, reading));
    }
    Ok(all)
}

/// Starts for what readings refer to: from where their points are, and what they read; with `anew` of what the campaign says where it is
/// about too.
fn start_targets(model: &Model, campaign: &Campaign, anew: bool, values: &mut [f64]) -> Result<(), PredictionError> {
    let is_sought = |(_, target): &(usize, &Target)| target.is_estimated();
    let sought: Vec<(usize, &Target)> = campaign.targets.iter().enumerate().filter(is_sought).collect();
    if sought.is_empty() {
        return Ok(());
    }
    let gravity = model.structure.gravity.try_normalize(0.0).unwrap_or_default();
    let points = at_each(model, campaign, values, |geometry, placements, reading| {
        let base = geometry.placement(model.base_slot(reading.session));
        let at = (base * undeflected_point(geometry, placements, reading)).coords;
        let body = base.rotation * placements.frames[frame(model, reading)].rotation;
        let tool = geometry.placement(model.tool_slot(reading.session)).rotation;
        let rigid = MeasuredPoint::rigid(at, body, tool);
        MeasuredPoint { gravity: base.rotation * gravity, measured: reading.measured, ..rigid }
    })?;
    for (index, target) in sought {
        let is_own = |reading: &Reading| {
            let column = reading.observes.target_column();
            reading.target == Some(index) && column.is_none_or(|column| column == target.column)
        };
        let own = campaign.readings.iter().zip(&points).filter(|(reading, _)| is_own(reading));
        let read: Vec<MeasuredPoint> = own.clone().map(|(_, point)| *point).collect();
        let Some((reading, _)) = own.clone().next() else { continue };
        let near = target_values(model, campaign, index, values);
        let found = match anew || target.is_to_be_sought() {
            true => reading.observes.target_start(&read),
            false => reading.observes.target_start_near(&near, &read),
        };
        let Some(mut found) = found else { continue };
        // A face that is parallel to an earlier one has its normal.
        if let Some(normal) = earlier_normal(model, campaign, index, values) {
            found[..3].copy_from_slice(normal.as_slice());
            found[3] = read.iter().map(|point| normal.dot(&point.position())).sum::<f64>() / read.len() as f64;
        }
        for (slot, value) in model.target_values(index).iter().zip(found) {
            slot.iter().for_each(|&slot| values[slot] = value);
        }
    }
    Ok(())
}
