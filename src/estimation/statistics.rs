//! Errors of readings, and the covariance of a fit.

use nalgebra::{DMatrix, DVector};
use serde::Serialize;

use crate::description::campaign::Campaign;
use crate::math::mean_rms_max;

/// Errors over a set of readings, m (rad for orientations).
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Errors {
    /// Number of readings.
    pub readings: usize,
    /// Mean, root mean square and greatest Euclidean position error (of a distance: its absolute error).
    pub distance: [f64; 3],
    /// Root mean square and greatest error of a coordinate.
    pub coordinate: [f64; 2],
    /// Mean, root mean square and greatest orientation error, for poses.
    pub orientation: Option<[f64; 3]>,
}

/// Errors of the readings for which `among` holds, from residuals as [`crate::prediction::Linearised::residual`].
pub fn errors_of(campaign: &Campaign, residual: &[f64], among: impl Fn(usize) -> bool) -> Errors {
    let components = campaign.components();
    let chosen: Vec<&[f64]> =
        residual.chunks(components).enumerate().filter(|(i, _)| among(*i)).map(|(_, r)| r).collect();
    let norm = |r: &[f64]| r.iter().map(|v| v * v).sum::<f64>().sqrt();
    let position = campaign.observes.length_rows();
    let coordinate = mean_rms_max(chosen.iter().flat_map(|r| r[..position].iter().copied()));
    let orientation =
        campaign.observes.sees_orientation().then(|| mean_rms_max(chosen.iter().map(|r| norm(&r[position..]))));
    Errors {
        readings: chosen.len(),
        distance: mean_rms_max(chosen.iter().map(|r| norm(&r[..position]))),
        coordinate: [coordinate[1], coordinate[2]],
        orientation,
    }
}

/// (J'J)^-1 by QR; pseudo-inverse where J is deficient. `jacobian` is weighted.
pub fn cofactor(jacobian: &DMatrix<f64>) -> DMatrix<f64> {
    let n = jacobian.ncols();
    if n == 0 || jacobian.iter().any(|v| !v.is_finite()) {
        return DMatrix::zeros(n, n);
    }
    // Columns to length one first: lengths and angles differ by orders of magnitude.
    let scale = DVector::from_iterator(n, jacobian.column_iter().map(|c| c.norm().max(f64::MIN_POSITIVE)));
    let scaled = DMatrix::from_fn(jacobian.nrows(), n, |i, j| jacobian[(i, j)] / scale[j]);
    let r = scaled.qr().r();
    let rows = r.nrows();
    let inverse = r.clone().try_inverse().or_else(|| r.pseudo_inverse(1e-12).ok());
    let inverse = inverse.unwrap_or_else(|| DMatrix::zeros(n, rows));
    let unscaled = DMatrix::from_fn(n, inverse.ncols(), |i, j| inverse[(i, j)] / scale[i]);
    &unscaled * unscaled.transpose()
}

/// Two-sided 95 % quantile of Student's t.
pub fn t95(degrees_of_freedom: f64) -> f64 {
    use statrs::distribution::{ContinuousCDF, StudentsT};
    StudentsT::new(0.0, 1.0, degrees_of_freedom.max(1.0)).map_or(1.96, |t| t.inverse_cdf(0.975))
}
