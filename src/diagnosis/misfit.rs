//! How much of an error a law misses at its site: what it leaves there, from configuration to configuration, along what
//! the error could follow.
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
use super::settings::ClaimSettings;
use crate::description::campaign::Campaign;
use crate::effects::{Site, SiteKind};
use crate::math::project_off;

/// Share of a law's contribution at a site that carries its free error, below which another error is meant than that.
const ITS_OWN: f64 = 0.5;

/// The readings that errors are looked at along.
#[derive(Clone, Copy)]
pub struct Readings<'a> {
    pub campaign: &'a Campaign,
    /// The first of each configuration of the problem.
    pub first: &'a [Option<usize>],
}

impl Readings<'_> {
    /// What an error at a joint could follow: its angle and its last move, by configuration. `None` where they are not known.
    fn drivers(&self, variable: usize) -> [Vec<Option<f64>>; 2] {
        let angle = |reading: usize| self.campaign.configuration(reading).get(variable).copied();
        let moves = &self.campaign.conditions.last_move;
        let moved = |reading: usize| moves.get(reading)?.get(variable).copied().filter(|moved| moved.is_finite());
        let of = |value: &dyn Fn(usize) -> Option<f64>| self.first.iter().map(|reading| value((*reading)?)).collect();
        [of(&angle), of(&moved)]
    }
}

/// Share of the error at a site that a law misses, of what it takes away there and what it misses: the greatest along any of the
/// drivers that is no chance. `columns` are the law's, orthonormal, and `before` is what the other causes leave; both off what is
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
    let drivers = readings.drivers(site.variable);
    let along = |driver: &Vec<Option<f64>>| {
        let mut order: Vec<(f64, usize)> =
            driver.iter().take(left.len()).enumerate().filter_map(|(pose, value)| Some(((*value)?, pose))).collect();
        order.sort_by(|a, b| a.0.total_cmp(&b.0));
        let series = Series::new(order.into_iter().map(|(_, pose)| left[pose]).collect())?;
        let (shared, p) = series.tested(settings.flips, settings.seed);
        (p < settings.chance / drivers.len() as f64).then(|| shared / (shared + taken))
    };
    drivers.iter().filter_map(along).fold(0.0, f64::max)
}
