//! How certain fitted parameters are.
//!
//! # Covariance of a fit
//! Residuals `r` (m) are in standard deviations of what was stated about the noise; `J` (m x n) is their Jacobian at the
//! minimum and `W` (m) are the robust weights, all 1 for plain squares. If the model is right and the noise is independent
//! and normal, the parameters scatter about the truth with
//!
//! ```text
//!   C = s^2 (J' W J)^-1        s^2 = sum w_i r_i^2 / (m - n)
//! ```
//!
//! (Seber and Wild, *Nonlinear Regression*, 1989, sections 2.1 and 14.6; the Gauss-Newton approximation drops second
//! derivatives, which is right as far as residuals are noise). `s` is [`Covariance::noise_ratio`]: 1 where the noise is as
//! stated. It multiplies the covariance, so that intervals are those of the noise that the residuals show and only the ratios
//! of stated deviations matter. A reading whose robust weight is [`OUTLIER`] or less determines nothing and is not counted
//! in `m`; a prior counts as a reading.
//!
//! # Robust losses
//! Of an M-estimator, `psi` being its influence and rows of one robust scale going together,
//!
//! ```text
//!   C = K^2 H^-1 (sum_i mean(psi^2) J_i' J_i) H^-1 m / (m - n)     H = sum_i mean(psi') J_i' J_i     K = 1 + n / m var(psi') / mean(psi')^2
//! ```
//!
//! (Huber and Ronchetti, *Robust Statistics*, 2nd ed., 2009, equation 7.81). `s` is then that of the median absolute deviation: outliers,
//! for whose sake the loss was chosen, are no noise.
//!
//! # Readings of one configuration
//! Where configurations have several readings, these may share errors ([`super::shared`]): with `V = s^2 I + sum_i t_i Z_i
//! Z_i'` their estimated covariance, that of the parameters is the exact one of this estimate under it,
//!
//! ```text
//!   C = (J' W J)^-1 J' W^1/2 V W^1/2 J (J' W J)^-1
//! ```
//!
//! A variance that is made of mean squares between and within configurations has, by Satterthwaite (*Biometrics Bulletin* 2,
//! 1946), `2 C^2 / var(C)` degrees of freedom: where repeats count, nearly those between configurations. Parts that come out
//! at zero, or whose test has a chance above one in four, leave the plain formula; below it they are used, significant or not,
//! so that intervals hold also where the test has little power. Exact copies of readings are left out. With a robust loss the covariance of
//! the M-estimator is widened by the ratio of these two, of squares with the robust weights.
//!
//! # Intervals
//! Intervals are two-sided, 95 %, of Student's t with these degrees of freedom: `C_kk^(1/2) t`. They hold for one
//! parameter at a time, not for all together, and to first order: not near a bound, and not for a parameter whose
//! influence changes over its own interval. What is dropped by the reduction has no interval; its effect is in the kept
//! parameters it was merged into.
//!
//! Columns are scaled to length one and decomposed by singular values ([`crate::math::linear::cofactor`]); directions that
//! no reading determines get variance zero instead of infinite, which the reduction before the fit prevents.

use nalgebra::{DMatrix, DVector, DVectorView};

use super::robust::deviation;
use super::shared::{Components, SharedError, Sharing};
use crate::least_squares::Loss;
use crate::math::linear::{cofactor, factored};
use crate::math::quantiles::t95;

/// Robust weight at or below which a reading counts as an outlier that determines nothing. Tukey's loss gives 0 beyond its
/// scale; Huber's and Cauchy's reach this only at hundreds of standard deviations.
const OUTLIER: f64 = 1e-3;

/// Mean slope of the influence below which it says nothing of the rows: with Huber's loss three quarters of them are then outliers. A judgement.
const LEAST_SLOPE: f64 = 0.25;

/// Covariance of the parameters of a fit, in the order of its columns.
#[derive(Debug, Clone)]
pub struct Covariance {
    /// C (n x n), in the products of the parameters' units (SI).
    pub matrix: DMatrix<f64>,
    /// Standard deviation of the weighted residuals: 1 where the noise is as stated.
    pub noise_ratio: f64,
    /// Residuals and priors that determine something, less parameters, at least 1.
    pub freedom: f64,
    /// Of the variance of each parameter (n): residuals and priors that determine something, less parameters, at least 1;
    /// fewer where readings of a configuration share errors.
    pub degrees_of_freedom: Vec<f64>,
    /// What readings of a configuration share, where that is more than nothing.
    pub shared: Option<SharedError>,
    /// `var(psi') / mean(psi')^2` of a robust loss, mean over the rows; zero with squares.
    slopes: f64,
}

impl Covariance {
    /// From weighted residuals (m), their Jacobian (m x n) and robust weights (m), of which the last `priors` rows are
    /// priors.
    pub fn new(residual: &DVector<f64>, jacobian: &DMatrix<f64>, weights: &DVector<f64>, priors: usize) -> Self {
        let data = weights.len() - priors;
        let counted = weights.iter().take(data).filter(|weight| **weight > OUTLIER).count() + priors;
        let degrees_of_freedom = (counted as f64 - jacobian.ncols() as f64).max(1.0);
        let squares: f64 = residual.iter().zip(weights).map(|(r, w)| w * r * r).sum();
        let noise_ratio = (squares / degrees_of_freedom).sqrt();
        let weighted =
            DMatrix::from_fn(jacobian.nrows(), jacobian.ncols(), |i, j| jacobian[(i, j)] * weights[i].sqrt());
        let matrix = cofactor(&weighted) * noise_ratio.powi(2);
        let (freedom, degrees_of_freedom) = (degrees_of_freedom, vec![degrees_of_freedom; jacobian.ncols()]);
        Self { matrix, noise_ratio, freedom, degrees_of_freedom, shared: None, slopes: 0.0 }
    }

    /// The same of a fit with a robust loss, which is given for each row with its scale: that of a prior is of squares. Unchanged where most
    /// of the rows of a scale are beyond it.
    #[must_use]
    pub fn robust(self, residual: &DVector<f64>, jacobian: &DMatrix<f64>, losses: &[Loss]) -> Self {
        let (m, n) = (residual.len() as f64, jacobian.ncols() as f64);
        let correction = m / (m - n).max(1.0);
        let mut kinds: Vec<Loss> = Vec::new();
        losses.iter().for_each(|loss| {
            if !kinds.contains(loss) {
                kinds.push(*loss)
            }
        });
        let mut by_row = vec![[1.0, 1.0]; losses.len()];
        let mut slopes = 0.0;
        for kind in kinds.into_iter().filter(|kind| *kind != Loss::Squares) {
            let rows: Vec<usize> = (0..losses.len()).filter(|&row| losses[row] == kind).collect();
            let count = rows.len() as f64;
            let mean = |of: &dyn Fn(f64) -> f64| rows.iter().map(|&row| of(residual[row])).sum::<f64>() / count;
            let slope = mean(&|r| kind.slope(r));
            if slope < LEAST_SLOPE {
                return self;
            }
            let spread = mean(&|r| (kind.slope(r) - slope).powi(2));
            let varies = spread / slope.powi(2);
            slopes += varies * count / m;
            let factor = 1.0 + n / m * varies;
            let influence = correction * factor.powi(2) * mean(&|r| (r * kind.weight(r)).powi(2));
            rows.into_iter().for_each(|row| by_row[row] = [slope, influence]);
        }
        let scaled = |k: usize| {
            DMatrix::from_fn(jacobian.nrows(), jacobian.ncols(), |i, j| jacobian[(i, j)] * by_row[i][k].sqrt())
        };
        let (inverse, influences) = (cofactor(&scaled(0)), scaled(1));
        let of_data = residual.iter().zip(losses).filter(|(_, loss)| **loss != Loss::Squares).map(|(r, _)| *r);
        let noise_ratio = correction.sqrt() * deviation(of_data).unwrap_or(0.0);
        Self { matrix: &inverse * influences.tr_mul(&influences) * &inverse, noise_ratio, slopes, ..self }
    }

    /// The same where the rows of readings go together as said.
    #[must_use]
    pub fn sharing(
        self,
        residual: &DVector<f64>,
        jacobian: &DMatrix<f64>,
        weights: &DVector<f64>,
        sharing: &Sharing,
    ) -> Self {
        let scales: Vec<f64> = weights.iter().map(|w| if *w > OUTLIER { w.sqrt() } else { 0.0 }).collect();
        let residual = DVector::from_fn(residual.len(), |i, _| residual[i] * scales[i]);
        let weighted = DMatrix::from_fn(jacobian.nrows(), jacobian.ncols(), |i, j| jacobian[(i, j)] * scales[i]);
        let Some((basis, root)) = factored(&weighted) else { return self };
        let Some(Components { error, own, between }) = sharing.components(&residual, &basis, &scales) else {
            return self;
        };
        let own_part = &root * root.transpose();
        let shared_part = &root * between * root.transpose();
        // C = b (B - s^2) + c s^2 of the mean squares B between and s^2 within.
        let [b, s] = [error.ratio * own, own];
        let degrees = |k: usize| {
            let (c, shared) = (own_part[(k, k)], shared_part[(k, k)]);
            let of_between = if b > s { shared / (b - s) } else { 0.0 };
            let spread = (of_between * b).powi(2) / error.between + ((c - of_between) * s).powi(2) / error.within;
            let degrees = (shared + c * s).powi(2) / spread;
            if degrees.is_finite() { degrees.max(1.0) } else { error.between }
        };
        let degrees_of_freedom = (0..jacobian.ncols()).map(degrees).collect();
        Self { matrix: own_part * own + shared_part, degrees_of_freedom, shared: Some(error), ..self }
    }

    /// A robust fit's, as much wider for each parameter as `shared`, where readings go together, is than `plain`, where they do not: both of
    /// squares with the robust weights. Readings that go together count as fewer, so that K grows: as many as the variance has degrees of
    /// freedom, and parameters.
    #[must_use]
    pub fn as_wide(self, plain: &Self, shared: Self) -> Self {
        let n = self.matrix.ncols() as f64;
        let correction = |degrees: f64| 1.0 + n / (degrees + n) * self.slopes;
        let of = |k: usize| {
            let wider = shared.matrix[(k, k)] / plain.matrix[(k, k)];
            let wider = if wider.is_finite() { wider.sqrt() } else { 1.0 };
            wider * correction(shared.degrees_of_freedom[k]) / correction(self.freedom)
        };
        let ratios = DVector::from_fn(self.matrix.ncols(), |k, _| of(k));
        let matrix = self.matrix.component_mul(&(&ratios * ratios.transpose()));
        Self { matrix, degrees_of_freedom: shared.degrees_of_freedom, shared: shared.shared, ..self }
    }

    /// Half width of the 95 % interval of each parameter (n), in its unit.
    pub fn ci95(&self) -> Vec<f64> {
        let widths = self.matrix.diagonal().map(|variance| variance.max(0.0).sqrt());
        widths.iter().zip(&self.degrees_of_freedom).map(|(width, degrees)| t95(*degrees) * width).collect()
    }

    /// Correlations (n x n), between -1 and 1.
    pub fn correlation(&self) -> DMatrix<f64> {
        let deviations = self.matrix.diagonal().map(f64::sqrt);
        let size = &deviations * deviations.transpose();
        self.matrix.zip_map(&size, |covariance, size| covariance / size.max(f64::MIN_POSITIVE))
    }

    /// Variance of a quantity whose derivative by the parameters is `row` (n).
    pub fn variance(&self, row: &[f64]) -> f64 {
        let row = DVectorView::from_slice(row, row.len());
        (&self.matrix * row).dot(&row)
    }
}
