//! A calibration made anew, on some of the readings, with what carries or makes a load declared otherwise. Springs take up part of such a
//! mistake, and the rest is left.

use super::again::Fall;
use super::evidence::{Evidence, Limits};
use super::shown::mm;
use super::trial::drawn;
use crate::description::campaign::Campaign;
use crate::estimation::{Calibration, Settings, calibrate, far_off};
use crate::model::Model;
use crate::parameter::Slot;

/// Steps within which what is meant is fitted, begun at the description: wrong ones may take hundreds.
const STEPS: usize = 15;
/// Readings on which they are compared: several times the parameters of an arm with its springs.
const READINGS: usize = 240;

/// What calibration leaves of some of the readings with everything as declared.
pub(super) struct AsDeclared<'a> {
    /// What is fitted: the parameters of the calibration, and the springs that the description declares to be identified. Held springs
    /// that are not those of the robot look like weights that are not.
    pub slots: Vec<Slot>,
    /// The readings that are compared.
    pub campaign: Campaign,
    limits: &'a Limits,
    /// Error that is left of them, m.
    left: f64,
}

impl<'a> AsDeclared<'a> {
    /// `None` where nothing is to be tried: calibration leaves nothing but noise, or the noise is not known, or loads are
    /// read by themselves, as deflections.
    pub fn new(evidence: &Evidence<'a>, limits: &'a Limits) -> Option<Self> {
        let campaign = evidence.campaign;
        let is_open = |found: &&Calibration| {
            found.converged()
                && found.noise_ratio > limits.joints_fall
                && found.degrees_of_freedom >= limits.noise_freedom
        };
        let found = evidence.found.filter(is_open)?;
        if campaign.is_difference() || campaign.sigma.is_none() {
            return None;
        }
        let chosen = drawn(campaign, &Limits { readings: READINGS, ..*limits });
        let some = campaign.select(|index, reading| !found.holds_out(index) && chosen[reading.pose]);
        let springs = evidence.model.elastic_slots().into_iter().filter(|slot| !found.slots.contains(slot));
        let slots = found.slots.iter().copied().chain(springs).collect();
        let mut own = Self { slots, campaign: some, limits, left: 0.0 };
        let fitted = own.fitted(evidence.model, &own.campaign)?;
        own.left = fitted.after.fit.distance[1];
        (fitted.noise_ratio > limits.joints_fall).then_some(own)
    }

    /// The parameters of the calibration fitted to these readings with another model or campaign.
    pub fn fitted(&self, model: &Model, campaign: &Campaign) -> Option<Calibration> {
        let settings = Settings {
            only: Some(self.slots.clone()),
            second_order: false,
            max_iterations: Some(STEPS),
            ..Settings::default()
        };
        calibrate(model, campaign, &vec![false; campaign.readings.len()], &settings, &mut |_| {}).ok()
    }

    /// The error (m) that is left with another model or campaign where that is nothing but noise, or a small part of what is left
    /// as declared, with constants that an arm can have: springs that are off leave much with any load.
    pub fn decisive(&self, model: &Model, campaign: &Campaign) -> Option<f64> {
        let again = self.fitted(model, campaign).filter(Calibration::converged)?;
        let there = again.after.fit.distance[1];
        let is_noise = again.noise_ratio <= self.limits.joints_fall && self.left >= self.limits.joints_fall * there;
        let is_decisive = is_noise || self.left >= self.limits.fall * there;
        (is_decisive && far_off(model, &again).next().is_none()).then_some(there)
    }

    /// What is said where the error falls to `there` (m) `with` what is meant.
    pub fn fall(&self, there: f64) -> Fall {
        Fall { before: self.left, after: there }
    }
}

/// What would do as well as what is named, each with the error that it leaves (m).
pub(super) fn alike(others: impl Iterator<Item = (String, f64, &'static str)>) -> String {
    let one = |(with, there, question): (String, f64, &str)| format!("; or {with} ({} mm): {question}?", mm(there));
    others.map(one).collect()
}
