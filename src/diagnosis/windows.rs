//! Windows of a joint's angle: a few of its angles, wherever they are.

use std::f64::consts::{PI, TAU};

/// Half widths of the windows that are tried, rad: 5 to 40 deg. Wider ones are a swing of the joint's angle themselves.
const HALF_WIDTHS: [f64; 4] = [PI / 36.0, PI / 18.0, PI / 9.0, 2.0 * PI / 9.0];
/// Least number of configurations within a window: fewer are outliers.
pub const LEAST: usize = 3;

/// A raised cosine of the angle, the same after a whole turn.
#[derive(Debug, Clone, Copy)]
pub struct Window {
    centre: f64,
    half_width: f64,
}

impl Window {
    /// From 1 at the centre to 0 at the half width.
    pub fn weight(&self, angle: f64) -> f64 {
        let off = (angle - self.centre).rem_euclid(TAU);
        let off = off.min(TAU - off) / self.half_width;
        if off < 1.0 { 0.5 * (1.0 + (PI * off).cos()) } else { 0.0 }
    }
}

/// Half overlapping, over the range of the angles (rad), one of each configuration.
pub fn windows(angles: &[f64]) -> Vec<Window> {
    let low = angles.iter().copied().fold(f64::INFINITY, f64::min);
    let high = angles.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let of_width = |half_width: f64| {
        let count = ((high - low).clamp(0.0, TAU) / half_width).floor() as usize;
        (0..=count).map(move |k| Window { centre: low + k as f64 * half_width, half_width })
    };
    let holds_enough = |window: &Window| angles.iter().filter(|angle| window.weight(**angle) > 0.1).count() >= LEAST;
    HALF_WIDTHS.into_iter().flat_map(of_width).filter(holds_enough).collect()
}
