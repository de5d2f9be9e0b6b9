//! How much of an error a law misses at its site: what it leaves there, from configuration to configuration, along what it goes with:
//! the joint's angle, also within its period, load or last move, the time or the temperature.
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
use crate::effects::{Family, NonlinearValue, SiteKind};
use crate::math::project_off;
use crate::model::{Follower, Model};

/// Errors over their sigmas by configuration, of each as many.
type Errors = Vec<Vec<f64>>;

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
    /// [`joint_loads`](crate::prediction::joint_loads) of the readings.
    pub loads: &'a [Vec<f64>],
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
        self.first.iter().map(|reading| self.position(&followers, (*reading)?, coordinate)).collect()
    }

    /// A coordinate in a reading.
    fn position(&self, followers: &[Follower], reading: usize, coordinate: usize) -> Option<f64> {
        let q = self.campaign.configuration(reading);
        let of_follower = || Some(followers.get(coordinate.checked_sub(q.len())?)?.of(q));
        q.get(coordinate).copied().or_else(of_follower)
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

    /// What a law of a joint goes with in each reading: the position of the joint that it names, or its own; its load, its last move, the time or
    /// the temperature. `None` where that is not noted.
    pub fn goes_with(&self, law: &Hypothesis) -> Option<Vec<Option<f64>>> {
        let of_joint = law.site.coordinate?;
        let named = law.nonlinear.values().into_iter().find_map(|value| match value {
            NonlinearValue::Variable(variable) => Some(variable),
            _ => None,
        });
        let (campaign, conditions) = (self.campaign, &self.campaign.conditions);
        let noted = |all: &Vec<f64>| all.iter().map(|value| value.is_finite().then_some(*value)).collect();
        match law.family() {
            Family::Time => conditions.time.as_ref().map(noted),
            Family::Temperature => conditions.temperature.as_ref().map(noted),
            Family::History => conditions.last_move.get(of_joint).map(noted),
            Family::Elastic => Some(self.loads.iter().map(|loads| loads.get(of_joint).copied()).collect()),
            _ => {
                let followers = self.model.followers();
                let of = |reading: usize| self.position(&followers, reading, named.unwrap_or(of_joint));
                Some((0..campaign.readings.len()).map(of).collect())
            }
        }
    }

    /// The last move of its joint by which each configuration was reached; `None` of what does not look back.
    fn last_moves(&self, law: &Hypothesis) -> Option<Vec<Option<f64>>> {
        let moves = self.campaign.conditions.last_move.get(law.site.coordinate?)?;
        let is_joint = (law.family(), law.site.kind) == (Family::History, SiteKind::Joint);
        let last = |reading: &Option<usize>| moves.get((*reading)?).copied().filter(|moved| moved.is_finite());
        is_joint.then(|| self.first.iter().map(last).collect())
    }

    /// The load on its joint in readings; `None` of what does not go with load.
    fn loads(&self, law: &Hypothesis, readings: impl Iterator<Item = usize>) -> Option<Vec<Option<f64>>> {
        let own = law.site.coordinate?;
        let is_joint = (law.family(), law.site.kind) == (Family::Elastic, SiteKind::Joint);
        is_joint.then(|| readings.map(|reading| self.loads.get(reading)?.get(own).copied()).collect())
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
    let site = law.site.name.as_str();
    let each = |amounts: Vec<f64>| -> Errors { amounts.into_iter().map(|amount| vec![amount]).collect() };
    let at_site = |errors: &DVector<f64>| match law.site.kind {
        SiteKind::Joint => free.amounts(site, errors).map(each),
        _ => Some(free.by_configuration(errors)),
    };
    let under_load = |errors: &DVector<f64>| free.amounts_by_load(site, errors).map(each);
    let least = ITS_OWN * fitted.norm_squared();
    let most = |along: &[Option<Vec<Option<f64>>>], at: &dyn Fn(&DVector<f64>) -> Option<Errors>| {
        let (Some(own), Some(left)) = (at(&fitted), at(&after)) else { return 0.0 };
        along.iter().flatten().map(|values| shared(values, &own, &left, least, settings)).fold(0.0, f64::max)
    };
    let by_configuration = [readings.along(law), readings.in_period(law), readings.last_moves(law)];
    let by_load = [readings.loads(law, free.first_readings())];
    f64::max(most(&by_configuration, &at_site), most(&by_load, &under_load))
}

/// Share that neighbours in `values` have in common of what is left at a site, of this and what is taken there; 0 where less than `least`
/// is taken.
fn shared(values: &[Option<f64>], own: &[Vec<f64>], left: &[Vec<f64>], least: f64, settings: &ClaimSettings) -> f64 {
    let taken: f64 = own.iter().flatten().map(|amount| amount * amount).sum();
    if taken < least {
        return 0.0;
    }
    let known = values.iter().zip(left);
    let mut order: Vec<(f64, &Vec<f64>)> = known.filter_map(|(value, errors)| Some(((*value)?, errors))).collect();
    order.sort_by(|a, b| a.0.total_cmp(&b.0));
    let Some(series) = Series::new(order.into_iter().map(|(_, errors)| errors.clone()).collect()) else { return 0.0 };
    let (shared, p) = series.tested(settings.flips, settings.seed);
    if p < settings.chance { shared / (shared + taken) } else { 0.0 }
}
