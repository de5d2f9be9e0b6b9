//! A pattern search in a box, for values that are slow to compute and have no derivatives.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

/// A point, its value, and what was found there.
pub struct At<T> {
    pub point: Vec<f64>,
    pub value: f64,
    pub found: T,
}

/// How the search proceeds.
pub struct Pattern {
    /// First and last step, as parts of the box.
    pub steps: [f64; 2],
    /// Directions drawn in addition to the axes and the last that helped.
    pub directions: usize,
    /// Least gain, as a part of the value, that is worth a move.
    pub worth: f64,
}

/// Moves from a point to lower values until the smallest step helps no more; both count the values computed. The trials of a
/// step are computed together, and the first of the lowest is taken, so that threads change nothing.
pub fn descend<T: Send + Sync>(
    mut at: At<T>,
    within: &[[f64; 2]],
    pattern: &Pattern,
    random: &mut ChaCha8Rng,
    value: impl Fn(&[f64], &T) -> Option<(f64, T)> + Sync,
) -> (At<T>, usize) {
    let widths: Vec<f64> = within.iter().map(|[low, high]| high - low).collect();
    let axes: Vec<usize> = (0..within.len()).filter(|&k| widths[k] > 0.0).collect();
    let (mut step, mut tried) = (pattern.steps[0], 0);
    let mut last: Option<Vec<f64>> = None;
    while step >= pattern.steps[1] && !axes.is_empty() {
        let mut directions: Vec<Vec<f64>> = last.iter().cloned().collect();
        for &axis in &axes {
            directions.extend(
                [1.0, -1.0].map(|sign| (0..within.len()).map(|k| if k == axis { sign } else { 0.0 }).collect()),
            );
        }
        if axes.len() > 1 {
            directions.extend(
                (0..pattern.directions).map(|_| widths.iter().map(|_| 2.0 * random.random::<f64>() - 1.0).collect()),
            );
        }
        let to = |direction: &Vec<f64>| -> Vec<f64> {
            let each = at.point.iter().zip(direction).zip(&widths).zip(within);
            each.map(|(((x, d), width), [low, high])| (x + step * d * width).clamp(*low, *high)).collect()
        };
        let trials: Vec<Vec<f64>> = directions.iter().map(to).filter(|trial| *trial != at.point).collect();
        tried += trials.len();
        let found: Vec<Option<(f64, T)>> = trials.par_iter().map(|trial| value(trial, &at.found)).collect();
        let mut best: Option<(f64, T, Vec<f64>)> = None;
        for (found, trial) in found.into_iter().zip(trials) {
            let Some((value, found)) = found else { continue };
            if value < best.as_ref().map_or(at.value * (1.0 - pattern.worth), |(least, ..)| *least) {
                best = Some((value, found, trial));
            }
        }
        match best {
            Some((value, found, point)) => {
                let by = point.iter().zip(&at.point).zip(&widths);
                last = Some(
                    by.map(|((new, old), width)| if *width > 0.0 { 2.0 * (new - old) / (width * step) } else { 0.0 })
                        .collect(),
                );
                at = At { point, value, found };
            }
            None => {
                step *= 0.5;
                last = None;
            }
        }
    }
    (at, tried)
}
