//! What a fit says of its parameters: estimates with their intervals, and the covariance that a description carries.

use super::covariance::Covariance;
use super::equivalence::moves;
use super::fit::Fit;
use super::problem::row_sigmas;
use super::registration::arrangement;
use super::result::{CalibrationError, Estimate};
use super::selection::Selection;
use super::task::Task;
use crate::description::raw::RawFit;
use crate::math::quantiles::{normal_of_any, t95};
use crate::parameter::{Group, Slot};

/// Greatest change of a reading, in its standard deviations, that no campaign shows: a hundred thousand readings together would
/// show it by three.
const UNSEEN: f64 = 0.01;

/// What a fit tells of its parameters.
pub(super) struct Fitted<'t> {
    pub covariance: &'t Covariance,
    pub at_bound: &'t [bool],
    pub logarithms: &'t [bool],
}

impl Task<'_> {
    /// Puts springs that a fit left at a bound back to what is declared where that moves no reading: no reading tells them. Which
    /// kept parameters are at a bound then.
    pub(super) fn back_to_nominal(
        &self,
        selection: &Selection,
        found: &Fit,
        values: &mut Vec<f64>,
    ) -> Result<Vec<bool>, CalibrationError> {
        let mut at_bound = found.at_bound.clone();
        let sigmas = row_sigmas(self.campaign);
        let left = |values: &[f64]| self.everything.linearised(values).map(|found| found.residual);
        for (k, slot) in selection.kept().into_iter().enumerate() {
            if !at_bound[k] || self.model.registry[slot].group != Group::Elastic {
                continue;
            }
            let group = selection.groups.iter().find(|group| group.members[0].0 == slot);
            let members =
                group.map_or_else(|| vec![slot], |group| group.members.iter().map(|(slot, _)| *slot).collect());
            let mut declared = values.clone();
            members.iter().for_each(|&slot| declared[slot] = self.nominal[slot]);
            let (now, then) = (left(values)?, left(&declared)?);
            let moved = now.iter().zip(&then).zip(&sigmas).map(|((a, b), sigma)| (a - b).abs() / sigma);
            if moved.fold(0.0, f64::max) < UNSEEN {
                *values = declared;
                at_bound[k] = false;
            }
        }
        Ok(at_bound)
    }

    /// Results of all candidates.
    pub(super) fn estimates(
        &self,
        selection: &Selection,
        values: &[f64],
        &Fitted { covariance, at_bound, logarithms }: &Fitted,
        open: &[f64],
    ) -> Result<Vec<Estimate>, CalibrationError> {
        let slots = &selection.predictor.slots;
        let last = selection.predictor.linearised(values)?;
        let moves = moves(&self.fitted, &last.jacobian, slots, values);
        // Of readings and of what dropped parameters leave open, which is as good as known (Welch and Satterthwaite).
        let width = |k: usize| {
            let own = covariance.matrix[(k, k)].max(0.0).sqrt();
            let sigma = own.hypot(open.get(k).copied().unwrap_or(0.0));
            let degrees_of_freedom = covariance.degrees_of_freedom[k] * (sigma / own.max(f64::MIN_POSITIVE)).powi(4);
            let degrees_of_freedom = degrees_of_freedom.clamp(1.0, f64::MAX);
            (t95(degrees_of_freedom) * sigma, degrees_of_freedom)
        };
        let estimate = |(column, (&slot, moves)): (usize, (&Slot, f64))| {
            let position = selection.identifiability.kept.binary_search(&column).ok();
            let (ci95, degrees_of_freedom) = position.map(width).unzip();
            let value = values[slot];
            let of_factors = |ci95: f64| [-1.0, 1.0].map(|side| value * (side * ci95 / value).exp());
            let interval = ci95.filter(|_| position.is_some_and(|k| logarithms[k]) && value > 0.0).map(of_factors);
            Estimate {
                slot,
                nominal: self.nominal[slot],
                value,
                ci95,
                interval,
                of_dropped: position.and_then(|k| open.get(k).copied()).filter(|open| *open > 0.0),
                degrees_of_freedom,
                at_bound: position.is_some_and(|k| at_bound[k]),
                moves: (self.model.registry[slot].group == Group::Elastic).then_some(moves),
            }
        };
        Ok(slots.iter().zip(moves).enumerate().map(estimate).collect())
    }

    /// What a description carries of the covariance: base, scale and what belongs to sessions and contacts are no part of it,
    /// nor what dropped parameters leave open in second order, which moves the kept ones so that positions stay.
    pub(super) fn carried(&self, kept: &[Slot], covariance: &Covariance, direction_noise: [f64; 3]) -> RawFit {
        let (model, arranged) = (self.model, arrangement(self.model, self.campaign));
        let markers = model.markers.iter().map(|marker| marker.slot..marker.slot + 3);
        let points: Vec<_> = markers.chain(std::iter::once(model.tool.1..model.tool.1 + 6)).collect();
        let belongs = |slot: &Slot| !arranged.contains(slot) || points.iter().any(|own| own.contains(slot));
        let own: Vec<usize> = (0..kept.len()).filter(|&k| belongs(&kept[k])).collect();
        let rows = own.iter().enumerate();
        // Residuals of the stated noise scatter themselves: their variance by sqrt(2 / n), of which 5 % exceed this many.
        let excess = covariance.noise_ratio.powi(2) - 1.0;
        let is_noise =
            self.campaign.sigma.is_some() && excess < normal_of_any(0.05, 1) * (2.0 / covariance.freedom).sqrt();
        let noise = if is_noise { [f64::INFINITY; 3] } else { self.campaign.sigma.unwrap_or_default() };
        RawFit {
            parameters: own.iter().map(|&k| model.registry[kept[k]].name.clone()).collect(),
            covariance: rows
                .map(|(at, &row)| own[..=at].iter().map(|&column| covariance.matrix[(row, column)]).collect())
                .collect(),
            unexplained: std::array::from_fn(|k| (direction_noise[k].powi(2) - noise[k].powi(2)).max(0.0).sqrt()),
        }
    }
}
