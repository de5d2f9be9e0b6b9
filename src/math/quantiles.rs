//! Quantiles and tails of the distributions that intervals and tests are made of. Every interval of the library is two-sided
//! and holds 95 %. Nothing else asks the distributions: what is not finite is answered here and never reaches them.

use std::sync::LazyLock;

use statrs::distribution::{Binomial, ContinuousCDF, DiscreteCDF, FisherSnedecor, Normal, StudentsT};

/// Probability below the upper end of a two-sided 95 % interval.
const UPPER: f64 = 0.975;

/// Half width of the two-sided 95 % interval of a standard normal variable, 1.959964: the standard deviation is known.
pub fn normal95() -> f64 {
    static QUANTILE: LazyLock<f64> = LazyLock::new(|| Normal::standard().inverse_cdf(UPPER));
    *QUANTILE
}

/// Standard normal deviate that each of `count` tests must exceed for any of them to do so by chance with at most `probability`
/// (Bonferroni).
///
/// ```
/// use elastogeo::math::quantiles::normal_of_any;
///
/// assert!((normal_of_any(0.025, 1) - 1.959964).abs() < 1e-6);
/// assert!((normal_of_any(0.05, 250) - 3.5401).abs() < 1e-4); // tables, at 2e-4
/// ```
pub fn normal_of_any(probability: f64, count: usize) -> f64 {
    -Normal::standard().inverse_cdf((probability / count.max(1) as f64).clamp(f64::MIN_POSITIVE, 1.0))
}

/// Degrees of freedom from which the quantile of Student's t is that of the normal distribution with three terms of its
/// expansion (Abramowitz and Stegun, 26.7.5), right to 1e-11. The library's inversion of the incomplete beta function is wrong by
/// 1e-4 at 1e6 of them, and never ends at 1e8.
const MANY: f64 = 1e3;

/// Half width of the two-sided 95 % interval of Student's t: the standard deviation is estimated with so many degrees of
/// freedom. Infinite where none is left (0 or fewer, or not a number); that of a normal variable for infinitely many.
pub fn t95(degrees_of_freedom: f64) -> f64 {
    if degrees_of_freedom > MANY {
        let (z, n) = (normal95(), degrees_of_freedom);
        let of = |coefficients: [f64; 4]| coefficients.iter().fold(0.0, |sum, c| sum * z * z + c) * z;
        return z
            + of([0.0, 0.0, 1.0, 1.0]) / (4.0 * n)
            + of([0.0, 5.0, 16.0, 3.0]) / (96.0 * n * n)
            + of([3.0, 19.0, 17.0, -15.0]) / (384.0 * n * n * n);
    }
    t_quantile(UPPER, degrees_of_freedom)
}

/// Standard deviation of normal noise over the median of its magnitude.
pub const OF_MEDIAN: f64 = 1.4826;

/// The same over the lower quartile of its magnitude.
pub const OF_QUARTER: f64 = 3.1383;

/// Scale of Huber's loss, in standard deviations, with which it is 95 % efficient on normal noise (Huber, *Ann. Math. Statist.* 35, 1964).
pub const HUBER: f64 = 1.345;

/// Scale of Tukey's biweight, in standard deviations, with which it is 95 % efficient on normal noise (Beaton and Tukey, *Technometrics* 16, 1974).
pub const TUKEY: f64 = 4.685;

/// Value below which a standard normal variable lies with a probability between 0 and 1.
pub fn normal_quantile(probability: f64) -> f64 {
    Normal::standard().inverse_cdf(probability.clamp(f64::MIN_POSITIVE, 1.0 - f64::EPSILON))
}

/// The same of Student's t with so many degrees of freedom; infinite where these are none, or not finite.
pub fn t_quantile(probability: f64, degrees_of_freedom: f64) -> f64 {
    let known = StudentsT::new(0.0, 1.0, degrees_of_freedom).ok().filter(|_| degrees_of_freedom.is_finite());
    known.map_or(f64::INFINITY, |t| t.inverse_cdf(probability.clamp(f64::MIN_POSITIVE, 1.0 - f64::EPSILON)))
}

/// Probability that Fisher's F with so many degrees of freedom is `ratio` or more. An infinite ratio, of something to
/// nothing, is never chance: 0. A ratio that is no number (nothing to nothing), or degrees that are not finite and positive,
/// show nothing: 1.
pub fn f_tail(ratio: f64, numerator: f64, denominator: f64) -> f64 {
    let is_usable = |degrees: f64| degrees.is_finite() && degrees > 0.0;
    if !(is_usable(numerator) && is_usable(denominator)) || ratio.is_nan() || ratio <= 0.0 {
        return 1.0;
    }
    if ratio == f64::INFINITY {
        return 0.0;
    }
    // The incomplete beta function is asked at d1 x / (d1 x + d2), which must not overflow either.
    let greatest = f64::MAX / numerator.max(denominator) / 4.0;
    FisherSnedecor::new(numerator, denominator).map_or(1.0, |f| f.sf(ratio.min(greatest)))
}

/// Ends of the two-sided 95 % interval of Fisher's F; with infinitely many degrees of freedom of the denominator that of chi-square
/// over its degrees.
///
/// ```
/// use elastogeo::math::quantiles::f_interval95;
///
/// let [low, high] = f_interval95(3.0, f64::INFINITY);
/// assert!((3.0 * low - 0.2158).abs() < 1e-4 && (3.0 * high - 9.3484).abs() < 1e-4); // tables of chi-square
/// assert!((f_interval95(3.0, 10.0)[1] - 4.8256).abs() < 1e-4);
/// ```
pub fn f_interval95(numerator: f64, denominator: f64) -> [f64; 2] {
    // Beyond so many the denominator is 1 to rounding.
    let denominator = denominator.clamp(1.0, 1e6);
    let at = |tail: f64| {
        let (mut low, mut high) = (-40.0_f64, 40.0_f64);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if f_tail(middle.exp(), numerator, denominator) > tail { low = middle } else { high = middle }
        }
        (0.5 * (low + high)).exp()
    };
    [at(UPPER), at(1.0 - UPPER)]
}

/// Probability that a variable of Student's t with so many degrees of freedom (at least one) is farther from 0 than `t`.
///
/// ```
/// use elastogeo::math::quantiles::{t95, two_sided_t};
///
/// assert!((two_sided_t(-t95(7.0), 7.0) - 0.05).abs() < 1e-9);
/// ```
pub fn two_sided_t(t: f64, degrees_of_freedom: f64) -> f64 {
    // Beyond so many the distribution is normal to rounding.
    let degrees_of_freedom = degrees_of_freedom.clamp(1.0, 1e9);
    StudentsT::new(0.0, 1.0, degrees_of_freedom).map_or(1.0, |of| 2.0 * of.cdf(-t.abs()))
}

/// Probability that of `count` fair coins as many or more fall on one side, whichever, as `heads` and the rest do: the sign test.
///
/// ```
/// use elastogeo::math::quantiles::two_sided_sign;
///
/// assert!((two_sided_sign(9, 10) - 22.0 / 1024.0).abs() < 1e-12); // 10 + 1 of 1024, on either side
/// assert_eq!(two_sided_sign(5, 10), 1.0);
/// assert_eq!(two_sided_sign(0, 0), 1.0);
/// ```
pub fn two_sided_sign(heads: usize, count: usize) -> f64 {
    let fewer = heads.min(count - heads.min(count)) as u64;
    Binomial::new(0.5, count as u64).map_or(1.0, |coins| (2.0 * coins.cdf(fewer)).min(1.0))
}
