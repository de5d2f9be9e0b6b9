//! A difference between checks with its covariance, and its tests.
//!
//! Estimates `x_k` of the checks are independent, with covariances `C_k`. They are taken as
//!
//! ```text
//!   x_k = N_k a + g_k d + noise
//! ```
//!
//! with what is known to go on (`N_k a`: a level, and the slopes of the constants that grow) and the change `d` with its course
//! `g_k`: 0 before and 1 after a step, the time of a line. Generalised least squares, each check with the weight of its information
//! `C_k^-1`, gives `d = sum A_k x_k`: for a step from level to level the mean after it less the mean before.
//! Then `C = sum A_k C_k A_k'`, and
//!
//! ```text
//!   all together   T2 = d' C^-1 d,  T2 / p of F(p, v)     (Hotelling's T2, each C_k estimated with v_k degrees of freedom)
//!   one alone      z = u' d / (u' C u)^1/2 of t(v),  u = C^-1 e_i
//! ```
//!
//! The second asks whether parameter `i` alone has changed, the others standing still: its estimate then is `u' d / u_i`, and its
//! deviation `u_i^-1/2` is smaller than that of the difference, the more so the more the estimates are correlated. Degrees of
//! freedom are Satterthwaite's: `1 / sum w_k^2 / v_k` with the shares `w_k` of the variance.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use crate::math::quantiles::{f_tail, two_sided_t};

/// A check's estimates, in units in which they are of the size of one.
#[derive(Debug, Clone)]
pub struct Scaled {
    /// When.
    pub time: f64,
    /// Values.
    pub values: DVector<f64>,
    /// Their covariance.
    pub covariance: DMatrix<f64>,
    /// Its inverse.
    pub information: DMatrix<f64>,
    /// Degrees of freedom of the covariance.
    pub freedom: f64,
}

/// What a check is expected to show: `N_k` of the text above.
pub type Design = DMatrix<f64>;

/// A difference between checks. Parameters are named by their place among all, also where it has only some of them.
pub struct Contrast {
    /// The parameters compared.
    of: Vec<usize>,
    difference: DVector<f64>,
    factor: Cholesky<f64, Dyn>,
    inverse: DMatrix<f64>,
    /// Parts of the covariance with their degrees of freedom.
    parts: Vec<(DMatrix<f64>, f64)>,
}

/// The change of a parameter where only those chosen change.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Amount {
    /// Which.
    pub parameter: usize,
    /// By how much.
    pub change: f64,
    /// Standard deviation.
    pub sigma: f64,
    /// Degrees of freedom.
    pub freedom: f64,
}

impl Contrast {
    /// The change of the parameters `of` with the course `g` (one of each check) in addition to what the checks are expected to show;
    /// `None` where they do not determine it.
    pub fn new(checks: &[Scaled], expected: &[Design], of: &[usize], course: &[f64]) -> Option<Self> {
        let size = checks.first()?.values.len();
        let pick = DMatrix::from_fn(size, of.len(), |row, column| f64::from(u8::from(of.get(column) == Some(&row))));
        let own: Vec<DMatrix<f64>> = course.iter().map(|g| &pick * *g).collect();
        let rows = || checks.iter().zip(expected).zip(&own);
        let known = rows().map(|((check, n), _)| n.transpose() * &check.information * n).reduce(|a, b| a + b)?;
        let both = rows().map(|((check, n), g)| g.transpose() * &check.information * n).reduce(|a, b| a + b)?;
        let change = rows().map(|((check, _), g)| g.transpose() * &check.information * g).reduce(|a, b| a + b)?;
        let along = &both * inverse(&known)?;
        let covariance = inverse(&(change - &along * both.transpose()))?;
        let mut difference = DVector::zeros(of.len());
        let mut sum = DMatrix::zeros(of.len(), of.len());
        let mut parts = Vec::with_capacity(checks.len());
        for ((check, n), g) in rows() {
            let weight = &covariance * (g.transpose() - &along * n.transpose()) * &check.information;
            difference += &weight * &check.values;
            let part = &weight * &check.covariance * weight.transpose();
            sum += &part;
            parts.push((part, check.freedom));
        }
        let factor = symmetric(sum).cholesky()?;
        let inverse = factor.inverse();
        Some(Self { of: of.to_vec(), difference, factor, inverse, parts })
    }

    /// The parameters compared.
    pub fn of(&self) -> &[usize] {
        &self.of
    }

    /// Number of parameters.
    pub fn parameters(&self) -> usize {
        self.of.len()
    }

    /// Places of parameters in this comparison; `None` where one is not in it.
    fn own(&self, parameters: &[usize]) -> Option<Vec<usize>> {
        parameters.iter().map(|wanted| self.of.iter().position(|known| known == wanted)).collect()
    }

    /// T2 of all parameters.
    pub fn t2(&self) -> f64 {
        self.difference.dot(&self.factor.solve(&self.difference))
    }

    /// Degrees of freedom of [`Contrast::t2`]'s denominator.
    pub fn freedom(&self) -> f64 {
        let share = |part: &DMatrix<f64>| self.inverse.dot(part) / self.parameters() as f64;
        freedom(self.parts.iter().map(|(part, freedom)| (share(part), *freedom)))
    }

    /// Probability of a T2 as great by chance.
    pub fn p_of_all(&self) -> f64 {
        p_of_t2(self.t2(), self.parameters(), self.freedom())
    }

    /// Probability, of each parameter but those `chosen`, of a change of it alone as great by chance, where those `chosen` change too.
    pub fn p_of_each(&self, chosen: &[usize]) -> Option<Vec<(usize, f64)>> {
        let rest = self.without(chosen)?;
        let p = |place: usize| {
            let u = rest.column(place).into_owned();
            let own = u.get(place).copied().unwrap_or(0.0);
            let z = u.dot(&self.difference) / own.max(f64::MIN_POSITIVE).sqrt();
            if own > 0.0 { two_sided_t(z, self.freedom_of(&u)) } else { 1.0 }
        };
        let left = self.of.iter().enumerate().filter(|(_, parameter)| !chosen.contains(parameter));
        Some(left.map(|(place, parameter)| (*parameter, p(place))).collect())
    }

    /// Probability of what `chosen` leave of T2.
    pub fn p_of_rest(&self, chosen: &[usize]) -> Option<f64> {
        let left = self.parameters().saturating_sub(chosen.len());
        Some(if left == 0 { 1.0 } else { p_of_t2(self.t2() - self.gain(chosen)?, left, self.freedom()) })
    }

    /// What `chosen` take off T2.
    pub fn gain(&self, chosen: &[usize]) -> Option<f64> {
        let (score, solved) = self.solved(chosen)?;
        Some(score.dot(&(solved * &score)))
    }

    /// Changes of `chosen` where no others change.
    pub fn amounts(&self, chosen: &[usize]) -> Option<Vec<Amount>> {
        let (score, solved) = self.solved(chosen)?;
        let found = &solved * score;
        let columns = self.inverse.select_columns(&self.own(chosen)?) * &solved;
        let amount = |(k, &parameter): (usize, &usize)| Amount {
            parameter,
            change: found[k],
            sigma: solved[(k, k)].max(0.0).sqrt(),
            freedom: self.freedom_of(&columns.column(k).into_owned()),
        };
        Some(chosen.iter().enumerate().map(amount).collect())
    }

    /// `E' C^-1 d` and `(E' C^-1 E)^-1` of the columns `E` chosen.
    fn solved(&self, chosen: &[usize]) -> Option<(DVector<f64>, DMatrix<f64>)> {
        let chosen = &self.own(chosen)?;
        let score = (&self.inverse * &self.difference).select_rows(chosen);
        let own = self.inverse.select_columns(chosen).select_rows(chosen);
        Some((score, inverse(&own)?))
    }

    /// `C^-1` with the columns `chosen` projected off.
    fn without(&self, chosen: &[usize]) -> Option<DMatrix<f64>> {
        if chosen.is_empty() {
            return Some(self.inverse.clone());
        }
        let (_, solved) = self.solved(chosen)?;
        let columns = self.inverse.select_columns(&self.own(chosen)?);
        Some(&self.inverse - &columns * solved * columns.transpose())
    }

    /// Degrees of freedom of the variance of `u' d`.
    fn freedom_of(&self, u: &DVector<f64>) -> f64 {
        let part = |part: &DMatrix<f64>| u.dot(&(part * u));
        let all: f64 = self.parts.iter().map(|(own, _)| part(own)).sum();
        freedom(self.parts.iter().map(|(own, freedom)| (part(own) / all.max(f64::MIN_POSITIVE), *freedom)))
    }
}

/// Probability of a T2 of so many parameters by chance. Where the covariance is as good as known, T2 is a chi-square, which
/// is F with many degrees of freedom.
pub fn p_of_t2(t2: f64, parameters: usize, freedom: f64) -> f64 {
    f_tail(t2 / parameters as f64, parameters as f64, freedom.min(KNOWN))
}

/// Degrees of freedom beyond which a covariance is as good as known.
const KNOWN: f64 = 1e7;

/// Satterthwaite's, of shares of a variance.
fn freedom(shares: impl Iterator<Item = (f64, f64)>) -> f64 {
    let sum: f64 = shares.map(|(share, freedom)| share * share / freedom).sum();
    (1.0 / sum.max(f64::MIN_POSITIVE)).clamp(1.0, KNOWN)
}

/// The checks' squares about the best fit of what they are expected to show; `None` where they do not determine it.
pub fn misfit(checks: &[Scaled], expected: &[Design]) -> Option<f64> {
    let rows = || checks.iter().zip(expected);
    let known = rows().map(|(check, n)| n.transpose() * &check.information * n).reduce(|a, b| a + b)?;
    let score = rows().map(|(check, n)| n.transpose() * &check.information * &check.values).reduce(|a, b| a + b)?;
    let found = inverse(&known)? * score;
    let left = |(check, n): (&Scaled, &Design)| {
        let left = &check.values - n * &found;
        left.dot(&(&check.information * &left))
    };
    Some(rows().map(left).sum())
}

fn symmetric(matrix: DMatrix<f64>) -> DMatrix<f64> {
    let turned = matrix.transpose();
    (matrix + turned) * 0.5
}

/// Inverse of a symmetric positive matrix.
pub fn inverse(matrix: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    Some(symmetric(matrix.clone()).cholesky()?.inverse())
}
