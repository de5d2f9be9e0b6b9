//! How much a large residual counts.

use nalgebra::DVector;

use super::problem::Problem;

/// The function `rho` in the cost `1/2 sum rho(r^2)`.
///
/// The number is a scale `k` in units of the residual; with residuals in standard deviations the values quoted give 95 %
/// efficiency when the noise is normal after all (Huber and Ronchetti 2009; Holland and Welsch 1977).
///
/// The weight of a residual is `rho'(r^2)`, so that the gradient is `J' W r`. All losses here are concave in `r^2`, hence
/// the weighted quadratic lies above the true cost and touches it: a reweighted step that lowers the one lowers the other,
/// and no second-derivative correction is needed to keep the model convex.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Loss {
    /// `rho(s) = s`: plain least squares.
    #[default]
    Squares,
    /// Quadratic up to `k`, then linear; 1.345. Convex: no new local minima.
    Huber(f64),
    /// `k^2 ln(1 + s / k^2)`; 2.385. Outliers fade but never vanish.
    Cauchy(f64),
    /// Constant beyond `k`; 4.685. Outliers have no influence at all, so the start must be fair.
    Tukey(f64),
}

impl Loss {
    /// The scale, if the loss has one.
    pub fn scale(self) -> Option<f64> {
        match self {
            Self::Squares => None,
            Self::Huber(k) | Self::Cauchy(k) | Self::Tukey(k) => Some(k),
        }
    }

    /// `rho(r^2)`.
    pub fn value(self, residual: f64) -> f64 {
        let square = residual * residual;
        match self {
            Self::Squares => square,
            Self::Huber(k) if residual.abs() <= k => square,
            Self::Huber(k) => 2.0 * k * residual.abs() - k * k,
            Self::Cauchy(k) => k * k * (square / (k * k)).ln_1p(),
            Self::Tukey(k) => {
                let inside = (1.0 - square / (k * k)).max(0.0);
                k * k / 3.0 * (1.0 - inside.powi(3))
            }
        }
    }

    /// `rho'(r^2)`, between 0 and 1.
    pub fn weight(self, residual: f64) -> f64 {
        match self {
            Self::Squares => 1.0,
            Self::Huber(k) if residual.abs() <= k => 1.0,
            Self::Huber(k) => k / residual.abs(),
            Self::Cauchy(k) => 1.0 / (1.0 + (residual / k).powi(2)),
            Self::Tukey(k) => (1.0 - (residual / k).powi(2)).max(0.0).powi(2),
        }
    }

    /// `psi'(r)`, the slope of the influence `psi(r) = r rho'(r^2)`: 1 near zero, below zero where an influence falls off.
    pub fn slope(self, residual: f64) -> f64 {
        match self {
            Self::Squares => 1.0,
            Self::Huber(k) => f64::from(u8::from(residual.abs() <= k)),
            Self::Cauchy(k) => {
                let square = (residual / k).powi(2);
                (1.0 - square) / (1.0 + square).powi(2)
            }
            Self::Tukey(k) => {
                let square = (residual / k).powi(2);
                if square < 1.0 { (1.0 - square) * (1.0 - 5.0 * square) } else { 0.0 }
            }
        }
    }

    /// The same loss with its scale times `factor`; plain squares where that is infinite.
    #[must_use]
    pub fn scaled(self, factor: f64) -> Self {
        match self {
            _ if factor == f64::INFINITY => Self::Squares,
            Self::Squares => Self::Squares,
            Self::Huber(k) => Self::Huber(k * factor),
            Self::Cauchy(k) => Self::Cauchy(k * factor),
            Self::Tukey(k) => Self::Tukey(k * factor),
        }
    }
}

/// The loss of each residual of a problem; `None` for plain squares.
pub(super) struct Losses(Option<Vec<Loss>>);

impl Losses {
    pub fn new(problem: &impl Problem, loss: Loss) -> Self {
        let each = || (0..problem.residuals()).map(|row| loss.scaled(problem.tuning(row))).collect();
        Self((loss != Loss::Squares).then(each))
    }

    /// Robust weights (m); `None` where all are 1.
    pub fn weights(&self, residual: &DVector<f64>) -> Option<DVector<f64>> {
        let weight = |(loss, r): (&Loss, &f64)| loss.weight(*r);
        self.0.as_ref().map(|losses| DVector::from_iterator(residual.len(), losses.iter().zip(residual).map(weight)))
    }

    /// `1/2 sum rho(r^2)`.
    pub fn cost(&self, residual: &DVector<f64>) -> f64 {
        let value = |(loss, r): (&Loss, &f64)| loss.value(*r);
        match &self.0 {
            None => 0.5 * residual.norm_squared(),
            Some(losses) => 0.5 * losses.iter().zip(residual).map(value).sum::<f64>(),
        }
    }

    /// Cost at `before` minus cost at `after`, summed term by term: the difference of the two sums would lose the last
    /// digits just where they decide whether a tiny step is an improvement.
    pub fn reduction(&self, before: &DVector<f64>, after: &DVector<f64>) -> f64 {
        let pairs = before.iter().zip(after);
        match &self.0 {
            None => 0.5 * pairs.map(|(b, a)| (b - a) * (b + a)).sum::<f64>(),
            Some(losses) => 0.5 * pairs.zip(losses).map(|((&b, &a), loss)| loss.value(b) - loss.value(a)).sum::<f64>(),
        }
    }
}
