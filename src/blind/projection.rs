//! How large a cause is drawn: by what calibration leaves of it, within what machines have. Calibration projects the
//! readings off the columns of what it fits; lengths in m.

use nalgebra::{DMatrix, DVector};

use super::calibrated::calibrated;
use super::plant::Plant;
use super::shapes::Shape;
use crate::description::campaign::Campaign;
use crate::math::linear::Svd;
use crate::model::Model;
use crate::parameter::Kind;
use crate::prediction::{PredictionError, Predictor};

/// A cause that must displace readings further than this (m) to leave such a gap is drawn again.
const FURTHEST: f64 = 0.012;
/// No mass is further off than this, kg.
const HEAVIEST: f64 = 300.0;
/// No joint, bearing or base is softer than this, rad/(N.m).
const SOFTEST: f64 = 1e-4;
/// No link grows by more with the temperature noted, 1/K: four times aluminium, where a motor inside is warmer than the air.
const GROWTH: f64 = 1e-4;
/// No instrument's scale is further off: dial gauges and cameras reach a percent, trackers a few millionths.
const SCALE: f64 = 0.01;
/// No load that is applied is stated further off.
const GAIN: f64 = 0.5;
/// What each of several causes must leave in addition to the others, as a share of what it leaves alone.
const OWN: f64 = 0.4;
/// Singular values below this share of the greatest are directions that calibration does not fit.
const DEPENDENT: f64 = 1e-6;
/// The size first tried, and how often it is corrected: causes are nearly linear in it.
const FIRST_SIZE: f64 = 1e-9;
const CORRECTIONS: usize = 8;
/// How near the gap comes to the one that is wanted, as a share of it.
const NEAR: f64 = 0.02;
/// Shares of the gap that half the size leaves where the cause is about linear in its size.
const LINEAR: std::ops::Range<f64> = 0.3..0.7;

/// What calibration of a campaign fits, linear about the true values.
pub struct Projection {
    basis: DMatrix<f64>,
    /// Readings of the machine without causes.
    undisturbed: Vec<[f64; 3]>,
}

impl Projection {
    pub fn new(model: &Model, values: &[f64], campaign: &Campaign) -> Result<Self, PredictionError> {
        let mut slots = calibrated(model, campaign.is_difference());
        if campaign.estimate_base {
            slots.extend(model.base..model.base + 6);
            slots.extend(model.markers.iter().flat_map(|marker| marker.slot..marker.slot + 3));
            if model.markers.is_empty() {
                slots.extend(model.tool.1..model.tool.1 + 3);
            }
        }
        let predictor = Predictor::new(model, campaign, slots.clone())?;
        let found = predictor.linearised(values)?;
        let basis = basis(DMatrix::from_row_slice(predictor.rows(), slots.len(), &found.jacobian));
        let undisturbed = Plant { model, values: values.to_vec(), causes: Vec::new() }.readings(campaign, 0.0)?;
        Ok(Self { basis, undisturbed })
    }

    /// What calibration leaves of readings that differ from the undisturbed ones, m.
    fn residual(&self, shown: &[[f64; 3]]) -> DVector<f64> {
        let moved = self.moved(shown);
        &moved - &self.basis * self.basis.tr_mul(&moved)
    }

    /// Its root mean square over the readings, m.
    pub fn rms(&self, shown: &[[f64; 3]], campaign: &Campaign) -> f64 {
        let residual = self.residual(shown);
        let freedom = (residual.len() - self.basis.ncols()) as f64 / residual.len() as f64;
        (residual.norm_squared() / (campaign.readings.len() as f64 * freedom)).sqrt()
    }

    fn moved(&self, shown: &[[f64; 3]]) -> DVector<f64> {
        let moved = shown.iter().zip(&self.undisturbed).flat_map(|(a, b)| (0..3).map(move |k| a[k] - b[k]));
        DVector::from_iterator(3 * shown.len(), moved)
    }

    /// Size at which a shape alone leaves a gap (m), and what it leaves; none if it would have to be too great.
    pub fn size(
        &self,
        plant: &Plant,
        campaign: &Campaign,
        shape: &Shape,
        sigma: f64,
        gap: f64,
    ) -> Result<Option<(f64, DVector<f64>)>, PredictionError> {
        let with = |size: f64| Plant { causes: vec![(shape.clone(), size)], ..plant.clone() }.readings(campaign, sigma);
        let mut size = FIRST_SIZE;
        for correction in 0..CORRECTIONS {
            // A great change of a constant may leave a linkage that cannot be assembled.
            let Ok(shown) = with(size) else { return Ok(None) };
            let moved = self.moved(&shown).norm() / (campaign.readings.len() as f64).sqrt();
            let factor = gap / self.rms(&shown, campaign);
            if !factor.is_finite() || moved * factor > FURTHEST {
                return Ok(None);
            }
            if correction > 0 && (factor - 1.0).abs() < NEAR {
                // What hardly grows with its size any more is no machine: a spring so soft that the loop carries all.
                let Ok(half) = with(0.5 * size) else { return Ok(None) };
                let is_linear = LINEAR.contains(&(self.rms(&half, campaign) / gap));
                return Ok(is_linear.then(|| (size, self.residual(&shown))));
            }
            size *= factor;
            if !is_possible(plant, shape, size) {
                return Ok(None);
            }
        }
        // A cause that cannot leave as much, however great it is.
        Ok(None)
    }
}

/// Orthonormal columns that span those of a matrix, which are brought to the same length first.
fn basis(mut matrix: DMatrix<f64>) -> DMatrix<f64> {
    for mut column in matrix.column_iter_mut().filter(|column| column.norm() > 0.0) {
        column /= column.norm();
    }
    let Some(Svd { left, values, .. }) = Svd::new(&matrix) else { return DMatrix::zeros(matrix.nrows(), 0) };
    let least = DEPENDENT * values.first().copied().unwrap_or(0.0);
    let kept = values.iter().take_while(|value| **value > least).count();
    left.columns(0, kept).into_owned()
}

/// Whether a machine can have a cause of this size.
fn is_possible(plant: &Plant, shape: &Shape, size: f64) -> bool {
    let slots = match shape {
        Shape::Constants(slots) => slots,
        Shape::Growth(_) => return size < GROWTH,
        Shape::Scale => return size < SCALE,
        Shape::Gain => return size < GAIN,
        _ => return true,
    };
    slots.iter().all(|&(slot, share)| {
        let is_too_great = match plant.model.registry[slot].kind {
            Kind::Mass => size * share > HEAVIEST,
            Kind::RotationalCompliance => size * share > SOFTEST,
            _ => false,
        };
        !(plant.values[slot] + size * share < 0.0 && share < 0.0 || is_too_great)
    })
}

/// Whether each of several causes leaves something of its own in addition to the others.
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
