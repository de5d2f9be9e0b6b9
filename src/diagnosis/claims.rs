//! What can be claimed of a cause: its law, its site, or only its family.
//!
//! A hypothesis wins because it is the best of those tried. Whether it is the cause depends on what else would do as well on
//! readings that were not fitted, on how much a free curve at its site does better, and on whether its law holds where it
//! was not fitted. What fails is not named; its site or its family is claimed instead.
//!
//! Source: Hansen, Lunde and Nason, *The model confidence set*, Econometrica 79, 2011 (rivals); Peters, Buehlmann and
//! Meinshausen, *Causal inference by using invariant prediction*, J. R. Stat. Soc. B 78, 2016 (laws that hold elsewhere);
//! Roberts et al., *Cross-validation strategies for data with temporal, spatial, hierarchical structure*, Ecography 40, 2017.

use nalgebra::{DMatrix, DVector, DVectorView};

use super::forward::Forward;
use super::free_errors::FreeErrors;
use super::held_out::{Beside, HeldOut, Losses, paired};
use super::hypothesis::Hypothesis;
use super::level::{Level, Stability};
use super::rivals::Rival;
use super::settings::ClaimSettings;
use super::stability::stability;
use crate::effects::Family;
use crate::math::{least_squares, project_off};

/// A claim about one cause.
#[derive(Debug, Clone, PartialEq)]
pub struct Claim {
    /// The hypothesis that stands for the cause.
    pub hypothesis: usize,
    /// How much of it is certain.
    pub level: Level,
    /// What cannot be told from it, the nearest first.
    pub rivals: Vec<Rival>,
    /// Share of what the best free curve at the site takes away; `None` where there is none to compare with.
    pub of_free: Option<f64>,
    /// Gain where the law was not fitted, over that of folds drawn at random.
    pub elsewhere: Option<f64>,
    /// How often it wins among all that were compared.
    pub stability: Stability,
}

/// What a law is tested with.
pub struct Tests<'a> {
    /// Configurations that are left out whole.
    pub blocks: &'a [HeldOut],
    /// Errors that are free in every configuration.
    pub free_errors: &'a FreeErrors<'a>,
    /// The noise over the sigmas of the rows.
    pub noise: f64,
}

/// Judges what can be claimed of one cause (hypotheses that stand for it together), `others` being the causes beside it.
/// `sharp` are its rivals by the information criterion, where what is left is noise as it was stated. Empty where nothing can
/// be claimed.
pub fn claims(
    forward: &Forward,
    cause: &[usize],
    others: &[usize],
    sharp: Option<&[Rival]>,
    tests: &Tests,
) -> Vec<Claim> {
    let (hypotheses, settings) = (&forward.problem.hypotheses, forward.settings);
    let gains = forward.selector.gains(others);
    let is_other =
        |h: usize| others.iter().any(|&m| m == h || hypotheses[m].is_same(&hypotheses[h]) && !hypotheses[h].is_free());
    let is_possible = |&h: &usize| cause != [h] && gains[h].directions > 0 && !is_other(h);
    // The cause itself comes first.
    let singles = (0..hypotheses.len()).filter(is_possible).map(|h| vec![h]);
    let joints = forward.of_all_joints(others).into_iter().filter(|set| !set.iter().any(|h| cause.contains(h)));
    let sets: Vec<Vec<usize>> = std::iter::once(cause.to_vec()).chain(singles).chain(joints).collect();
    let beside = Beside::new(&forward.selector.projection, others, &sets);
    let losses = forward.folds.losses(&beside);
    let is_sharp = sharp.is_some();
    let compared = Compared { forward, others, sets: &sets, beside: &beside, losses: &losses, tests, is_sharp };
    let first = |at: usize| &hypotheses[sets[at][0]];
    if first(0).is_free() {
        return vec![compared.curve(0, Level::Site)];
    }
    let is_tied = |at: usize| match sharp {
        Some(sharp) => sets[at].len() == 1 && sharp.iter().any(|rival| hypotheses[rival.hypothesis].is_same(first(at))),
        None => compared.is_near(at, 0),
    };
    let mut tied: Vec<usize> = (1..sets.len()).filter(|&at| !first(at).is_free() && is_tied(at)).collect();
    tied.sort_by(|&a, &b| compared.total(a).total_cmp(&compared.total(b)));
    // Of the variants of one effect at one site the best; single joints of a cause at several are no rivals of it.
    let mut distinct: Vec<usize> = vec![0];
    for at in tied {
        let is_part = cause.iter().any(|&h| hypotheses[h].is_same(first(at)));
        let is_known = |&known: &usize| sets[known].len() == sets[at].len() && first(known).is_same(first(at));
        if !is_part && !distinct.iter().any(is_known) {
            distinct.push(at);
        }
    }
    let judged: Vec<(usize, Gates)> = distinct.iter().map(|&at| (at, compared.gates(at))).collect();
    // Where the noise decides, what does as well is a rival whatever its gates; elsewhere only what could be a law.
    let own_holds = judged.first().is_some_and(|(_, gates)| gates.hold(settings));
    let keeps_all = sharp.is_some() && own_holds;
    let mut lawful: Vec<(usize, Gates)> =
        judged.into_iter().filter(|(_, gates)| keeps_all || gates.hold(settings)).collect();
    compared.nearest_first(&mut lawful);
    match lawful.split_first() {
        Some(((own, gates), rivals)) => compared.named(*own, *gates, rivals),
        None => compared.unnamed().into_iter().collect(),
    }
}

/// Candidates beside the other causes, and what they leave.
struct Compared<'a> {
    forward: &'a Forward<'a>,
    /// Causes that stand beside all of them.
    others: &'a [usize],
    sets: &'a [Vec<usize>],
    beside: &'a Beside<'a>,
    losses: &'a Losses,
    tests: &'a Tests<'a>,
    /// Whether the causes leave nothing but noise that is known.
    is_sharp: bool,
}

impl Compared<'_> {
    fn hypothesis(&self, at: usize) -> &Hypothesis {
        &self.forward.problem.hypotheses[self.sets[at][0]]
    }

    /// What a candidate leaves.
    fn total(&self, at: usize) -> f64 {
        self.losses.beside[at].iter().sum()
    }

    fn gain(&self, at: usize) -> f64 {
        paired(&self.losses.base, &self.losses.beside[at]).sum
    }

    fn free(&self) -> impl Iterator<Item = usize> {
        (1..self.sets.len()).filter(|&at| self.hypothesis(at).is_free())
    }

    /// Whether a candidate does as well as another: not certainly worse, and not by most of what that takes away, which where
    /// the losses of a few configurations are great may be uncertain too.
    fn is_near(&self, at: usize, own: usize) -> bool {
        let settings = self.forward.settings;
        self.gain(at) > settings.least_rival * self.gain(own)
            && paired(&self.losses.beside[at], &self.losses.beside[own]).t < settings.paired_t
    }

    /// Whether a candidate sits at none of the sites of another.
    fn is_elsewhere(&self, at: usize, own: usize) -> bool {
        let sites = self.sets[own].iter().map(|&h| &self.forward.problem.hypotheses[h].site.name);
        sites.into_iter().all(|site| *site != self.hypothesis(at).site.name)
    }

    /// The free curve that leaves least.
    fn best_free(&self) -> Option<usize> {
        self.free().min_by(|&a, &b| self.total(a).total_cmp(&self.total(b)))
    }

    /// Of laws that the readings do not tell apart the one goes first beside which calibrated constants stay nearer to the description, where
    /// they do so clearly: the scale of an instrument goes before a robot all of whose lengths and ratios are off by one factor.
    fn nearest_first(&self, tied: &mut [(usize, Gates)]) {
        let is_single = |at: usize| self.sets[at].len() == 1;
        if tied.len() < 2 || tied.len() > self.forward.settings.group || !is_single(tied[0].0) {
            return;
        }
        let far: Vec<f64> =
            tied.iter().map(|(at, _)| if is_single(*at) { self.far(*at) } else { f64::INFINITY }).collect();
        let nearest = (0..far.len()).min_by(|&a, &b| far[a].total_cmp(&far[b])).unwrap_or(0);
        if far[0] - far[nearest] > self.forward.settings.nearer {
            tied.swap(0, nearest);
        }
    }

    /// Squares of how far calibrated constants are from the description beside a candidate, by its tolerances.
    fn far(&self, at: usize) -> f64 {
        let problem = self.forward.problem;
        let members: Vec<usize> = self.others.iter().chain(&self.sets[at]).copied().collect();
        let x = least_squares(&problem.design(&members), &problem.residual);
        let moved = problem.moved.iter().zip(&x);
        moved.map(|([before, tolerance], change)| ((before + change) / tolerance).powi(2)).sum()
    }

    /// A cause with a law, and what is tied with it: named where these are few, else by what they share.
    fn named(&self, own: usize, gates: Gates, rivals: &[(usize, Gates)]) -> Vec<Claim> {
        let family = self.hypothesis(own).family();
        let shares_family = |at: usize| self.hypothesis(at).family() == family;
        // Where something stays that no law has, a free curve at another site that does as well leaves the site open.
        // Constants are simpler than any curve.
        let curves: Vec<usize> = match self.is_sharp || family == Family::Geometry {
            true => Vec::new(),
            false => self.free().filter(|&at| self.is_elsewhere(at, own) && self.is_near(at, own)).collect(),
        };
        // What may be another law in its limit is named only beside one that is not.
        let is_law = !gates.is_in_limit || rivals.iter().any(|(_, gates)| !gates.is_in_limit);
        let has_law = is_law && curves.is_empty();
        let level = if has_law && rivals.len() < self.forward.settings.group {
            Level::Law
        } else if rivals.iter().all(|(at, _)| shares_family(*at)) && curves.into_iter().all(shares_family) {
            Level::Family
        } else {
            return Vec::new();
        };
        let tied: Vec<usize> = rivals.iter().map(|(at, _)| *at).collect();
        let stability = self.stability(own, &tied);
        // What fewer than half of the halves choose is not known to be there.
        let least = self.forward.settings.least_halves;
        let level = match level {
            Level::Law if stability.group >= least => Level::Law,
            _ if stability.family >= least => Level::Family,
            _ => return Vec::new(),
        };
        let rivals: Vec<Rival> = rivals
            .iter()
            .map(|(at, _)| Rival {
                hypothesis: self.sets[*at][0],
                loss: self.total(*at) - self.total(own),
                is_of_joints: self.sets[*at].len() > 1,
            })
            .collect();
        let Gates { of_free, elsewhere, .. } = gates;
        let claim =
            |&hypothesis: &usize| Claim { hypothesis, level, rivals: rivals.clone(), of_free, elsewhere, stability };
        self.sets[own].iter().map(claim).collect()
    }

    /// The best free curve, where no law holds and all that does as well sits at its site, or is of its family.
    fn unnamed(&self) -> Option<Claim> {
        let best = self.best_free()?;
        if !self.forward.is_worth(&self.losses.base, &self.losses.beside[best]) {
            return None;
        }
        let tied: Vec<&Hypothesis> = (0..self.sets.len())
            .filter(|&other| self.is_near(other, best))
            .map(|other| self.hypothesis(other))
            .collect();
        let own = self.hypothesis(best);
        let level = if tied.iter().all(|other| other.site.name == own.site.name) {
            Level::Site
        } else if tied.iter().all(|other| other.family() == own.family()) {
            Level::Family
        } else {
            return None;
        };
        Some(self.curve(best, level))
    }

    /// A free curve, claimed without a law.
    fn curve(&self, at: usize, level: Level) -> Claim {
        let (hypothesis, stability) = (self.sets[at][0], self.stability(at, &[]));
        Claim { hypothesis, level, rivals: Vec::new(), of_free: None, elsewhere: None, stability }
    }

    /// Squares that the candidate takes away, over what an error free in every configuration carries at its site.
    fn of_site(&self, at: usize) -> Option<f64> {
        // What leaves nothing but noise cannot be bettered.
        let [_] = self.sets[at][..] else { return None };
        if self.is_sharp {
            return None;
        }
        let before = project_off(&self.forward.problem.residual, &self.beside.basis);
        let taken = self.beside.candidates[at].tr_mul(&before).norm_squared();
        let carried = self.tests.free_errors.carried(&self.hypothesis(at).site.name, &before, self.tests.noise)?;
        (carried > 0.0).then(|| taken / carried)
    }

    /// Stability among those that come near: what comes later hardly ever wins. `tied` does as well.
    fn stability(&self, own: usize, tied: &[usize]) -> Stability {
        let settings = self.forward.settings;
        let mut near: Vec<usize> = (0..self.sets.len()).filter(|&at| at != own && !tied.contains(&at)).collect();
        near.sort_by(|&a, &b| self.total(a).total_cmp(&self.total(b)));
        near.truncate(settings.compared);
        near.splice(0..0, std::iter::once(own).chain(tied.iter().copied()));
        let first: Vec<usize> = near.iter().map(|&at| self.sets[at][0]).collect();
        let halves = (settings.halves, settings.seed);
        stability(self.forward.problem, &self.beside.only(&near), &first, tied.len(), halves)
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
        let losses = self.forward.folds.losses(&self.beside.with(&DMatrix::from_columns(&apart)));
        let gain = paired(&self.losses.base, &losses.beside[0]).sum;
        paired(&self.losses.beside[at], &losses.beside[0]).t > settings.paired_t
            && self.gain(at) < settings.of_free * gain
    }

    /// Whether a law may be that of another effect in its limit: with the end of its continuous parameter where it becomes that,
    /// it does as well, the law's own variants among the other causes left out.
    fn is_in_limit(&self, at: usize) -> bool {
        let [own] = self.sets[at][..] else { return false };
        let (problem, noise) = (self.forward.problem, self.tests.noise);
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
        let beside = Beside::new(&self.forward.selector.projection, &others, &sets);
        let before = project_off(&problem.residual, &beside.basis);
        let taken: Vec<f64> = beside.candidates.iter().map(|columns| columns.tr_mul(&before).norm_squared()).collect();
        // The end lies in the interval of the parameter by the likelihood, readings of a configuration counting once.
        let per_pose = problem.rows() as f64 / problem.poses().len() as f64;
        let least = self.forward.settings.paired_t.powi(2) * noise * noise * per_pose;
        taken.split_first().is_some_and(|(own, ends)| ends.iter().any(|end| own - end < least))
    }

    fn gates(&self, at: usize) -> Gates {
        let settings = self.forward.settings;
        let (own, gain) = (self.hypothesis(at), self.gain(at));
        let at_site = self.free().filter(|&k| self.hypothesis(k).site.name == own.site.name).map(|k| self.gain(k));
        let of_free = at_site.filter(|best| *best > 0.0).max_by(f64::total_cmp).map(|best| gain / best);
        let is_better = |k: usize| {
            paired(&self.losses.beside[at], &self.losses.beside[k]).t > settings.paired_t
                && gain < settings.of_free * self.gain(k)
        };
        let is_beaten = self.free().any(is_better) || self.is_of_one_marker(at);
        let own_only = self.beside.only(&[at]);
        // The least share over all that is left out, where what is missing is certain.
        let mut elsewhere: Option<f64> = None;
        for block in self.tests.blocks {
            let left_out = block.losses(&own_only);
            let poses: Vec<usize> = (0..left_out.base.len()).filter(|&pose| left_out.base[pose] > 0.0).collect();
            let there: Vec<f64> = poses.iter().map(|&pose| left_out.base[pose] - left_out.beside[0][pose]).collect();
            let all = &self.losses;
            let random: Vec<f64> = poses.iter().map(|&pose| all.base[pose] - all.beside[at][pose]).collect();
            let whole: f64 = random.iter().sum();
            let least: Vec<f64> = random.iter().map(|gain| settings.elsewhere * gain).collect();
            // Where most of the gain is left out, or the noise alone takes as much of it, what stays determines no law.
            let by_noise = self.tests.noise.powi(2) * block.added_variance(self.beside, at);
            if whole > 0.0 && whole < settings.left_out * gain && by_noise < settings.left_out * whole {
                let share = there.iter().sum::<f64>() / whole;
                let share = if paired(&least, &there).t > settings.paired_t { share } else { share.max(1.0) };
                elsewhere = Some(elsewhere.map_or(share, |known| known.min(share)));
            }
        }
        Gates { of_free, is_beaten, elsewhere, of_site: self.of_site(at), is_in_limit: self.is_in_limit(at) }
    }
}

/// What a law is measured by.
#[derive(Debug, Clone, Copy)]
struct Gates {
    of_free: Option<f64>,
    elsewhere: Option<f64>,
    /// Whether a free curve anywhere, or an amount of each marker's own, is certainly better, and by much.
    is_beaten: bool,
    /// Share of what an error free in every configuration carries at the site.
    of_site: Option<f64>,
    /// Whether it may be another law in its limit.
    is_in_limit: bool,
}

impl Gates {
    fn hold(&self, settings: &ClaimSettings) -> bool {
        !self.is_beaten
            && self.of_site.is_none_or(|share| share >= settings.of_site)
            && self.of_free.is_none_or(|share| share >= settings.of_free)
            && self.elsewhere.is_none_or(|share| share >= settings.elsewhere)
    }
}
