//! How much of an error a law misses at its site: what it leaves there, from configuration to configuration, along the
//! joint's angle and within its period, the time or the temperature.
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
use super::hypothesis::Hypothesis;
use super::linear_problem::LinearProblem;
use super::settings::ClaimSettings;
use crate::description::campaign::Campaign;
use crate::effects::{Family, SiteKind};
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

    /// What a law goes with in each configuration: time, temperature, or the joint's angle; `None` of a law whose error is no series.
    fn along(&self, law: &Hypothesis) -> Option<Vec<Option<f64>>> {
        let conditions = &self.campaign.conditions;
        let noted = |all: &Option<Vec<f64>>| {
            let value = |reading: &Option<usize>| all.as_ref()?.get((*reading)?).copied();
            Some(self.first.iter().map(value).collect())
        };
        match (law.family(), law.site.kind) {
            (Family::Time, _) => noted(&conditions.time),
            (Family::Temperature, _) => noted(&conditions.temperature),
            (_, SiteKind::Joint) => Some(self.positions(law.site.coordinate?)),
            _ => None,
        }
    }

    /// Where in its period each configuration lies; `None` of a law that does not repeat.
    fn in_period(&self, law: &Hypothesis) -> Option<Vec<Option<f64>>> {
        let period = law.effect.period(&law.nonlinear)?;
        let positions = self.positions(law.site.coordinate?);
        Some(positions.into_iter().map(|position| Some(position?.rem_euclid(period))).collect())
    }
}

/// Share of the error at its site that a law misses, of what it takes away there and what it misses; 0 where that may be chance.
/// `columns` are the law's, orthonormal, and `before` is what the other causes leave; both off what is
/// fitted with them.
pub fn missed(
    free: &FreeErrors,
    law: &Hypothesis,
    (before, columns): (&DVector<f64>, &DMatrix<f64>),
    readings: Readings,
    settings: &ClaimSettings,
) -> f64 {
    let after = project_off(before, columns);
    let fitted = before - &after;
    let at_site = |errors: &DVector<f64>| match law.site.kind {
        SiteKind::Joint => Some(free.amounts(&law.site.name, errors)?.into_iter().map(|amount| vec![amount]).collect()),
        _ => Some(free.by_configuration(errors)),
    };
    let (Some(own), Some(left)) = (at_site(&fitted), at_site(&after)) else { return 0.0 };
    let least = ITS_OWN * fitted.norm_squared();
    let along = [readings.along(law), readings.in_period(law)].into_iter().flatten();
    along.map(|values| shared(values, &own, &left, least, settings)).fold(0.0, f64::max)
}

/// Share that neighbours in `values` have in common of what is left at a site, of this and what is taken there; 0 where less than `least`
/// is taken.
fn shared(values: Vec<Option<f64>>, own: &[Vec<f64>], left: &[Vec<f64>], least: f64, settings: &ClaimSettings) -> f64 {
    let taken: f64 = own.iter().flatten().map(|amount| amount * amount).sum();
    if taken < least {
        return 0.0;
    }
    let known = values.into_iter().zip(left);
    let mut order: Vec<(f64, &Vec<f64>)> = known.filter_map(|(value, errors)| Some((value?, errors))).collect();
    order.sort_by(|a, b| a.0.total_cmp(&b.0));
    let Some(series) = Series::new(order.into_iter().map(|(_, errors)| errors.clone()).collect()) else { return 0.0 };
    let (shared, p) = series.tested(settings.flips, settings.seed);
    if p < settings.chance { shared / (shared + taken) } else { 0.0 }
}
