//! What can be claimed of a cause: its law, its site, or only its family.
//!
//! A hypothesis wins because it is the best of those tried. Whether it is the cause depends on what else would do as well on
//! readings that were not fitted, on how much a free curve at its site does better, and on whether its law holds where it
//! was not fitted. What fails is not named; its site or its family is claimed instead.
//!
//! Source: Hansen, Lunde and Nason, *The model confidence set*, Econometrica 79, 2011 (rivals); Peters, Buehlmann and
//! Meinshausen, *Causal inference by using invariant prediction*, J. R. Stat. Soc. B 78, 2016 (laws that hold elsewhere);
//! Roberts et al., *Cross-validation strategies for data with temporal, spatial, hierarchical structure*, Ecography 40, 2017.

use super::compared::{Compared, Tests};
use super::forward::Forward;
use super::gates::Gates;
use super::held_out::Additions;
use super::hypothesis::Hypothesis;
use super::level::{Level, Stability, Support};
use super::rivals::Rival;
use crate::effects::{Family, SiteKind};
use crate::math::least_squares;

/// Cosine of the angle between what two laws do beyond which they are one but for rounding.
const ALIKE: f64 = 1.0 - 1e-9;

/// A claim about one cause.
#[derive(Debug, Clone, PartialEq)]
pub struct Claim {
    /// The hypothesis that stands for the cause.
    pub hypothesis: usize,
    /// How much of it is certain.
    pub level: Level,
    /// What cannot be distinguished from it, the nearest first.
    pub rivals: Vec<Rival>,
    /// What speaks for its law; `None` of a curve.
    pub support: Option<Support>,
    /// How often it wins among all that were compared.
    pub stability: Stability,
    /// Whether it is one of several joints that are one cause, all of which share what speaks for it.
    pub is_of_set: bool,
}

impl Claim {
    /// How often claims like this one are right, by [`super::settings::ClaimSettings::odds`]: that none of those tried is the cause is
    /// included.
    pub fn probability(&self, odds: [f64; 3]) -> f64 {
        let [constant, by_stability, by_share] = odds;
        let share = self.support.map_or(1.0, |support| support.of_gap.clamp(0.0, 1.0));
        let odds = constant + by_stability * self.stability.of(self.level) + by_share * share;
        1.0 / (1.0 + (-odds).exp())
    }

    /// Whether it is reported with another as one cause: what is known by its family alone, of that family; variants of one effect at one
    /// site, but for curves.
    pub fn is_one_with(&self, other: &Self, hypotheses: &[Hypothesis]) -> bool {
        let [own, that] = [self, other].map(|claim| &hypotheses[claim.hypothesis]);
        let shares_family = own.family() == that.family();
        match [self, other].map(|claim| claim.level == Level::Family) {
            [true, true] => shares_family,
            [false, false] => own.is_same(that) && !own.is_free(),
            _ => false,
        }
    }
}

/// Judges what can be claimed of one cause (hypotheses that stand for it together), `others` being all other causes.
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
    let additions = Additions::new(&forward.selector.projection, others, &sets);
    let losses = forward.folds.losses(&additions);
    let is_sharp = sharp.is_some();
    let compared = Compared { forward, others, sets: &sets, additions: &additions, losses: &losses, tests, is_sharp };
    let first = |at: usize| &hypotheses[sets[at][0]];
    if first(0).is_free() {
        return vec![compared.curve(0, first(0).level_by_driver())];
    }
    let is_tied = |at: usize| match sharp {
        Some(sharp) => sets[at].len() == 1 && sharp.iter().any(|rival| hypotheses[rival.hypothesis].is_same(first(at))),
        None => compared.is_rival(at, 0),
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
        judged.iter().filter(|(_, gates)| keeps_all || gates.hold(settings)).copied().collect();
    compared.one_for_all(&mut lawful);
    compared.nearest_first(&mut lawful);
    match lawful.split_first() {
        Some(((own, gates), rivals)) => {
            let mut claims = compared.named(*own, *gates, rivals);
            if sharp.is_some() {
                compared.add_joints(*own, &mut claims);
            }
            claims
        }
        None => compared.unnamed().or_else(|| compared.of_site_alone(&judged)).into_iter().collect(),
    }
}

impl Compared<'_> {
    /// Puts a law of all joints together in the place of the like of it at several joints, of which the readings do not tell it.
    fn one_for_all(&self, tied: &mut Vec<(usize, Gates)>) {
        let hypotheses = &self.forward.problem.hypotheses;
        let Some(several) = tied.first().map(|(at, _)| *at).filter(|&at| self.sets[at].len() > 1) else { return };
        let holds = |at: usize| {
            let law = self.hypothesis(at);
            let is_held = |&h: &usize| law.effect.name() == hypotheses[h].effect.name() && law.is_at(&hypotheses[h]);
            law.site.kind == SiteKind::Joints && self.sets[several].iter().all(is_held)
        };
        if let Some(at) = tied.iter().map(|(at, _)| *at).find(|&at| holds(at)) {
            tied.retain(|(own, _)| *own != several);
            tied.sort_by_key(|(own, _)| *own != at);
        }
    }

    /// Of laws that the readings do not tell apart the one goes first with which calibrated constants stay nearer to the description, where
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

    /// Squares of how far calibrated constants are from the description with a candidate fitted, by its tolerances.
    fn far(&self, at: usize) -> f64 {
        let problem = self.forward.problem;
        let members: Vec<usize> = self.others.iter().chain(&self.sets[at]).copied().collect();
        let x = least_squares(&problem.design(&members), &problem.residual);
        let moved = problem.moved.iter().zip(&x);
        moved.map(|([before, tolerance], change)| ((before + change) / tolerance).powi(2)).sum()
    }

    /// What is tied with a cause, and the laws that it may be in its limit.
    fn with_limits(&self, own: usize, gates: Gates, tied: &[(usize, Gates)]) -> Vec<(usize, Gates)> {
        let mut rivals = tied.to_vec();
        if gates.is_in_limit && tied.iter().all(|(_, gates)| gates.is_in_limit) {
            for at in self.limits(own) {
                if !rivals.iter().any(|(known, _)| self.hypothesis(*known).is_same(self.hypothesis(at))) {
                    rivals.push((at, self.gates(at)));
                }
            }
        }
        rivals
    }

    /// A cause with a law, and what is tied with it: named where these are few, else by what they share.
    fn named(&self, own: usize, gates: Gates, tied: &[(usize, Gates)]) -> Vec<Claim> {
        let rivals = self.with_limits(own, gates, tied);
        let family = self.hypothesis(own).family();
        let shares_family = |at: usize| self.hypothesis(at).family() == family;
        let curves = self.curves_elsewhere(own);
        // What may be another law in its limit is named only together with one that is not, or with the one that goes on from there.
        let goes_on = |at: usize| {
            let (law, other) = (self.hypothesis(own), self.hypothesis(at));
            !law.is_same(other) && law.is_at(other) && other.nonlinear.continuous().is_some()
        };
        let is_law = !gates.is_in_limit || rivals.iter().any(|(at, gates)| !gates.is_in_limit || goes_on(*at));
        let of_gap = self.gain(own) / self.forward.gap;
        // In addition to what no law has, one that takes little of the whole gap is as often a part of that.
        let settings = self.forward.settings;
        let is_great = self.is_sharp || of_gap >= settings.least_share;
        let has_law = is_law && is_great && curves.is_empty();
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
        let least = settings.least_halves;
        // Joints that are one cause stand for several laws.
        let is_one = self.sets[own].len() == 1;
        let level = match level {
            Level::Law if stability.group >= least && (!is_one || stability.group_law >= settings.least_law) => {
                Level::Law
            }
            // Another law, or a curve, wins there.
            Level::Law if stability.site >= least && tied.iter().all(|&at| !self.is_elsewhere(at, own)) => {
                return self.curve_at(own).into_iter().collect();
            }
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
        let support = Some(gates.support(of_gap, self.is_sharp));
        let claim = |&hypothesis: &usize| {
            let twins =
                self.twins(hypothesis).into_iter().filter(|twin| rivals.iter().all(|rival| rival.hypothesis != *twin));
            let twins = twins.map(|hypothesis| Rival { hypothesis, loss: 0.0, is_of_joints: false });
            let rivals = twins.chain(rivals.iter().cloned()).collect();
            Claim { hypothesis, level, rivals, support, stability, is_of_set: !is_one }
        };
        let mut claims: Vec<Claim> = self.sets[own].iter().map(claim).collect();
        if !is_one && !self.is_sharp {
            claims.iter_mut().for_each(|claim| self.add_other_laws(&self.sets[own], claim));
        }
        claims
    }

    /// Adds to a law of one of several joints that are one cause the other laws of its family at its joint that leave less in its place, as many as a
    /// group may have: the law of all of them is simpler, and each joint may still be off it.
    fn add_other_laws(&self, set: &[usize], claim: &mut Claim) {
        let (forward, hypotheses) = (self.forward, &self.forward.problem.hypotheses);
        let own = claim.hypothesis;
        let others: Vec<usize> = self.others.iter().chain(set).copied().filter(|&h| h != own).collect();
        let gains = forward.selector.gains(&others);
        let is_possible = |&h: &usize| {
            let (law, other) = (&hypotheses[own], &hypotheses[h]);
            let is_like = other.family() == law.family() && other.site.name == law.site.name;
            is_like && !other.is_free() && !other.is_same(law) && gains[h].directions > 0
        };
        let laws: Vec<usize> = (0..hypotheses.len()).filter(is_possible).collect();
        let sets: Vec<Vec<usize>> = std::iter::once(own).chain(laws).map(|h| vec![h]).collect();
        let losses = forward.losses(&others, &sets);
        let total = |at: usize| losses.with[at].iter().sum::<f64>();
        let mut better: Vec<usize> = (1..sets.len()).filter(|&at| total(at) < total(0)).collect();
        better.sort_by(|&a, &b| total(a).total_cmp(&total(b)));
        for at in better {
            let h = sets[at][0];
            let is_room = claim.rivals.len() + 1 < forward.settings.group;
            if is_room && !claim.rivals.iter().any(|known| hypotheses[known.hypothesis].is_same(&hypotheses[h])) {
                claim.rivals.push(Rival { hypothesis: h, loss: total(at) - total(0), is_of_joints: false });
            }
        }
    }

    /// Adds the joints that do as well together as a law does by itself to what cannot be distinguished from it: where the noise decides, rivals
    /// are sought one by one.
    fn add_joints(&self, own: usize, claims: &mut [Claim]) {
        let [claim] = claims else { return };
        let is_room = claim.rivals.len() + 1 < self.forward.settings.group;
        let of_joints = (1..self.sets.len()).filter(|&at| self.sets[at].len() > 1 && self.is_rival(at, own));
        let nearest = of_joints.min_by(|&a, &b| self.total(a).total_cmp(&self.total(b)));
        if let Some(at) = nearest.filter(|_| is_room && claim.level == Level::Law && self.sets[own].len() == 1) {
            let loss = self.total(at) - self.total(own);
            claim.rivals.push(Rival { hypothesis: self.sets[at][0], loss, is_of_joints: true });
        }
    }

    /// Laws of one amount that move all readings as one of several joints that are one cause does: those of joints on one axis.
    fn twins(&self, own: usize) -> Vec<usize> {
        let projection = &self.forward.selector.projection;
        let hypotheses = &self.forward.problem.hypotheses;
        let Some(members) = self.sets.iter().find(|set| set.len() > 1 && set.contains(&own)) else { return Vec::new() };
        let is_one = |h: usize| projection.blocks[h].ncols() == 1;
        let is_twin = |h: &usize| {
            !members.contains(h)
                && hypotheses[*h].effect.name() == hypotheses[own].effect.name()
                && is_one(own)
                && is_one(*h)
                && projection.alignment(own, *h) > ALIKE
        };
        (0..hypotheses.len()).filter(is_twin).collect()
    }

    /// Free curves at other sites that do as well as a law. Where something stays that no law has, they leave its site open.
    fn curves_elsewhere(&self, own: usize) -> Vec<usize> {
        // Constants are simpler than any curve, and a law is than what holds all laws of its family at several sites.
        if self.is_sharp || self.hypothesis(own).family() == Family::Geometry {
            return Vec::new();
        }
        let is_simple = |at: usize| self.hypothesis(at).level() == Level::Site;
        self.free().filter(|&at| is_simple(at) && self.is_elsewhere(at, own) && self.is_rival(at, own)).collect()
    }

    /// The cause by its site, or its family, where it fails as a law only by its shape there, and no curve stands for it. `judged`
    /// are the cause, first, and what does as well.
    fn of_site_alone(&self, judged: &[(usize, Gates)]) -> Option<Claim> {
        let ((own, gates), tied) = judged.split_first()?;
        let [hypothesis] = &self.sets[*own][..] else { return None };
        let settings = self.forward.settings;
        let of_gap = self.gain(*own) / self.forward.gap;
        let is_great = self.is_sharp || of_gap >= settings.least_share;
        let of_site = Gates { missed: 0.0, is_of_other_shape: false, ..*gates };
        if !is_great || !of_site.hold(settings) {
            return None;
        }
        let others: Vec<usize> = tied.iter().map(|(at, _)| *at).chain(self.curves_elsewhere(*own)).collect();
        let stability = self.stability(*own, &[]);
        let shares_family = |at: &usize| self.hypothesis(*at).family() == self.hypothesis(*own).family();
        let is_here = |at: &usize| !self.is_elsewhere(*at, *own);
        let is_of_site = self.hypothesis(*own).level_by_driver() == Level::Site;
        let level = if is_of_site && others.iter().all(is_here) && stability.site >= settings.least_halves {
            Level::Site
        } else if others.iter().all(shares_family) && stability.family >= settings.least_halves {
            Level::Family
        } else {
            return None;
        };
        let support = Some(gates.support(of_gap, self.is_sharp));
        Some(Claim { hypothesis: *hypothesis, level, rivals: Vec::new(), support, stability, is_of_set: false })
    }

    /// The best free curve, where no law holds and all that does as well sits at its site, or is of its family.
    fn unnamed(&self) -> Option<Claim> {
        let best = self.best_free()?;
        if !self.forward.is_worth(&self.losses.base, &self.losses.with[best]) || self.is_lost_elsewhere(best) {
            return None;
        }
        let tied: Vec<&Hypothesis> = (0..self.sets.len())
            .filter(|&other| other == best || self.is_rival(other, best))
            .map(|other| self.hypothesis(other))
            .collect();
        let own = self.hypothesis(best);
        let level = if tied.iter().all(|other| own.is_at(other)) {
            own.level_by_driver()
        } else if tied.iter().all(|other| other.family() == own.family()) {
            Level::Family
        } else {
            return None;
        };
        Some(self.curve(best, level))
    }

    /// The best free curve at the site of a candidate, where it is worth having.
    fn curve_at(&self, own: usize) -> Option<Claim> {
        let at_site = self.free_in_place_of(own).filter(|&at| !self.is_elsewhere(at, own));
        let best = at_site.min_by(|&a, &b| self.total(a).total_cmp(&self.total(b)))?;
        let is_worth = self.forward.is_worth(&self.losses.base, &self.losses.with[best]);
        (is_worth && !self.is_lost_elsewhere(best)).then(|| self.curve(best, self.hypothesis(best).level_by_driver()))
    }

    /// A free curve, claimed without a law.
    fn curve(&self, at: usize, level: Level) -> Claim {
        let (hypothesis, stability) = (self.sets[at][0], self.stability(at, &[]));
        Claim { hypothesis, level, rivals: Vec::new(), support: None, stability, is_of_set: false }
    }
}
