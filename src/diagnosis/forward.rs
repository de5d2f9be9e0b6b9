//! Causes chosen by what they leave of readings that were not fitted, one at a time.
//!
//! The compliances of all joints, and the lags of all joints, are one cause: they enter together, and those without an
//! effect of their own leave again.

use std::cell::OnceCell;

use super::flips::chances;
use super::free_errors::FreeErrors;
use super::held_out::{Additions, HeldOut, Losses, paired};
use super::hypothesis::Hypothesis;
use super::linear_problem::LinearProblem;
use super::selection::Selector;
use super::settings::ClaimSettings;
use crate::effects::{Family, SiteKind};
use crate::math::quantiles::two_sided_t;

/// Chooses among the hypotheses of a problem.
pub struct Forward<'a> {
    pub problem: &'a LinearProblem,
    pub selector: &'a Selector<'a>,
    pub folds: &'a HeldOut,
    pub settings: &'a ClaimSettings,
    /// Errors that are free in every configuration.
    pub free_errors: &'a FreeErrors<'a>,
    /// Sum of squares of the noise, where that is known; else 0.
    pub noise: f64,
    /// The noise over the sigmas, where it is known.
    pub sigma: Option<f64>,
    /// Squares above the noise that there are to explain of readings that were not fitted.
    pub gap: f64,
}

impl Forward<'_> {
    /// The causes, in the order in which they entered: each one hypothesis, or those of several joints.
    pub fn chosen(&self, most: usize) -> Vec<Vec<usize>> {
        let mut causes: Vec<Vec<usize>> = Vec::new();
        for _ in 0..most {
            let members = causes.concat();
            let Some(cause) = self.next(&members) else { break };
            for cause in self.without_others(&members, cause) {
                match causes.iter_mut().find(|known| self.is_of_same_joints(known, &cause)) {
                    Some(known) => known.extend(cause),
                    None => causes.push(cause),
                }
            }
        }
        causes
    }

    /// Whether two causes, one of them at several joints, are the like of one effect at all joints: what hid one joint from the others is
    /// fitted by then.
    fn is_of_same_joints(&self, known: &[usize], cause: &[usize]) -> bool {
        let all = || known.iter().chain(cause).map(|&h| &self.problem.hypotheses[h]);
        let has_one_effect = all().zip(all().skip(1)).all(|(a, b)| a.effect.name() == b.effect.name());
        (known.len() > 1 || cause.len() > 1) && has_one_effect && all().all(is_of_all_joints)
    }

    /// The cause that leaves least among those that are worth having and not chance. A candidate that would take more away but is not
    /// certain, as where it imitates an error of no known law, does not end the search.
    fn next(&self, members: &[usize]) -> Option<Vec<usize>> {
        let candidates = self.candidates(members);
        let additions = Additions::new(&self.selector.projection, members, &candidates);
        let losses = self.folds.losses(&additions);
        let is_worth = |at: &usize| self.is_worth(&losses.base, &losses.with[*at]);
        let left = |at: usize| (losses.with[at].iter().sum::<f64>(), at);
        let mut worth: Vec<(f64, usize)> = (0..candidates.len()).filter(is_worth).map(left).collect();
        worth.sort_by(|a, b| a.0.total_cmp(&b.0));
        let flipped = OnceCell::new();
        let flip = || chances(self.problem, &additions, self.settings.flips, self.settings.seed);
        worth.into_iter().find_map(|(_, at)| {
            let gain = paired(&losses.base, &losses.with[at]);
            if self.is_chance(members, &candidates[at], gain.t, || flipped.get_or_init(flip)[at]) {
                return None;
            }
            let mut all = [members, candidates[at].as_slice()].concat();
            self.prune(&mut all, members.len(), |before, after| self.is_worth(before, after));
            // Joints that are worth having together only, none by itself, are no cause.
            Some(all.split_off(members.len())).filter(|cause| !cause.is_empty())
        })
    }

    /// A lag of several joints without those at which another law certainly does better with the others; these laws follow as
    /// causes of their own. Compliances of all joints are kept: where one is a little off its law, a law of another shape at its joint
    /// does better without being there.
    fn without_others(&self, members: &[usize], mut cause: Vec<usize>) -> Vec<Vec<usize>> {
        let hypotheses = &self.problem.hypotheses;
        let mut others: Vec<Vec<usize>> = Vec::new();
        for at in (0..cause.len()).rev() {
            let own = cause[at];
            if cause.len() < 2 || hypotheses[own].family() != Family::History {
                break;
            }
            let stay = |&h: &usize| h != own;
            let remaining: Vec<usize> =
                members.iter().chain(&cause).chain(others.iter().flatten()).copied().filter(stay).collect();
            let gains = self.selector.gains(&remaining);
            let is_possible = |&h: &usize| {
                let (one, other) = (&hypotheses[h], &hypotheses[own]);
                gains[h].directions > 0
                    && !one.is_free()
                    && one.site.name == other.site.name
                    && !one.is_same(other)
                    && self.is_open(&remaining, h)
            };
            let mut sets = vec![vec![own]];
            sets.extend((0..hypotheses.len()).filter(is_possible).map(|h| vec![h]));
            let losses = self.losses(&remaining, &sets);
            let Some(best) = least(&losses).filter(|best| *best > 0) else { continue };
            if paired(&losses.with[0], &losses.with[best]).t > self.settings.paired_t {
                cause.remove(at);
                others.push(sets.swap_remove(best));
            }
        }
        std::iter::once(cause).chain(others).collect()
    }

    /// Whether a cause could be chance: by the noise where that is known, else by what it gains on readings that were not fitted
    /// (`t`, over all hypotheses) or by flipped signs, which hardly show causes of many parameters.
    fn is_chance(&self, members: &[usize], cause: &[usize], t: f64, by_flips: impl Fn() -> f64) -> bool {
        match self.sigma {
            Some(_) => {
                let [before, after] =
                    [members.to_vec(), [members, cause].concat()].map(|members| self.selector.fit(&members));
                !self.selector.is_worth(&before, &after, self.sigma)
            }
            None => {
                let freedom = self.problem.poses().len() as f64 - 1.0;
                let by_gain = 0.5 * two_sided_t(t.max(0.0), freedom) * self.problem.hypotheses.len() as f64;
                by_gain >= self.settings.chance && by_flips() >= self.settings.chance
            }
        }
    }

    /// Held-out losses with members, and with each candidate added to them.
    pub fn losses(&self, members: &[usize], candidates: &[Vec<usize>]) -> Losses {
        self.folds.losses(&Additions::new(&self.selector.projection, members, candidates))
    }

    /// Leaves out members from a position on that add too little to the others, the least one first. `is_enough` is given the
    /// losses before and after.
    pub fn prune(&self, members: &mut Vec<usize>, from: usize, is_enough: impl Fn(&[f64], &[f64]) -> bool) {
        while members.len() > from.max(1) {
            let without = |at: usize| -> Vec<usize> {
                let mut others = members.clone();
                others.remove(at);
                others
            };
            let worth = |at: usize| {
                let losses = self.losses(&without(at), &[vec![members[at]]]);
                let gain = paired(&losses.base, &losses.with[0]);
                (gain.sum, is_enough(&losses.base, &losses.with[0]))
            };
            let worths: Vec<(f64, bool)> = (from..members.len()).map(worth).collect();
            let poor = worths.iter().enumerate().filter(|(_, (_, is_worth))| !is_worth);
            let Some((at, _)) = poor.min_by(|a, b| a.1.0.total_cmp(&b.1.0)) else { return };
            members.remove(from + at);
        }
    }

    /// Whether what a cause takes away is certain, and enough of what is left above the noise to speak of.
    pub fn is_worth(&self, before: &[f64], after: &[f64]) -> bool {
        let gain = paired(before, after);
        let left = (before.iter().sum::<f64>() - self.noise).max(0.0);
        gain.t > self.settings.paired_t && gain.sum > self.settings.least_share * left
    }

    /// Hypotheses with a law that can be added to the members, and all joints together.
    fn candidates(&self, members: &[usize]) -> Vec<Vec<usize>> {
        let hypotheses = &self.problem.hypotheses;
        let gains = self.selector.gains(members);
        let single = |h: usize| gains[h].directions > 0 && !hypotheses[h].is_free() && self.is_open(members, h);
        let singles = (0..hypotheses.len()).filter(|&h| single(h)).map(|h| vec![h]);
        singles.chain(self.of_all_joints(members)).collect()
    }

    fn is_open(&self, members: &[usize], h: usize) -> bool {
        !members.iter().any(|&m| self.selector.excludes(m, h))
    }

    /// For each effect whose like at all joints is one cause: those of its hypotheses that can be added to the members.
    pub fn of_all_joints(&self, members: &[usize]) -> Vec<Vec<usize>> {
        let hypotheses = &self.problem.hypotheses;
        let mut effects: Vec<(&str, Vec<usize>)> = Vec::new();
        for (h, hypothesis) in hypotheses.iter().enumerate().filter(|(_, hypothesis)| is_of_all_joints(hypothesis)) {
            if !self.is_open(members, h) {
                continue;
            }
            match effects.iter_mut().find(|(name, _)| *name == hypothesis.effect.name()) {
                Some((_, joints)) => joints.push(h),
                None => effects.push((hypothesis.effect.name(), vec![h])),
            }
        }
        let possible = effects.into_iter().map(|(_, joints)| self.possible(members, joints));
        possible.filter(|joints| joints.len() > 1).collect()
    }

    /// Those of the compliances that are positive when they are fitted together.
    fn possible(&self, members: &[usize], mut joints: Vec<usize>) -> Vec<usize> {
        while let Some(least) = self.problem.negative(&[members, joints.as_slice()].concat(), |h| joints.contains(&h)) {
            joints.retain(|&h| h != least);
        }
        joints
    }
}

/// Whether the like of it at all joints is one cause: one amount, elastic or of the last move.
fn is_of_all_joints(hypothesis: &Hypothesis) -> bool {
    hypothesis.site.kind == SiteKind::Joint
        && hypothesis.variants == 1
        && hypothesis.parameters.len() == 1
        && matches!(hypothesis.family(), Family::Elastic | Family::History)
        && !hypothesis.is_free()
}

/// The candidate that leaves least.
pub fn least(losses: &Losses) -> Option<usize> {
    let sums = losses.with.iter().map(|own| own.iter().sum::<f64>()).enumerate();
    sums.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(at, _)| at)
}
