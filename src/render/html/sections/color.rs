//! Colours of a heat map of shares or correlations.

use std::sync::Arc;

use crate::math::extremes;
use kuva::plot::ColorMap;

/// Colours from -1 (orange) over 0 (the paper) to 1 (blue), whatever the range of the numbers drawn: the chart hands on
/// where in it a number lies.
pub fn scale(rows: &[Vec<f64>]) -> ColorMap {
    let [low, high] = extremes(rows.iter().flatten().copied());
    ColorMap::Custom(Arc::new(move |share: f64| {
        let value = (low + share * (high - low)).clamp(-1.0, 1.0);
        let color = if value < 0.0 { "var(--orange)" } else { "var(--blue)" };
        format!("color-mix(in srgb, {color} {:.0}%, var(--paper))", 100.0 * value.abs())
    }))
}
