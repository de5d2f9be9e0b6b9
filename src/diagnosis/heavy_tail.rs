//! Noise with heavy tails: residuals beyond the others that are a part of it, and no outliers.
//!
//! Student's t is fitted to the bulk by quantiles, which the extremes do not enter; how far its tail reaches in so many residuals says
//! whether the extremes are of the same noise.
//!
//! Source: Lange, Little and Taylor, *Robust statistical modeling using the t distribution*, J. Am. Stat. Assoc. 84, 1989; the variance of a
//! sample quantile by David and Nagaraja, *Order Statistics*, 2003, ch. 10.

use crate::math::quantiles::{normal_quantile, t_quantile, two_sided_t};

/// Probabilities of the two quantiles of sizes that are compared: half of the residuals, and nearly all.
const QUANTILES: [f64; 2] = [0.5, 0.95];
/// Standard deviations by which the ratio of the quantiles must exceed that of normal noise: one in forty of normal noise does. A judgement;
/// simulated noise of three degrees of freedom was seen when it was set.
const CERTAIN: f64 = 2.0;
/// Least and greatest degrees of freedom of the tail: beyond these it is that of Cauchy's distribution, or of the normal.
const DEGREES: [f64; 2] = [1.0, 30.0];
/// Halvings of the interval of the degrees of freedom.
const HALVINGS: usize = 30;
/// Residuals below which a quantile of one in twenty is unknown.
const FEWEST: usize = 60;

/// Whether noise as that of the residuals, of which `sizes` are all but the extremes, reaches `farthest` with a probability above `chance`.
/// Never where the sizes may be those of normal noise.
pub fn reaches(mut sizes: Vec<f64>, farthest: f64, chance: f64) -> bool {
    let count = sizes.len();
    if count < FEWEST {
        return false;
    }
    sizes.sort_by(f64::total_cmp);
    let [half, most] = QUANTILES.map(|p| sizes[((count - 1) as f64 * p).round() as usize]);
    // Quantiles of sizes are those of the upper half of what is symmetric.
    let upper = QUANTILES.map(|p| (1.0 + p) / 2.0);
    let normal = upper.map(normal_quantile);
    // Of the greater quantile, to which the smaller adds little.
    let spread = (QUANTILES[1] * (1.0 - QUANTILES[1]) / count as f64).sqrt() / (2.0 * density(normal[1])) / normal[1];
    let [ratio, of_normal] = [most / half, normal[1] / normal[0]];
    if half <= 0.0 || ratio < of_normal * (1.0 + CERTAIN * spread) {
        return false;
    }
    let of = |degrees: f64| {
        let [half, most] = upper.map(|p| t_quantile(p, degrees));
        most / half
    };
    // The ratio falls with the degrees of freedom.
    let [mut least, mut greatest] = DEGREES;
    for _ in 0..HALVINGS {
        let middle = (least + greatest) / 2.0;
        if of(middle) > ratio { least = middle } else { greatest = middle }
    }
    let scale = half / t_quantile(upper[0], least);
    count as f64 * two_sided_t(farthest / scale, least) > chance
}

/// Density of the standard normal distribution.
fn density(z: f64) -> f64 {
    (-z * z / 2.0).exp() / (2.0 * std::f64::consts::PI).sqrt()
}
