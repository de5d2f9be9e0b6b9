//! How large a cause is drawn: by what calibration leaves of it, within what machines have.

use nalgebra::{DMatrix, DVector};

use super::plant::Plant;
use super::shapes::Shape;
use crate::description::campaign::Campaign;
use crate::diagnosis::nuisance;
use crate::model::Model;
use crate::parameter::Kind;
use crate::prediction::{Linearised, PredictionError, Predictor};

/// A cause that must displace readings further than this (m) to leave such a gap is drawn again.
const FURTHEST: f64 = 0.012;
/// No mass is further off than this, kg.
const HEAVIEST: f64 = 300.0;
/// No joint, bearing or base is softer than this, rad/(N.m).
const SOFTEST: f64 = 1e-4;
/// What each of several causes must show beside the others, as a share of what it leaves.
const OWN: f64 = 0.4;

/// What calibration of a campaign takes up, linear about the true values.
pub struct Ground {
    basis: DMatrix<f64>,
    still: Vec<[f64; 3]>,
}

impl Ground {
    pub fn new(model: &Model, values: &[f64], campaign: &Campaign) -> Result<Self, PredictionError> {
        let mut slots = nuisance(model, campaign, &campaign.calibrate);
        if campaign.estimate_base {
            slots.extend(model.base..model.base + 6);
            slots.extend(model.markers.iter().flat_map(|marker| marker.slot..marker.slot + 3));
        }
        let predictor = Predictor::new(model, campaign, slots.clone())?;
        let mut found = Linearised::default();
        predictor.linearise(values, true, &mut found)?;
        let columns = slots.len();
        let mut matrix = DMatrix::from_row_slice(predictor.rows(), columns, &found.jacobian);
        for mut column in matrix.column_iter_mut() {
            let norm = column.norm();
            if norm > 0.0 {
                column /= norm;
            }
        }
        let split = matrix.svd(true, false);
        let most = split.singular_values.max();
        let kept: Vec<usize> =
            (0..split.singular_values.len()).filter(|&k| split.singular_values[k] > 1e-6 * most).collect();
        let basis = split.u.map_or_else(|| DMatrix::zeros(predictor.rows(), 0), |u| u.select_columns(&kept));
        let still = Plant { model, values: values.to_vec(), causes: Vec::new() }.readings(campaign, 0.0)?;
        Ok(Self { basis, still })
    }

    /// What calibration leaves of readings that differ from the machine's without causes, m.
    fn rest(&self, seen: &[[f64; 3]]) -> DVector<f64> {
        let moved = self.moved(seen);
        &moved - &self.basis * self.basis.tr_mul(&moved)
    }

    /// Its root mean square over the readings, m.
    pub fn left(&self, seen: &[[f64; 3]], campaign: &Campaign) -> f64 {
        let left = self.rest(seen);
        let freedom = (left.len() - self.basis.ncols()) as f64 / left.len() as f64;
        (left.norm_squared() / (campaign.readings.len() as f64 * freedom)).sqrt()
    }

    fn moved(&self, seen: &[[f64; 3]]) -> DVector<f64> {
        let moved = seen.iter().zip(&self.still).flat_map(|(a, b)| (0..3).map(move |k| a[k] - b[k]));
        DVector::from_iterator(3 * seen.len(), moved)
    }

    /// Size at which a shape alone leaves `unseen`, and what it leaves; none if it would have to be too great.
    pub fn size(
        &self,
        plant: &Plant,
        campaign: &Campaign,
        shape: &Shape,
        sigma: f64,
        unseen: f64,
    ) -> Result<Option<(f64, DVector<f64>)>, PredictionError> {
        let mut size = 1e-9;
        let mut alone = Plant { causes: Vec::new(), ..plant.clone() };
        for round in 0..8 {
            alone.causes = vec![(shape.clone(), size)];
            // A great change of a constant may leave a linkage that cannot be assembled.
            let Ok(seen) = alone.readings(campaign, sigma) else { return Ok(None) };
            let left = self.left(&seen, campaign);
            let moved = self.moved(&seen).norm() / (campaign.readings.len() as f64).sqrt();
            let factor = unseen / left;
            if !factor.is_finite() || moved * factor > FURTHEST {
                return Ok(None);
            }
            if round > 0 && (factor - 1.0).abs() < 0.02 {
                // What hardly grows with its size any more is no machine: a spring so soft that the loop carries all.
                alone.causes = vec![(shape.clone(), 0.5 * size)];
                let Ok(half) = alone.readings(campaign, sigma) else { return Ok(None) };
                let grows = (0.3..0.7).contains(&(self.left(&half, campaign) / unseen));
                return Ok(grows.then(|| (size, self.rest(&seen))));
            }
            size *= factor;
            let heavy = |slot: usize, share: f64| match plant.model.registry[slot].kind {
                Kind::Mass => size * share > HEAVIEST,
                Kind::RotationalCompliance => size * share > SOFTEST,
                _ => false,
            };
            if let Shape::Constants(slots) = shape
                && slots
                    .iter()
                    .any(|&(slot, share)| plant.values[slot] + size * share < 0.0 && share < 0.0 || heavy(slot, share))
            {
                return Ok(None);
            }
        }
        // A cause that cannot leave as much, however great it is.
        Ok(None)
    }
}

/// Whether each of several causes leaves something of its own beside the others: two that do the same cannot be told.
pub fn each_shows(causes: &[DVector<f64>]) -> bool {
    (0..causes.len()).all(|k| {
        let others: Vec<DVector<f64>> = (0..causes.len()).filter(|i| *i != k).map(|i| causes[i].clone()).collect();
        if others.is_empty() {
            return true;
        }
        let basis = DMatrix::from_columns(&others).qr().q();
        let own = &causes[k] - &basis * basis.tr_mul(&causes[k]);
        own.norm() > OWN * causes[k].norm()
    })
}
