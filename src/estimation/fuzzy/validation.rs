//! Whether rules help readings that they were not fitted to.

use rayon::prelude::*;

use super::grown::Grown;
use super::samples::Samples;

/// Root mean square displacement (distance, m) of the fitted samples when parts of the configurations are left out in
/// turns: without rules, and with those that `grow` makes of the others. The structure is grown anew for each part, so that
/// what is left out has no influence on it.
pub fn nested(samples: &Samples, folds: usize, grow: &(dyn Fn(&Samples) -> Grown + Sync)) -> [f64; 2] {
    let fitted = samples.indices(false, |_| true);
    let parts = samples.parts(&fitted, folds);
    let distance = |d: &[f64; 6]| d[..3].iter().map(|v| v * v).sum::<f64>();
    let squares = |part: usize| {
        let left_out: Vec<bool> = parts.iter().map(|own| *own == part).collect();
        let own = samples.only(&fitted, left_out);
        let grown = grow(&own);
        own.indices(true, |_| true).into_iter().map(|k| distance(&grown.residual(&own, k))).sum::<f64>()
    };
    let with: Vec<f64> = (0..folds).into_par_iter().map(squares).collect();
    let without: f64 = fitted.iter().map(|&k| distance(&samples.d[k])).sum();
    [without, with.iter().sum()].map(|squares| (squares / fitted.len().max(1) as f64).sqrt())
}
