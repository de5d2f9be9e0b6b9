//! How well a campaign registers when it is read in a given way.

use nalgebra::Vector3;
use rand::SeedableRng;
use rand::seq::SliceRandom;

use super::evidence::Limits;
use super::hypothesis::{Hypothesis, own_slots};
use crate::description::campaign::{Campaign, Reading};
use crate::estimation::{RegistrationSettings, registered, row_sigmas};
use crate::math::median;
use crate::model::Model;
use crate::observation::Noise;
use crate::parameter::{Group, Kind, Slot};
use crate::prediction::{Linearised, Predictor};

/// A campaign that is tried in several ways on some of its configurations.
pub struct Trials<'a> {
    model: &'a Model,
    whole: &'a Campaign,
    /// Whether each configuration is looked at.
    chosen: Vec<bool>,
    /// Their readings.
    sample: Campaign,
    limits: &'a Limits,
}

impl<'a> Trials<'a> {
    /// With configurations drawn so that about [`Limits::readings`] readings are looked at; the same ones every time.
    pub fn new(model: &'a Model, campaign: &'a Campaign, limits: &'a Limits) -> Self {
        let chosen = drawn(campaign, limits);
        let sample = campaign.select(|_, reading| chosen[reading.pose]);
        Self { model, whole: campaign, chosen, sample, limits }
    }

    /// The readings looked at, read in these ways, and the description's values.
    fn read(&self, ways: &[Hypothesis]) -> (Campaign, Vec<f64>) {
        let mut values = self.model.registry.nominal();
        let mut campaign = match ways.iter().any(Hypothesis::moves_rows) {
            true => {
                let mut all = self.whole.clone();
                ways.iter().filter(|way| way.moves_rows()).for_each(|way| way.apply(self.model, &mut all, &mut values));
                all.select(|_, reading| self.chosen[reading.pose])
            }
            false => self.sample.clone(),
        };
        ways.iter().filter(|way| !way.moves_rows()).for_each(|way| way.apply(self.model, &mut campaign, &mut values));
        (campaign, values)
    }

    /// What registration leaves (m, [`typical`]) of the readings when they are read in these ways; `None` where the robot
    /// cannot be assembled so.
    pub fn error(&self, ways: &[Hypothesis]) -> Option<f64> {
        let (campaign, values) = self.read(ways);
        let (_, residual) = registered(self.model, &campaign, &values, &searching(&campaign, self.limits)).ok()?;
        typical(&campaign, &residual, self.limits).filter(|error| error.is_finite())
    }

    /// Median distance (m) of measured positions from their mean, read in these ways: what a robot that stands still leaves.
    /// `None` where not all readings are positions.
    pub fn still(&self, ways: &[Hypothesis]) -> Option<f64> {
        let (campaign, _) = self.read(ways);
        let position = |reading: &Reading| reading.observes.measured_position(&reading.measured);
        let all: Vec<Vector3<f64>> = campaign.readings.iter().map(position).collect::<Option<_>>()?;
        let mean = all.iter().sum::<Vector3<f64>>() / all.len().max(1) as f64;
        median(&mut all.iter().map(|at| (at - mean).norm()).collect::<Vec<f64>>())
    }

    /// What registration may leave of a reading where every free constant of the description is off by its tolerance and the
    /// instrument by its noise: root mean square, m. First order, at the description's values, with the files read in these ways.
    pub fn allowed(&self, ways: &[Hypothesis]) -> Option<f64> {
        let (campaign, values) = self.read(ways);
        let model = self.model;
        let free = model.free_slots().into_iter().filter(|&slot| model.registry[slot].group == Group::Geometry);
        let mut slots: Vec<Slot> = free.collect();
        if slots.is_empty() {
            slots = [Kind::Length, Kind::Angle].into_iter().flat_map(|kind| own_slots(model, kind)).collect();
        }
        let tolerances: Vec<f64> = slots.iter().map(|&slot| model.registry[slot].tolerance).collect();
        let width = slots.len().max(1);
        let mut found = Linearised::default();
        Predictor::new(model, &campaign, slots).ok()?.linearise(&values, true, &mut found).ok()?;
        let sigmas = row_sigmas(&campaign);
        let torques = is_of_torques(&campaign);
        let mut first = 0;
        let mut sum = 0.0;
        for (reading, own) in campaign.by_reading(&found.jacobian, width) {
            for (row, by) in own.chunks(width).enumerate() {
                let spread: f64 = by.iter().zip(&tolerances).map(|(by, tolerance)| (by * tolerance).powi(2)).sum();
                let noise = sigmas.get(first + row).map_or(0.0, |sigma| sigma * sigma);
                let arm = lever(reading, row, torques, self.limits);
                sum += arm * arm * (spread + noise);
            }
            first += reading.observes.rows();
        }
        let mean = sum / campaign.readings.len().max(1) as f64;
        (mean > 0.0 && mean.is_finite()).then(|| mean.sqrt())
    }
}

/// Configurations drawn so that about [`Limits::readings`] readings are looked at; the same ones every time.
pub fn drawn(campaign: &Campaign, limits: &Limits) -> Vec<bool> {
    let mut poses: Vec<usize> = campaign.readings.iter().map(|reading| reading.pose).collect();
    poses.sort_unstable();
    poses.dedup();
    let share = limits.readings as f64 / campaign.readings.len().max(1) as f64;
    let most = ((share * poses.len() as f64).round() as usize).max(limits.least_configurations);
    poses.shuffle(&mut rand_chacha::ChaCha8Rng::seed_from_u64(0));
    let mut chosen = vec![false; campaign.poses.len()];
    poses.into_iter().take(most).for_each(|pose| chosen[pose] = true);
    chosen
}

/// Median error of the readings, m: half are better. Outliers do not count; a rotation counts by what it moves at the end of
/// [`Limits::arm`]. `None` without readings.
pub fn typical(campaign: &Campaign, residual: &[f64], limits: &Limits) -> Option<f64> {
    median(&mut errors(campaign, residual, limits).collect::<Vec<f64>>())
}

/// Whether all readings are torques and forces.
pub fn is_of_torques(campaign: &Campaign) -> bool {
    campaign.readings.iter().all(|reading| reading.observes.by_variable().is_some())
}

/// What a unit of a reading's row counts, m: a length its own, a rotation what it moves at the end of [`Limits::arm`], a torque or
/// force as many standard deviations of a coordinate as it has of its own, but [`Limits::arm`] where all readings are `torques`.
pub fn lever(reading: &Reading, row: usize, torques: bool, limits: &Limits) -> f64 {
    let Noise { position, load, .. } = reading.noise;
    if reading.observes.by_variable().is_some() && !torques {
        position.iter().sum::<f64>() / 3.0 / load
    } else if row < reading.observes.length_rows() {
        1.0
    } else {
        limits.arm
    }
}

/// Error of each reading, m.
pub fn errors<'a>(
    campaign: &'a Campaign,
    residual: &'a [f64],
    limits: &'a Limits,
) -> impl Iterator<Item = f64> + use<'a> {
    let torques = is_of_torques(campaign);
    campaign.by_reading(residual, 1).map(move |(reading, own)| {
        let square = |(row, r): (usize, &f64)| (lever(reading, row, torques, limits) * r).powi(2);
        own.iter().enumerate().map(square).sum::<f64>().sqrt()
    })
}

/// How a registration of a trial proceeds: measured positions say where to set out from.
pub fn searching(campaign: &Campaign, limits: &Limits) -> RegistrationSettings {
    let is_position = |reading: &Reading| reading.observes.measured_position(&reading.measured).is_some();
    let starts = if campaign.readings.iter().all(is_position) { 2 } else { usize::MAX };
    RegistrationSettings { readings: limits.readings, iterations: 12, finalists: 1, starts, last_iterations: 20 }
}

/// Size of the noise of a reading, m: the mean over the campaign.
pub fn noise(campaign: &Campaign) -> f64 {
    let size = |reading: &Reading| reading.noise.position.iter().map(|sigma| sigma * sigma).sum::<f64>().sqrt();
    campaign.readings.iter().map(size).sum::<f64>() / campaign.readings.len().max(1) as f64
}
