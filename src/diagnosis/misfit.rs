//! How much of an error a law misses at its site: what it leaves there, from configuration to configuration, along the
//! joint's angle.
//!
//! Noise does not correlate between neighbours. What neighbours share of the errors that are left at a site is of another
//! shape than the law, whatever the readings of one configuration share. Measured without a noise that is known, and with
//! any number of markers.
//!
//! Source: von Neumann, *Distribution of the ratio of the mean square successive difference to the variance*, Ann. Math. Stat.
//! 12, 1941; significance by permutation, as in [`super::autocorrelation`].

use nalgebra::{DMatrix, DVector};

use super::autocorrelation::Series;
use super::free_errors::FreeErrors;
use super::linear_problem::LinearProblem;
use super::settings::ClaimSettings;
use crate::description::campaign::Campaign;
use crate::effects::{Site, SiteKind};
use crate::math::project_off;
use crate::model::Model;

/// Share of a law's contribution at a site that carries its free error, below which another error is meant than that.
const ITS_OWN: f64 = 0.5;

/// The readings that errors are looked at along.
#[derive(Clone, Copy)]
pub struct Readings<'a> {
    pub campaign: &'a Campaign,
    /// The first of each configuration of the problem.
    pub first: &'a [Option<usize>],
    /// The robot.
    pub model: &'a Model,
}

/// The first reading of each configuration; `None` of constraints, which are no readings.
pub fn first_readings(problem: &LinearProblem, campaign: &Campaign) -> Vec<Option<usize>> {
    let first = |pose: &usize| problem.pose.iter().position(|own| own == pose).map(|row| problem.reading[row]);
    problem.poses().iter().map(|pose| first(pose).filter(|reading| *reading < campaign.readings.len())).collect()
}

impl Readings<'_> {
    /// A coordinate in each configuration; `None` of constraints.
    pub fn positions(&self, coordinate: usize) -> Vec<Option<f64>> {
        let followers = self.model.followers();
        let position = |reading: usize| {
            let q = self.campaign.configuration(reading);
            let of_follower = || Some(followers.get(coordinate.checked_sub(q.len())?)?.of(q));
            q.get(coordinate).copied().or_else(of_follower)
        };
        self.first.iter().map(|reading| position((*reading)?)).collect()
    }
}

/// Share of the error at a joint that a law misses, of what it takes away there and what it misses; 0 where that may be chance.
/// `columns` are the law's, orthonormal, and `before` is what the other causes leave; both off what is
/// fitted with them.
pub fn missed(
    free: &FreeErrors,
    site: &Site,
    (before, columns): (&DVector<f64>, &DMatrix<f64>),
    readings: Readings,
    settings: &ClaimSettings,
) -> f64 {
    if site.kind != SiteKind::Joint {
        return 0.0;
    }
    let after = project_off(before, columns);
    let fitted = before - &after;
    let (Some(own), Some(left)) = (free.amounts(&site.name, &fitted), free.amounts(&site.name, &after)) else {
        return 0.0;
    };
    let taken: f64 = own.iter().map(|amount| amount * amount).sum();
    if taken < ITS_OWN * fitted.norm_squared() {
        return 0.0;
    }
    let Some(coordinate) = site.coordinate else { return 0.0 };
    let angles = readings.positions(coordinate);
    let known = angles.iter().take(left.len()).enumerate();
    let mut order: Vec<(f64, usize)> = known.filter_map(|(pose, angle)| Some(((*angle)?, pose))).collect();
    order.sort_by(|a, b| a.0.total_cmp(&b.0));
    let Some(series) = Series::new(order.into_iter().map(|(_, pose)| left[pose]).collect()) else { return 0.0 };
    let (shared, p) = series.tested(settings.flips, settings.seed);
    if p < settings.chance { shared / (shared + taken) } else { 0.0 }
}
