//! What a law must pass to be named.

use nalgebra::{DMatrix, DVector, DVectorView};

use super::compared::Compared;
use super::held_out::{Additions, paired};
use super::hypothesis::Hypothesis;
use super::level::Support;
use super::misfit::missed;
use super::settings::ClaimSettings;
use crate::effects::Family;
use crate::math::{least_squares, project_off};

/// What a law is measured by.
#[derive(Debug, Clone, Copy)]
pub struct Gates {
    pub of_free: Option<f64>,
    pub elsewhere: Option<f64>,
    /// Whether a free curve anywhere, an amount of each marker's own, one that changes along a joint, or an error at a few of its
    /// angles, is certainly better, and by much; or what no machine has is certainly better; or other causes cancel it.
    pub is_beaten: bool,
    /// Whether it has another shape at its site.
    pub is_of_other_shape: bool,
    /// Share of what an error free in every configuration carries at the site.
    pub of_site: Option<f64>,
    /// Whether it may be another law in its limit.
    pub is_in_limit: bool,
    /// Share of the error at the site that it misses.
    pub missed: f64,
}

impl Gates {
    pub fn hold(&self, settings: &ClaimSettings) -> bool {
        !self.is_beaten
            && !self.is_of_other_shape
            && self.missed <= 1.0 - settings.of_site
            && self.of_site.is_none_or(|share| share >= settings.of_site)
            && self.of_free.is_none_or(|share| share >= settings.of_free)
            && self.elsewhere.is_none_or(|share| share >= settings.elsewhere)
    }

    /// What speaks for the law; `of_gap` is its share of the gap.
    pub fn support(&self, of_gap: f64, leaves_noise: bool) -> Support {
        let Self { of_free, of_site, elsewhere, missed, .. } = *self;
        Support { of_gap, of_free, of_site, elsewhere, missed, leaves_noise }
    }
}

impl Compared<'_> {
    pub fn gates(&self, at: usize) -> Gates {
        let settings = self.forward.settings;
        let gain = self.gain(at);
        let of_free = self.of_free(at);
        let is_better = |k: usize| {
            paired(&self.losses.with[at], &self.losses.with[k]).t > settings.paired_t
                && gain < settings.of_free * self.gain(k)
                && self.is_alternative(k, at)
        };
        let is_beaten =
            self.free_for(at).any(is_better) || self.is_of_one_marker(at) || self.is_uneven(at) || self.is_local(at);
        let own_only = self.additions.only(&[at]);
        // The least share over all that is left out, where what is missing is certain.
        let mut elsewhere: Option<f64> = None;
        for block in self.tests.blocks {
            let left_out = block.losses(&own_only);
            let poses: Vec<usize> = (0..left_out.base.len()).filter(|&pose| left_out.base[pose] > 0.0).collect();
            let there: Vec<f64> = poses.iter().map(|&pose| left_out.base[pose] - left_out.with[0][pose]).collect();
            let all = &self.losses;
            let random: Vec<f64> = poses.iter().map(|&pose| all.base[pose] - all.with[at][pose]).collect();
            let whole: f64 = random.iter().sum();
            let least: Vec<f64> = random.iter().map(|gain| settings.elsewhere * gain).collect();
            // Where most of the gain is left out, or the noise alone takes as much of it, what stays determines no law.
            let by_noise = self.tests.noise.powi(2) * block.added_variance(self.additions, at);
            if whole > 0.0 && whole < settings.left_out * gain && by_noise < settings.left_out * whole {
                let share = there.iter().sum::<f64>() / whole;
                let share = if paired(&least, &there).t > settings.paired_t { share } else { share.max(1.0) };
                elsewhere = Some(elsewhere.map_or(share, |known| known.min(share)));
            }
        }
        let (of_site, is_in_limit) = (self.of_site(at), self.is_in_limit(at));
        let is_beaten =
            is_beaten || self.is_cancelled(at) || self.is_lost_elsewhere(at) || self.is_beaten_beyond_reason(at);
        let is_of_other_shape = !is_beaten && self.is_of_other_shape(at);
        Gates { of_free, is_beaten, is_of_other_shape, elsewhere, of_site, is_in_limit, missed: self.missed(at) }
    }

    /// What a law takes away over what the best curve at its site does, with the other causes but for curves there; `None` where no curve
    /// takes any.
    fn of_free(&self, at: usize) -> Option<f64> {
        let (own, hypotheses) = (self.hypothesis(at), &self.forward.problem.hypotheses);
        let at_site = self.free_for(at).filter(|&k| self.hypothesis(k).is_at(own));
        let is_here = |h: &usize| hypotheses[*h].is_free() && hypotheses[*h].is_at(own);
        let (here, others): (Vec<usize>, Vec<usize>) = self.others.iter().partition(|&h| is_here(h));
        let share = |law: f64, curves: &mut dyn Iterator<Item = f64>| {
            curves.filter(|best| *best > 0.0).max_by(f64::total_cmp).map(|best| law / best)
        };
        if here.is_empty() {
            return share(self.gain(at), &mut at_site.map(|k| self.gain(k)));
        }
        let curves = at_site.map(|k| self.sets[k].clone()).chain(here.into_iter().map(|curve| vec![curve]));
        let sets: Vec<Vec<usize>> = std::iter::once(self.sets[at].clone()).chain(curves).collect();
        let losses = self.forward.folds.losses(&Additions::new(&self.forward.selector.projection, &others, &sets));
        let mut gains = losses.with.iter().map(|with| paired(&losses.base, with).sum);
        share(gains.next()?, &mut gains)
    }

    /// Other laws at the site of one that may be theirs in its limit, which take away as much but for what that loses.
    pub fn limits(&self, own: usize) -> impl Iterator<Item = usize> {
        let before = self.before();
        let taken = move |at: usize| self.additions.candidates[at].tr_mul(&before).norm_squared();
        let law = self.hypothesis(own);
        let is_like = move |at: &usize| {
            let other = self.hypothesis(*at);
            self.sets[*at].len() == 1
                && !other.is_free()
                && !other.is_same(law)
                && (other.family(), &other.site.name) == (law.family(), &law.site.name)
        };
        let least = taken(own) - self.least_loss();
        (1..self.sets.len()).filter(is_like).filter(move |at| taken(*at) > least)
    }

    /// Whether a law may be that of another effect in its limit: with the end of its continuous parameter where it becomes that,
    /// it does as well, the law's own variants among the other causes left out.
    fn is_in_limit(&self, at: usize) -> bool {
        let [own] = self.sets[at][..] else { return false };
        let problem = self.forward.problem;
        let law = &problem.hypotheses[own];
        let Some(value) = law.nonlinear.continuous() else { return false };
        let is_variant = |h: &Hypothesis| h.is_same(law) && h.nonlinear.clone().with_continuous(value) == law.nonlinear;
        let all = || problem.hypotheses.iter().enumerate().filter(|(_, h)| is_variant(h));
        let of = |(h, variant): (usize, &Hypothesis)| Some((variant.nonlinear.continuous()?, h));
        let mut values: Vec<(f64, usize)> = all().filter_map(of).collect();
        values.sort_by(|a, b| a.0.total_cmp(&b.0));
        let ends = [values.first(), values.last()].into_iter().zip(law.effect.is_another_at_ends(&law.nonlinear));
        let ends: Vec<usize> = ends.filter(|(_, is_other)| *is_other).filter_map(|(end, _)| Some(end?.1)).collect();
        let others: Vec<usize> = self.others.iter().copied().filter(|&h| !problem.hypotheses[h].is_same(law)).collect();
        let sets: Vec<Vec<usize>> = std::iter::once(own).chain(ends).map(|h| vec![h]).collect();
        let additions = Additions::new(&self.forward.selector.projection, &others, &sets);
        let before = project_off(&problem.residual, &additions.basis);
        let taken: Vec<f64> =
            additions.candidates.iter().map(|columns| columns.tr_mul(&before).norm_squared()).collect();
        taken.split_first().is_some_and(|(own, ends)| ends.iter().any(|end| own - end < self.least_loss()))
    }

    /// What the end of a parameter's interval leaves more than its best value, by the likelihood; readings of a configuration count
    /// once.
    fn least_loss(&self) -> f64 {
        let problem = self.forward.problem;
        let per_pose = problem.rows() as f64 / problem.poses().len() as f64;
        (self.forward.settings.paired_t * self.tests.noise).powi(2) * per_pose
    }

    /// Whether a law alone would do much more than there is to explain, and the other causes take most of it back: the readings show what
    /// they leave of one another, and neither.
    fn is_cancelled(&self, at: usize) -> bool {
        if self.others.is_empty() {
            return false;
        }
        let alone = Additions::new(&self.forward.selector.projection, &[], &[self.sets[at].clone()]);
        let (own, residual) = (&alone.candidates[0], &self.forward.problem.residual);
        let all = project_off(residual, &alone.basis).norm_squared();
        let off = |column: DVectorView<f64>| project_off(&column.into_owned(), &self.additions.basis);
        let unlike_others = DMatrix::from_columns(&own.column_iter().map(off).collect::<Vec<_>>());
        let amounts = least_squares(&unlike_others, &self.before());
        amounts.norm_squared() > self.forward.settings.cancelled.powi(2) * all
    }

    /// Whether amounts that each marker has for itself do certainly better, and by much: then it is not the robot that moves.
    fn is_of_one_marker(&self, at: usize) -> bool {
        let (problem, settings) = (self.forward.problem, self.forward.settings);
        let mut markers = problem.marker.clone();
        markers.sort_unstable();
        markers.dedup();
        if markers.len() < 2 {
            return false;
        }
        let columns = || self.sets[at].iter().flat_map(|&h| problem.hypotheses[h].columns.column_iter());
        let of_marker = |marker: &usize| {
            let of_row = |column: DVectorView<f64>| {
                DVector::from_fn(column.len(), |row, _| if problem.marker[row] == *marker { column[row] } else { 0.0 })
            };
            columns().map(of_row).collect::<Vec<_>>()
        };
        let apart: Vec<DVector<f64>> = markers.iter().flat_map(of_marker).collect();
        let losses = self.forward.folds.losses(&self.additions.with(&[DMatrix::from_columns(&apart)]));
        let gain = paired(&self.losses.base, &losses.with[0]).sum;
        paired(&self.losses.with[at], &losses.with[0]).t > settings.paired_t && self.gain(at) < settings.of_free * gain
    }

    /// Share of the error at its site that a law misses, all other causes fitted but for curves that hold it: these would take what it
    /// misses.
    fn missed(&self, at: usize) -> f64 {
        let [own] = self.sets[at][..] else { return 0.0 };
        let problem = self.forward.problem;
        let law = &problem.hypotheses[own];
        let is_other = |h: &usize| {
            let other = &problem.hypotheses[*h];
            !self.sets[0].contains(h) && !other.is_same(law) && !other.holds(law)
        };
        let others: Vec<usize> = self.tests.members.iter().copied().filter(is_other).collect();
        let additions = Additions::new(&self.forward.selector.projection, &others, &[vec![own]]);
        let before = project_off(&problem.residual, &additions.basis);
        let (free, readings) = (self.forward.free_errors, self.tests.readings);
        missed(free, law, (&before, &additions.candidates[0]), readings, self.forward.settings)
    }

    /// Squares that the candidate takes away, over what an error free in every configuration carries at its site.
    fn of_site(&self, at: usize) -> Option<f64> {
        // What leaves nothing but noise cannot be bettered.
        let [_] = self.sets[at][..] else { return None };
        if self.is_sharp {
            return None;
        }
        let before = self.before();
        let own = &self.additions.candidates[at];
        let taken = own.tr_mul(&before).norm_squared();
        let (free, site) = (self.forward.free_errors, &self.hypothesis(at).site.name);
        let carried = free.carried(site, &before, self.tests.noise)?;
        let share = (carried > 0.0).then(|| taken / carried)?;
        let is_enough = share >= self.forward.settings.of_site;
        // Errors under load occur at several sites together, and a free error at one takes up that of another; errors of joints do
        // not go with time.
        let is_of_time = matches!(self.hypothesis(at).family(), Family::Time | Family::Temperature);
        let with_other = || self.of_rest_of_another(own, &before).filter(|best| *best > share);
        let is_settled = is_enough || !is_of_time || free.column(site).is_some();
        Some(if is_settled { share } else { with_other().unwrap_or(share) })
    }

    /// Several directions carry errors of other sites too. The greatest share of all above the noise that a law takes of what a free
    /// error of one direction elsewhere leaves: what that takes up is then that site's. `None` where no more than noise is left.
    fn of_rest_of_another(&self, own: &DMatrix<f64>, before: &DVector<f64>) -> Option<f64> {
        let (problem, free) = (self.forward.problem, self.forward.free_errors);
        let law = own * own.tr_mul(before);
        let columns = DMatrix::from_columns(&[law, before.clone()]);
        let of_rest = |(_, left): (&str, DMatrix<f64>)| {
            let (law, before) = (left.column(0), left.column(1));
            let free_rows = (problem.rows() - free.first_readings().count()) as f64;
            let above_noise = before.norm_squared() - free_rows * self.tests.noise.powi(2);
            let taken = law.dot(&before).powi(2) / law.norm_squared();
            (above_noise > 0.0 && taken.is_finite()).then(|| taken / above_noise)
        };
        free.off(&columns).filter_map(of_rest).max_by(f64::total_cmp)
    }
}
