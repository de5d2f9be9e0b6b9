//! Summaries of samples.

/// Mean, root mean square and greatest of a set of magnitudes; zeros for none.
pub fn mean_rms_max(values: impl Iterator<Item = f64>) -> [f64; 3] {
    let (mut n, mut sum, mut squares, mut max) = (0.0, 0.0, 0.0, 0.0_f64);
    for value in values {
        n += 1.0;
        sum += value;
        squares += value * value;
        max = max.max(value.abs());
    }
    if n == 0.0 { [0.0; 3] } else { [sum / n, f64::sqrt(squares / n), max] }
}

/// Euclidean norm of some values.
pub fn norm<'a>(values: impl IntoIterator<Item = &'a f64>) -> f64 {
    values.into_iter().map(|value| value * value).sum::<f64>().sqrt()
}

/// The different ones of some values, ascending.
pub(crate) fn distinct<T: Ord>(values: impl IntoIterator<Item = T>) -> Vec<T> {
    let mut values: Vec<T> = values.into_iter().collect();
    values.sort_unstable();
    values.dedup();
    values
}

/// Least and greatest of some values; of none +inf and -inf.
pub(crate) fn extremes(values: impl IntoIterator<Item = f64>) -> [f64; 2] {
    values.into_iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[least, most], v| [least.min(v), most.max(v)])
}

/// Median; `None` of none.
///
/// ```
/// assert_eq!(elastogeo::math::median(&mut [3.0, 1.0, 2.0]), Some(2.0));
/// ```
pub fn median(values: &mut [f64]) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    let upper = *values.get(values.len() / 2)?;
    Some(if values.len() % 2 == 1 { upper } else { 0.5 * (values[values.len() / 2 - 1] + upper) })
}
