//! How well a campaign registers when it is read in a given way.

use std::borrow::Cow;
use std::collections::BTreeMap;

use nalgebra::Vector3;
use rand::SeedableRng;
use rand::seq::SliceRandom;

use super::evidence::Limits;
use super::hypothesis::{Hypothesis, own_slots};
use crate::description::campaign::{Campaign, Reading};
use crate::estimation::{RegistrationSettings, registered, row_sigmas};
use crate::math::{distinct, median, norm};
use crate::model::Model;
use crate::observation::Noise;
use crate::parameter::{Group, Kind, Slot};
use crate::prediction::Predictor;

/// A campaign that is tried in several ways on some of its configurations.
pub struct Trials<'a> {
    model: &'a Model,
    whole: Cow<'a, Campaign>,
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
        // A scale that is estimated would take any unit up.
        let whole = match campaign.estimate_scale {
            true => Cow::Owned(Campaign { estimate_scale: false, ..campaign.clone() }),
            false => Cow::Borrowed(campaign),
        };
        let sample = whole.select(|_, reading| chosen[reading.pose]);
        Self { model, whole, chosen, sample, limits }
    }

    /// The readings looked at, read in these ways, and the description's values.
    fn read(&self, ways: &[Hypothesis]) -> (Campaign, Vec<f64>) {
        let mut values = self.model.registry.nominal();
        let mut campaign = match ways.iter().any(Hypothesis::moves_rows) {
            true => {
                let mut all = Campaign::clone(&self.whole);
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
        self.error_searched(ways, |campaign| searching(campaign, self.limits))
    }

    /// The same, searched as long as a registration that is asked for: wires and contacts of unknown places have valleys in which a
    /// quick one stays.
    pub fn error_searched_long(&self, ways: &[Hypothesis]) -> Option<f64> {
        self.error_searched(ways, |_| RegistrationSettings::default())
    }

    fn error_searched(&self, ways: &[Hypothesis], settings: impl Fn(&Campaign) -> RegistrationSettings) -> Option<f64> {
        let (campaign, values) = self.read(ways);
        let (_, residual) = registered(self.model, &campaign, &values, &settings(&campaign)).ok()?;
        typical(&campaign, &residual, self.limits).filter(|error| error.is_finite())
    }

    /// The same of all readings as they are read, with as many starts as a registration that is asked for has: contacts with curved surfaces
    /// have valleys in which a quick one stays.
    pub fn registered(&self) -> Option<f64> {
        let nominal = self.model.registry.nominal();
        let (_, residual) = registered(self.model, &self.whole, &nominal, &RegistrationSettings::default()).ok()?;
        typical(&self.whole, &residual, self.limits).filter(|error| error.is_finite())
    }

    /// The readings times the factor with which they fit the robot best, where they are positions; base and tool take part of it up, so
    /// that it is found in turns with them.
    pub fn scaled(&self) -> Option<Hypothesis> {
        let mut scale = 1.0;
        for _ in 0..SCALE_TURNS {
            let (campaign, values) = self.read(&[Hypothesis::Scale(scale)]);
            let (_, residual) = registered(self.model, &campaign, &values, &searching(&campaign, self.limits)).ok()?;
            let factor = stretch(&campaign, &residual)?;
            scale *= factor;
            if (factor - 1.0).abs() < SCALE_SETTLED {
                break;
            }
        }
        (scale.is_finite() && scale > 0.0).then_some(Hypothesis::Scale(scale))
    }

    /// Mean displacement (m, axes of the frames that carry them) of tool and markers from where the description has them, when they are
    /// estimated.
    pub fn tool_shift(&self, ways: &[Hypothesis]) -> Option<Vector3<f64>> {
        let (campaign, nominal) = self.read(ways);
        let (values, _) = registered(self.model, &campaign, &nominal, &searching(&campaign, self.limits)).ok()?;
        let mut points: Vec<Slot> =
            campaign.readings.iter().map(|own| self.model.point_slot(own.marker, own.session)).collect();
        points.sort_unstable();
        points.dedup();
        let shift = |&first: &Slot| {
            Vector3::from_fn(|k, _| values.get(first + k).zip(nominal.get(first + k)).map_or(0.0, |(a, b)| a - b))
        };
        Some(points.iter().map(shift).sum::<Vector3<f64>>() / points.len().max(1) as f64)
    }

    /// Median errors ([`parts`]) that registration leaves when they are read in these ways.
    pub fn parts(&self, ways: &[Hypothesis]) -> Option<[f64; 2]> {
        let (campaign, values) = self.read(ways);
        let (_, residual) = registered(self.model, &campaign, &values, &searching(&campaign, self.limits)).ok()?;
        parts(&campaign, &residual)
    }

    /// Median distance (m) of measured positions, or lengths, from their mean, read in these ways: what a robot that stands still leaves.
    /// `None` where not all readings are positions, nor all lengths that differ.
    pub fn still(&self, ways: &[Hypothesis]) -> Option<f64> {
        let (campaign, _) = self.read(ways);
        let position = |reading: &Reading| reading.observes.measured_position(&reading.measured);
        let length = |reading: &Reading| {
            let is_length = reading.observes.rows() == 1 && reading.observes.length_rows() == 1;
            is_length.then(|| Vector3::x() * reading.measured[0])
        };
        let positions: Option<Vec<Vector3<f64>>> = campaign.readings.iter().map(position).collect();
        let all = positions.or_else(|| campaign.readings.iter().map(length).collect())?;
        let mean = all.iter().sum::<Vector3<f64>>() / all.len().max(1) as f64;
        median(&mut all.iter().map(|at| (at - mean).norm()).collect::<Vec<f64>>()).filter(|still| *still > 0.0)
    }

    /// What registration may leave of a reading where every free constant of the description is off by its tolerance and the
    /// instrument by its noise: root mean square, m. First order, at the description's values, with the files read in these ways.
    pub fn allowed(&self, ways: &[Hypothesis]) -> Option<f64> {
        // Of directions that are reversed derivatives grow without bound: those of the direction itself hold.
        let is_direction = |reading: &Reading| reading.observes.reversed(&reading.measured).is_some();
        let reversed = self.sample.readings.iter().any(is_direction).then(|| {
            let ways: Vec<Hypothesis> = ways.iter().copied().chain([Hypothesis::DirectionsReversed(None)]).collect();
            self.allowed_as_read(&ways)
        });
        let least = [self.allowed_as_read(ways), reversed.flatten()];
        least.into_iter().flatten().min_by(f64::total_cmp)
    }

    fn allowed_as_read(&self, ways: &[Hypothesis]) -> Option<f64> {
        let (campaign, values) = self.read(ways);
        let model = self.model;
        let free = model.free_slots().into_iter().filter(|&slot| model.registry[slot].group == Group::Geometry);
        let mut slots: Vec<Slot> = free.collect();
        if slots.is_empty() {
            slots = [Kind::Length, Kind::Angle].into_iter().flat_map(|kind| own_slots(model, kind)).collect();
        }
        let tolerances: Vec<f64> = slots.iter().map(|&slot| model.registry[slot].tolerance).collect();
        let width = slots.len().max(1);
        let found = Predictor::new(model, &campaign, slots).ok()?.linearised(&values).ok()?;
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
    let mut poses = distinct(campaign.readings.iter().map(|reading| reading.pose));
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

/// Most turns of registration and scale.
const SCALE_TURNS: usize = 8;
/// Change of the scale that ends them.
const SCALE_SETTLED: f64 = 1e-6;

/// Least squares of predicted against measured positions, of each session about its mean where bases are estimated; `None` where not all
/// readings are positions.
fn stretch(campaign: &Campaign, residual: &[f64]) -> Option<f64> {
    let mut by_session: BTreeMap<_, Vec<[Vector3<f64>; 2]>> = BTreeMap::new();
    for (reading, rows) in campaign.by_reading(residual, 1) {
        let measured = reading.observes.measured_position(&reading.measured)?;
        let predicted = measured - Vector3::from_column_slice(rows.get(..3)?);
        by_session.entry(reading.session).or_default().push([measured, predicted]);
    }
    let [mut product, mut squares] = [0.0, 0.0];
    for pairs in by_session.values() {
        let mean = |k: usize| match campaign.estimate_base {
            true => pairs.iter().map(|pair| pair[k]).sum::<Vector3<f64>>() / pairs.len() as f64,
            false => Vector3::zeros(),
        };
        let means = [mean(0), mean(1)];
        for [measured, predicted] in pairs {
            product += (measured - means[0]).dot(&(predicted - means[1]));
            squares += (measured - means[0]).norm_squared();
        }
    }
    (squares > 0.0).then(|| product / squares)
}

/// Median errors of the lengths (m) and of the rotations (rad) in the readings; `None` where not both are read.
pub fn parts(campaign: &Campaign, residual: &[f64]) -> Option<[f64; 2]> {
    let of = |is_rotation: bool| {
        let own = campaign.by_reading(residual, 1).filter(|(reading, _)| reading.observes.by_variable().is_none());
        let own = own.filter_map(|(reading, rows)| {
            let (lengths, rotations) = rows.split_at(reading.observes.length_rows().min(rows.len()));
            let rows = if is_rotation { rotations } else { lengths };
            (!rows.is_empty()).then(|| norm(rows))
        });
        median(&mut own.collect::<Vec<f64>>())
    };
    Some([of(false)?, of(true)?])
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
    let size = |reading: &Reading| norm(&reading.noise.position);
    campaign.readings.iter().map(size).sum::<f64>() / campaign.readings.len().max(1) as f64
}
