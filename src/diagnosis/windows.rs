//! Windows of a joint's angle: a few of its angles, wherever they are.

use std::f64::consts::{PI, TAU};

use nalgebra::DVector;

use super::free_errors::FreeErrors;
use super::linear_problem::LinearProblem;
use crate::description::campaign::Campaign;
use crate::effects::{Site, SiteKind};
use crate::math::extremes;
use crate::model::Model;

/// Half widths of the windows that are tried, rad: 5 to 40 deg. Wider ones are a swing of the joint's angle themselves.
const HALF_WIDTHS: [f64; 4] = [PI / 36.0, PI / 18.0, PI / 9.0, 2.0 * PI / 9.0];
/// Least number of configurations within a window: fewer are outliers, unless several points of each say otherwise.
pub const LEAST: usize = 3;
/// Weight from which a configuration is within a window: at its rim next to nothing shows.
const WITHIN: f64 = 0.1;

/// A raised cosine of the angle, the same after a whole turn.
#[derive(Debug, Clone, Copy)]
pub struct Window {
    /// Angle at which its weight is 1, rad.
    pub centre: f64,
    /// Angle from there at which it is 0, rad.
    pub half_width: f64,
}

impl Window {
    /// From 1 at the centre to 0 at the half width.
    fn weight(&self, angle: f64) -> f64 {
        let off = (angle - self.centre).rem_euclid(TAU);
        let off = off.min(TAU - off) / self.half_width;
        if off < 1.0 { 0.5 * (1.0 + (PI * off).cos()) } else { 0.0 }
    }
}

/// Half overlapping, over the range of the angles (rad), one of each configuration; each holds so many at least.
fn windows(angles: &[f64], least: usize) -> Vec<Window> {
    let [low, high] = extremes(angles.iter().copied());
    let of_width = |half_width: f64| {
        let count = ((high - low).clamp(0.0, TAU) / half_width).floor() as usize;
        (0..=count).map(move |k| Window { centre: low + k as f64 * half_width, half_width })
    };
    let holds_enough = |window: &Window| angles.iter().filter(|angle| window.weight(**angle) > WITHIN).count() >= least;
    HALF_WIDTHS.into_iter().flat_map(of_width).filter(holds_enough).collect()
}

/// Calls `look` with each window of each joint that turns and holds `least` configurations, as [`of_joint`], and the joint's site.
pub fn each(
    (model, campaign): (&Model, &Campaign),
    problem: &LinearProblem,
    free: &FreeErrors,
    least: usize,
    mut look: impl FnMut(&Site, Window, &DVector<f64>),
) {
    for site in model.sites(SiteKind::Joint) {
        of_joint((model, campaign), problem, free, (&site, least), |window, column| look(&site, window, column));
    }
}

/// Calls `look` with each window of a joint that turns and has a variable of its own: with what an error of 1 rad there, within the window,
/// moves the rows of a problem by, over their sigmas. `problem` holds the readings of `campaign`.
pub fn of_joint(
    (model, campaign): (&Model, &Campaign),
    problem: &LinearProblem,
    free: &FreeErrors,
    (site, least): (&Site, usize),
    mut look: impl FnMut(Window, &DVector<f64>),
) {
    let is_angle = |of: &usize| model.variables.get(*of).is_some_and(|own| own.is_angle);
    let (Some(variable), Some(joint)) = (site.coordinate.filter(is_angle), free.column(&site.name)) else { return };
    let angles: Vec<f64> = (0..campaign.readings.len()).map(|k| campaign.configuration(k)[variable]).collect();
    let mut seen = vec![false; campaign.poses.len()];
    let is_first = |k: &usize| !std::mem::replace(&mut seen[campaign.readings[*k].pose], true);
    let one_of_each: Vec<f64> = (0..angles.len()).filter(is_first).map(|k| angles[k]).collect();
    for window in windows(&one_of_each, least) {
        // Constraints are no readings.
        let weight = |row: usize| angles.get(problem.reading[row]).map_or(0.0, |angle| window.weight(*angle));
        look(window, &DVector::from_fn(problem.rows(), |row, _| joint[row] * weight(row)));
    }
}
