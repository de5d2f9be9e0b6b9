//! Claims that are left out, and laws that are not named after all: curves or families stand for them.
//!
//! A law is one thing, a course of any shape another: what takes several values of a law, or a curve in addition to it, to describe, is
//! not known to be that law.

use super::claims::Claim;
use super::flips::chances;
use super::forward::{Forward, least};
use super::held_out::{Additions, paired};
use super::hypothesis::Hypothesis;
use super::kept_amount::is_lost_elsewhere;
use super::level::Level;
use super::linear_problem::LinearProblem;
use super::projection::Gain;
use super::selection::Selector;
use super::settings::Settings;
use super::stability::stability;
use crate::effects::Family;
use crate::math::quantiles::normal95;

/// Leaves out causes of which nothing is certain once all others are fitted: the 95 % interval of their amounts then holds none. A curve that was
/// added at the site of a law takes all of it up where the law is another. A law that takes nearly as much as any curve at its site stays:
/// what a curve adds there is the rest.
pub fn drop_replaced(claims: &mut Vec<Claim>, selector: &Selector, noise: f64, near: f64) {
    let is_better =
        |claim: &Claim| claim.support.and_then(|support| support.of_free).is_some_and(|share| share >= near);
    while claims.len() > 1 {
        let adds = |at: usize| -> f64 {
            let others = claims.iter().enumerate().filter(|(other, _)| *other != at);
            let others: Vec<usize> = others.map(|(_, claim)| claim.hypothesis).collect();
            let gain = selector.gains_of_shapes(&others)[claims[at].hypothesis];
            gain.squares / gain.directions.max(1) as f64
        };
        let open = (0..claims.len()).filter(|&at| !is_better(&claims[at]));
        let least = open.map(|at| (at, adds(at))).min_by(|a, b| a.1.total_cmp(&b.1));
        let Some((least, _)) = least.filter(|(_, gain)| *gain < (normal95() * noise).powi(2)) else { return };
        claims.remove(least);
    }
}

/// Leaves out compliances, and elastic laws that are never negative, of which nothing positive is left in addition to the other causes: what they stood for is in these. A curve at the site
/// of a law takes what the law leaves.
pub fn drop_negative(claims: &mut Vec<Claim>, problem: &LinearProblem) {
    let hypotheses = &problem.hypotheses;
    loop {
        let all: Vec<usize> = claims.iter().map(|claim| claim.hypothesis).collect();
        let holds = |curve: usize| all.iter().any(|&law| hypotheses[curve].holds(&hypotheses[law]));
        let members: Vec<usize> = all.iter().copied().filter(|&h| !holds(h)).collect();
        let Some(negative) = problem.negative(&members, |_| true) else { return };
        claims.retain(|claim| claim.hypothesis != negative);
    }
}

/// The claims without those of a law known by its site or family alone where a curve of that family is claimed at its site: no more is known
/// of it than the curve says.
pub fn without_unknown(hypotheses: &[Hypothesis], mut claims: Vec<Claim>) -> Vec<Claim> {
    let of_sites: Vec<usize> =
        claims.iter().filter(|claim| claim.level == Level::Site).map(|claim| claim.hypothesis).collect();
    let is_held = |claim: &Claim| of_sites.iter().any(|&curve| hypotheses[curve].holds(&hypotheses[claim.hypothesis]));
    claims.retain(|claim| claim.level == Level::Law || !is_held(claim));
    claims
}

/// The claims without laws that a curve over several sites, which is claimed too, holds: it stands for whatever gives there.
pub fn without_held(hypotheses: &[Hypothesis], mut claims: Vec<Claim>) -> Vec<Claim> {
    let of_sites = claims.iter().map(|claim| claim.hypothesis).filter(|&h| hypotheses[h].level() == Level::Family);
    let curves: Vec<usize> = of_sites.collect();
    claims.retain(|claim| !curves.iter().any(|&curve| hypotheses[curve].holds(&hypotheses[claim.hypothesis])));
    claims
}

/// The claims, those of one law with several values at one site, or of several laws there that follow the same, replaced by a curve there,
/// where one can stand for them: three of them have any shape, and so have two neither of which takes most away by itself. Of two laws
/// of which one does, the other is a correction of its shape, and is no cause.
pub fn without_series(forward: &Forward, claims: Vec<Claim>, settings: &Settings) -> Vec<Claim> {
    let hypotheses = &forward.problem.hypotheses;
    let squares = |members: &[usize]| forward.selector.fit(members).squares;
    let is_law = |claim: &Claim| claim.level == Level::Law && !hypotheses[claim.hypothesis].is_free();
    let mut kept = claims.clone();
    for first in claims.iter().filter(|claim| is_law(claim)) {
        let law = &hypotheses[first.hypothesis];
        let is_of_series = |claim: &&Claim| {
            let other = &hypotheses[claim.hypothesis];
            // Of the history some follow the side of approach, others the last move.
            let is_of_driver = matches!(law.family(), Family::Kinematic | Family::Elastic);
            let follows_same = is_of_driver && other.site.name == law.site.name && other.family() == law.family();
            is_law(claim) && (other.is_same(law) || follows_same && !claim.is_of_set && !first.is_of_set)
        };
        let (series, others): (Vec<&Claim>, Vec<&Claim>) = kept.iter().partition(is_of_series);
        let taken: Vec<usize> = others.iter().map(|claim| claim.hypothesis).collect();
        let with = |own: &[&Claim]| -> f64 {
            let own = own.iter().map(|claim| claim.hypothesis);
            squares(&taken.iter().copied().chain(own).collect::<Vec<usize>>())
        };
        let before = with(&[]);
        let alone = |claim: &&Claim| before - with(&[claim]);
        let greatest = series.iter().copied().max_by(|a, b| alone(a).total_cmp(&alone(b)));
        let Some(greatest) = greatest.filter(|_| series.len() > 1) else { continue };
        let is_most = series.len() < 3 && alone(&greatest) >= settings.claims.of_site * (before - with(&series));
        let own = &hypotheses[greatest.hypothesis];
        let is_one_law = series.iter().all(|claim| hypotheses[claim.hypothesis].is_same(own));
        // Several ways to give under load at one site are no course of one angle.
        let are_kept = if is_most { is_one_law } else { !is_one_law && law.family() == Family::Elastic };
        if are_kept {
            continue;
        }
        let found = if is_most {
            greatest.clone()
        } else {
            let found = curve(forward, &taken, Some(law), settings);
            found.unwrap_or_else(|| Claim { level: Level::Family, ..series[0].clone() })
        };
        kept = others.into_iter().cloned().chain([found]).collect();
    }
    kept
}

/// The claims without those of several joints, one cause together, whose own amounts are not known to be any with all others fitted, where
/// the rest of them explain as much: all share what speaks for the cause, and not all need have it.
pub fn without_idle_joints(forward: &Forward, mut claims: Vec<Claim>, noise: f64) -> Vec<Claim> {
    let is_idle = |claim: &Claim| {
        let hypotheses = &forward.problem.hypotheses;
        // A curve at the site of a law takes what the law leaves.
        let is_other = |&h: &usize| h != claim.hypothesis && !hypotheses[h].holds(&hypotheses[claim.hypothesis]);
        let others = claims.iter().map(|other| other.hypothesis).filter(is_other);
        let gain = forward.selector.gains_of_shapes(&others.collect::<Vec<usize>>())[claim.hypothesis];
        claim.is_of_set && gain.squares < gain.directions.max(1) as f64 * (normal95() * noise).powi(2)
    };
    let idle: Vec<usize> = claims.iter().filter(|claim| is_idle(claim)).map(|claim| claim.hypothesis).collect();
    let is_left = |claim: &Claim| !idle.contains(&claim.hypothesis);
    if idle.is_empty() || !claims.iter().any(|claim| claim.is_of_set && is_left(claim)) {
        return claims;
    }
    let taken: Vec<usize> = claims.iter().filter(|claim| is_left(claim)).map(|claim| claim.hypothesis).collect();
    let losses = forward.losses(&taken, std::slice::from_ref(&idle));
    if !losses.with.first().is_some_and(|with| forward.is_worth(&losses.base, with)) {
        claims.retain(|claim| !idle.contains(&claim.hypothesis));
    }
    claims
}

/// The claims, those of a law by their family where another value of it at their site, which takes more, is among the `members` chosen and
/// not named: what is left of a course of another shape is no law either.
pub fn without_lesser(forward: &Forward, mut claims: Vec<Claim>, members: &[usize]) -> Vec<Claim> {
    let hypotheses = &forward.problem.hypotheses;
    let named: Vec<usize> =
        claims.iter().filter(|claim| claim.level == Level::Law).map(|claim| claim.hypothesis).collect();
    for claim in claims.iter_mut().filter(|claim| claim.level == Level::Law) {
        let own = claim.hypothesis;
        let others: Vec<usize> = named.iter().copied().filter(|&h| h != own).collect();
        let left = |h: usize| forward.selector.fit(&[others.as_slice(), &[h]].concat()).squares;
        let is_greater = |&h: &usize| {
            let is_value = hypotheses[h].is_same(&hypotheses[own]) && !hypotheses[h].is_free() && !named.contains(&h);
            is_value && left(h) < left(own)
        };
        if members.iter().any(is_greater) {
            claim.level = Level::Family;
        }
    }
    claims
}

/// The claims, each law with a curve at its site replaced by a curve alone: where the curve is of its family and the law does not take
/// nearly all that both do, since the error then has another shape; of others where the law takes less than its share of what both do, and
/// less than nearly what one curve does. Lags and compliances are named by what they go with, the last move or the load, in whatever way: for
/// these both must hold. What one law left with another is not known once that is replaced: the others are judged again.
pub fn without_outdone(forward: &Forward, mut claims: Vec<Claim>, settings: &Settings) -> Vec<Claim> {
    let hypotheses = &forward.problem.hypotheses;
    loop {
        let laws = claims.iter().filter(|claim| claim.level == Level::Law).map(|claim| claim.hypothesis);
        let outdone =
            laws.filter(|&h| !hypotheses[h].is_free()).find(|&law| is_outdone(forward, &claims, law, settings));
        let Some(law) = outdone else { return claims };
        let (here, mut kept) = here(hypotheses, claims, law);
        let taken: Vec<usize> = kept.iter().map(|claim| claim.hypothesis).collect();
        let left = here.into_iter().filter(|claim| claim.hypothesis != law);
        match curve(forward, &taken, Some(&hypotheses[law]), settings) {
            Some(found) => kept.push(found),
            None => kept.extend(left),
        }
        claims = kept;
    }
}

/// A law and the curves at its site, and the other claims.
fn here(hypotheses: &[Hypothesis], claims: Vec<Claim>, law: usize) -> (Vec<Claim>, Vec<Claim>) {
    claims.into_iter().partition(|claim| claim.hypothesis == law || is_curve_at(hypotheses, claim.hypothesis, law))
}

/// Whether a hypothesis is a curve at the site of a law.
fn is_curve_at(hypotheses: &[Hypothesis], h: usize, law: usize) -> bool {
    hypotheses[h].is_free() && hypotheses[h].is_at(&hypotheses[law])
}

/// Whether a curve that is claimed at the site of a law shows that it is another: see [`without_outdone`].
fn is_outdone(forward: &Forward, claims: &[Claim], law: usize, settings: &Settings) -> bool {
    let (hypotheses, limits) = (&forward.problem.hypotheses, &settings.claims);
    let (here, others) = here(hypotheses, claims.to_vec(), law);
    if here.len() < 2 {
        return false;
    }
    let taken: Vec<usize> = others.iter().map(|claim| claim.hypothesis).collect();
    let squares = |own: &[usize]| forward.selector.fit(&[taken.as_slice(), own].concat()).squares;
    let before = squares(&[]);
    let gain = |own: &[usize]| before - squares(own);
    let both: Vec<usize> = here.iter().map(|claim| claim.hypothesis).collect();
    let is_of_shape =
        !hypotheses[law].is_named_by_driver() && both.iter().any(|&h| hypotheses[h].holds(&hypotheses[law]));
    let curves = (0..hypotheses.len()).filter(|&h| is_curve_at(hypotheses, h, law));
    let best = curves.map(|h| gain(&[h])).fold(0.0, f64::max);
    let least = match is_of_shape {
        true => limits.near_curve * gain(&both),
        false => f64::min(limits.of_free * gain(&both), limits.near_curve * best),
    };
    gain(&[law]) < least
}

/// The claims, or curves at the sites of laws where none of these is likely; their families where no curve is worth having.
pub fn without_unlikely(forward: &Forward, claims: Vec<Claim>, settings: &Settings) -> Vec<Claim> {
    let hypotheses = &forward.problem.hypotheses;
    let is_law = |claim: &Claim| claim.level == Level::Law && !hypotheses[claim.hypothesis].is_free();
    let is_likely = |claim: &Claim| claim.probability(settings.claims.odds) >= settings.claims.least_probability;
    if claims.iter().any(|claim| is_law(claim) && is_likely(claim)) {
        return claims;
    }
    let (laws, mut kept): (Vec<Claim>, Vec<Claim>) = claims.into_iter().partition(is_law);
    for law in laws {
        let taken: Vec<usize> = kept.iter().map(|claim| claim.hypothesis).collect();
        let found = curve(forward, &taken, Some(&hypotheses[law.hypothesis]), settings);
        let of_family = || {
            let is_stable = law.stability.family >= settings.claims.least_halves;
            is_stable.then(|| Claim { level: Level::Family, ..law.clone() })
        };
        kept.extend(found.or_else(of_family));
    }
    kept
}

/// A free curve that the causes named leave at the site of a law, or at any where that is certain.
pub fn curve(forward: &Forward, taken: &[usize], law: Option<&Hypothesis>, settings: &Settings) -> Option<Claim> {
    let selector = forward.selector;
    // Those first whose amounts these readings show.
    curve_among(forward, taken, law, settings, &selector.gains(taken))
        .or_else(|| curve_among(forward, taken, law, settings, &selector.gains_of_shapes(taken)))
}

fn curve_among(
    forward: &Forward,
    taken: &[usize],
    law: Option<&Hypothesis>,
    settings: &Settings,
    gains: &[Gain],
) -> Option<Claim> {
    let hypotheses = &forward.problem.hypotheses;
    // For a law at its site; in addition to what is claimed, one that says where it is.
    let is_there = |h: usize| match law {
        Some(law) => hypotheses[h].is_at(law),
        None => hypotheses[h].level() == Level::Site,
    };
    let is_possible =
        |&h: &usize| hypotheses[h].is_free() && is_there(h) && gains[h].directions > 0 && !taken.contains(&h);
    let candidates: Vec<usize> = (0..hypotheses.len()).filter(is_possible).collect();
    let sets: Vec<Vec<usize>> = candidates.iter().map(|&h| vec![h]).collect();
    let additions = Additions::new(&forward.selector.projection, taken, &sets);
    let losses = forward.folds.losses(&additions);
    let best = least(&losses)?;
    if !forward.is_worth(&losses.base, &losses.with[best]) {
        return None;
    }
    let chance = chances(forward.problem, &additions, settings.claims.flips, settings.seed);
    let near = |&at: &usize| paired(&losses.with[at], &losses.with[best]).t < settings.claims.paired_t;
    let own = &hypotheses[candidates[best]];
    let is_certain = (0..candidates.len()).filter(near).all(|at| own.is_at(&hypotheses[candidates[at]]));
    let mut order: Vec<usize> = (0..candidates.len()).collect();
    order.swap(0, best);
    let ordered: Vec<usize> = order.iter().map(|&at| candidates[at]).collect();
    if !is_certain || chance[best] >= settings.claims.chance {
        return None;
    }
    if is_lost_elsewhere(forward, (&additions, taken), best, &sets[best]) {
        return None;
    }
    let stability = stability(forward.problem, &additions.only(&order), &ordered, 0, &settings.claims);
    // What it goes with is chosen by most halves of the configurations, or it is not known what happens there.
    (stability.family >= settings.claims.least_halves).then(|| Claim {
        hypothesis: candidates[best],
        level: own.level_by_driver(),
        rivals: Vec::new(),
        support: None,
        stability,
        is_of_set: false,
    })
}
