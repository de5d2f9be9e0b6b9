//! The choice of causes: those that explain best together where they leave nothing but noise, else those that help readings
//! that were not fitted; then what can be claimed of each.

use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;

use super::claims::{Claim, claims};
use super::compared::Tests;
use super::forward::Forward;
use super::free_errors::FreeErrors;
use super::held_out::{Additions, HeldOut, paired};
use super::hypothesis::Hypothesis;
use super::level::Level;
use super::linear_problem::LinearProblem;
use super::misfit::Readings;
use super::projection::Subset;
use super::rivals::{Rival, rivals};
use super::selection::Selector;
use super::settings::Settings;
use super::shared_site::curves_for_laws;
use super::unnamed::{
    curve, drop_negative, drop_replaced, without_held, without_idle_joints, without_lesser, without_outdone,
    without_series, without_unknown, without_unlikely,
};
use crate::effects::Family;
use crate::math::quantiles::normal_of_any;

/// Claims, and the subsets on the way to their hypotheses. `found` are the causes by the information criterion, `problem`
/// and `readings` hold those that are fitted, `noise` is over their sigmas.
pub fn choice(
    settings: &Settings,
    problem: &LinearProblem,
    readings: Readings,
    found: &[usize],
    noise: Option<f64>,
    free_errors: &FreeErrors,
) -> (Vec<Claim>, Vec<Subset>) {
    let selector = Selector::new(problem, &settings.selection);
    let folds = HeldOut::new(problem, &dealt(problem, settings));
    let known = noise.map_or(0.0, |noise| noise * noise * problem.rows() as f64);
    let left = folds.losses(&Additions::new(&selector.projection, &[], &[])).base.iter().sum::<f64>();
    let forward = Forward {
        problem,
        selector: &selector,
        folds: &folds,
        settings: &settings.claims,
        free_errors,
        noise: known,
        sigma: noise,
        gap: (left - known).max(0.0),
    };
    // A search over subsets finds causes that hide one another. It is trusted where it leaves nothing but noise that is
    // known: where something stays that no hypothesis has, it would fit that.
    let leaves_noise = |fit: &Subset| is_noise(&selector, fit, noise, settings);
    let together = leaves_noise(&selector.fit(found)).then(|| {
        let members = curves_for_laws(&selector, found, settings.claims.near_curve, leaves_noise);
        members.into_iter().map(|member| vec![member]).collect::<Vec<_>>()
    });
    let judged = |causes: &[Vec<usize>], is_sharp: bool| {
        let claims = judged(&forward, causes, is_sharp, (noise, readings), settings);
        gathered(claims, &problem.hypotheses)
    };
    // Laws that are part of one another leave none of them certain next to the others: then each is judged as it enters.
    let by_search = together.map(|causes| judged(&causes, true)).filter(|claims| !claims.is_empty());
    let mut claims = by_search.unwrap_or_else(|| {
        let causes = forward.chosen(settings.selection.most);
        let is_sharp = leaves_noise(&selector.fit(&causes.concat()));
        let sharp = if is_sharp { judged(&causes, true) } else { Vec::new() };
        if sharp.is_empty() { judged(&causes, false) } else { sharp }
    });
    let path = (0..=claims.len()).map(|count| {
        let taken: Vec<usize> = claims[..count].iter().map(|claim| claim.hypothesis).collect();
        selector.fit(&taken)
    });
    let path: Vec<Subset> = path.collect();
    // Of the causes chosen together some are too small to be claimed.
    let is_complete = path.last().is_some_and(leaves_noise);
    claims
        .iter_mut()
        .filter_map(|claim| claim.support.as_mut())
        .for_each(|support| support.leaves_noise &= is_complete);
    (claims, path)
}

/// The claims of causes, `is_sharp` where they leave nothing but noise that is known.
fn judged(
    forward: &Forward,
    causes: &[Vec<usize>],
    is_sharp: bool,
    (noise, readings): (Option<f64>, Readings),
    settings: &Settings,
) -> Vec<Claim> {
    let (problem, selector) = (forward.problem, forward.selector);
    let members = causes.concat();
    let fit = selector.fit(&members);
    let sharp = is_sharp.then(|| {
        let per_pose = problem.rows() as f64 / problem.poses().len() as f64;
        rivals(selector, &fit, per_pose, &settings.rivals)
    });
    let great = great(forward, &members, is_sharp);
    let blocks = blocks(problem, readings, settings);
    let freedom = (selector.projection.freedom - fit.directions as f64).max(1.0);
    let left = noise.unwrap_or_else(|| (fit.squares / freedom).sqrt());
    let tests = Tests { blocks: &blocks, noise: left, readings, members: &members };
    let claims = claimed(forward, causes, sharp.as_deref(), &tests, |cause| great.contains(cause));
    screened(forward, claims, &tests, settings)
}

/// The claims that stand together, laws that do not replaced by curves or families; and curves of what they leave.
fn screened(forward: &Forward, claims: Vec<Claim>, tests: &Tests, settings: &Settings) -> Vec<Claim> {
    let hypotheses = &forward.problem.hypotheses;
    let mut claims = without_held(hypotheses, claims);
    claims = without_series(forward, claims, settings);
    claims = without_lesser(forward, claims, tests.members);
    claims = without_unlikely(forward, claims, settings);
    claims = without_idle_joints(forward, claims, tests.noise);
    drop_negative(&mut claims, forward.problem);
    for _ in 0..settings.claims.curves {
        let taken: Vec<usize> = claims.iter().map(|claim| claim.hypothesis).collect();
        match curve(forward, &taken, None, settings) {
            Some(found) => claims.push(found),
            None => break,
        }
    }
    claims = without_outdone(forward, claims, settings);
    claims = without_unknown(hypotheses, claims);
    drop_replaced(&mut claims, forward.selector, tests.noise, settings.claims.near_curve);
    drop_negative(&mut claims, forward.problem);
    claims
}

/// The claims in their order, but for those that are reported as one cause: these follow the first of them.
fn gathered(claims: Vec<Claim>, hypotheses: &[Hypothesis]) -> Vec<Claim> {
    let first = |at: usize| (0..at).find(|&known| claims[known].is_one_with(&claims[at], hypotheses)).unwrap_or(at);
    let mut order: Vec<usize> = (0..claims.len()).collect();
    order.sort_by_key(|&at| first(at));
    order.into_iter().map(|at| claims[at].clone()).collect()
}

/// Those of the members that are great enough to be named. The search also finds small corrections of what is not quite the law of
/// another cause: fitted with it, and not named.
fn great(forward: &Forward, members: &[usize], is_sharp: bool) -> Vec<usize> {
    let mut great = members.to_vec();
    if is_sharp {
        let claims = forward.settings;
        let great_sum = claims.great_share * forward.gap;
        let certain = normal_of_any(claims.of_any, forward.problem.hypotheses.len());
        forward.prune(&mut great, 0, |before, after| {
            let gain = paired(before, after);
            gain.sum > great_sum || gain.sum > 0.0 && gain.t > certain
        });
    }
    great
}

/// What is claimed of the causes whose members are all great, each hypothesis once. `sharp` are the rivals of each member, where
/// nothing but noise is left.
fn claimed(
    forward: &Forward,
    causes: &[Vec<usize>],
    sharp: Option<&[Vec<Rival>]>,
    tests: &Tests,
    is_great: impl Fn(&usize) -> bool,
) -> Vec<Claim> {
    let mut judged: Vec<(&[usize], Vec<Claim>)> = Vec::new();
    let mut before = Before { forward, causes: Vec::new() };
    for (entry, cause) in causes.iter().enumerate().filter(|(_, cause)| cause.iter().all(&is_great)) {
        // Where the noise does not decide, a cause must be worth having whatever stands for those before it.
        if sharp.is_none() && !before.bears(cause) {
            continue;
        }
        // Where something stays, a cause is judged as it entered: later ones may have been fitted to what it left.
        let other_causes: Vec<usize> = match sharp {
            Some(_) => tests.members.iter().copied().filter(|member| !cause.contains(member)).collect(),
            None => causes[..entry].concat(),
        };
        let own = match cause[..] {
            [one] => tests.members.iter().position(|&member| member == one),
            _ => None,
        };
        let own = own.zip(sharp).map(|(at, all)| all[at].as_slice());
        let claims = claims(forward, cause, &other_causes, own, tests);
        before.add(cause, &other_causes, claims.first());
        judged.push((cause, each_by_itself(forward, cause, &other_causes, claims, tests)));
    }
    if sharp.is_none() {
        judge_again(forward, &mut judged, tests);
    }
    // Two causes may be claimed by the same curve.
    let mut distinct: Vec<Claim> = Vec::new();
    for claim in judged.into_iter().flat_map(|(_, claims)| claims) {
        if !distinct.iter().any(|known| known.hypothesis == claim.hypothesis) {
            distinct.push(claim);
        }
    }
    distinct
}

/// Judges the causes of which no law is known once more, the laws that stand for later causes fitted too. Without these a curve at the site
/// also takes up what they explain, and the law of the site seems to miss it.
fn judge_again(forward: &Forward, judged: &mut [(&[usize], Vec<Claim>)], tests: &Tests) {
    let hypotheses = &forward.problem.hypotheses;
    let has_law = |claims: &[Claim]| claims.iter().any(|claim| !hypotheses[claim.hypothesis].is_free());
    let is_named = |claims: &[Claim]| !claims.is_empty() && claims.iter().all(|claim| claim.level == Level::Law);
    for at in 0..judged.len() {
        if is_named(&judged[at].1) || !judged[at + 1..].iter().any(|(_, claims)| has_law(claims)) {
            continue;
        }
        let others = judged.iter().enumerate().filter(|(other, _)| *other != at).flat_map(|(_, (_, claims))| claims);
        let others: Vec<usize> = others.map(|claim| claim.hypothesis).filter(|&h| !hypotheses[h].is_free()).collect();
        let cause = judged[at].0;
        let again = claims(forward, cause, &others, None, tests);
        if is_named(&again) {
            judged[at].1 = each_by_itself(forward, cause, &others, again, tests);
        }
    }
}

/// The claims of a cause. Of a lag at several joints, where some of them are of that law with the others fitted, each of the others as it is
/// judged so: what another law or none has at one joint is taken along by the rest. Where it is at none, all deviate alike from the
/// law that they share. Compliances of all joints are one cause, which own weight excites together.
fn each_by_itself(
    forward: &Forward,
    cause: &[usize],
    other_causes: &[usize],
    found: Vec<Claim>,
    tests: &Tests,
) -> Vec<Claim> {
    let hypotheses = &forward.problem.hypotheses;
    let is_lag = |claim: &Claim| claim.level == Level::Law && hypotheses[claim.hypothesis].family() == Family::History;
    if found.len() < 2 || !found.iter().all(is_lag) {
        return found;
    }
    let alone = |shared: &Claim| -> Vec<Claim> {
        let own = shared.hypothesis;
        let others: Vec<usize> = other_causes.iter().chain(cause).copied().filter(|&h| h != own).collect();
        claims(forward, &[own], &others, None, tests)
    };
    let judged: Vec<Vec<Claim>> = found.iter().map(alone).collect();
    let is_own = |shared: &Claim, claim: &Claim| {
        claim.level == Level::Law && hypotheses[claim.hypothesis].is_same(&hypotheses[shared.hypothesis])
    };
    let is_law = |(shared, alone): (&Claim, &Vec<Claim>)| alone.iter().any(|claim| is_own(shared, claim));
    let laws: Vec<bool> = found.iter().zip(&judged).map(is_law).collect();
    if !laws.contains(&true) {
        return found;
    }
    let of_one = |((shared, mut alone), is_law): ((Claim, Vec<Claim>), bool)| {
        if is_law {
            return vec![shared];
        }
        let site = &hypotheses[shared.hypothesis].site.name;
        alone.retain(|claim| hypotheses[claim.hypothesis].site.name == *site);
        alone
    };
    found.into_iter().zip(judged).zip(laws).flat_map(of_one).collect()
}

/// Causes that are claimed, each with what cannot be distinguished from it.
struct Before<'a> {
    forward: &'a Forward<'a>,
    causes: Vec<(Vec<usize>, Vec<Vec<usize>>)>,
}

impl Before<'_> {
    fn add(&mut self, cause: &[usize], other_causes: &[usize], claim: Option<&Claim>) {
        let rivals = claim.map_or(&[][..], |claim| &claim.rivals);
        let of_joints = self.forward.of_all_joints(other_causes);
        let set =
            |rival: &Rival| match of_joints.iter().find(|set| rival.is_of_joints && set.contains(&rival.hypothesis)) {
                Some(set) => set.clone(),
                None => vec![rival.hypothesis],
            };
        self.causes.push((cause.to_vec(), rivals.iter().map(set).collect()));
    }

    /// Whether a further cause is worth having with each way to explain what came before: what is part of a rival of an
    /// earlier cause, or corrects the one that was chosen among them, is not known to be a cause of its own.
    fn bears(&self, cause: &[usize]) -> bool {
        let hypotheses = &self.forward.problem.hypotheses;
        self.causes.iter().enumerate().all(|(at, (_, rivals))| {
            let others =
                || self.causes.iter().enumerate().filter(move |(other, _)| *other != at).flat_map(|(_, own)| &own.0);
            rivals.iter().all(|rival| {
                let members: Vec<usize> = others().chain(rival).copied().collect();
                let is_new = |h: &&usize| !members.iter().any(|&m| m == **h || hypotheses[m].is_same(&hypotheses[**h]));
                let own: Vec<usize> = cause.iter().filter(is_new).copied().collect();
                !own.is_empty() && {
                    let losses = self.forward.losses(&members, &[own]);
                    self.forward.is_worth(&losses.base, &losses.with[0])
                }
            })
        })
    }
}

/// Whether a fit leaves no more than the noise, which is known.
fn is_noise(selector: &Selector, fit: &Subset, noise: Option<f64>, settings: &Settings) -> bool {
    let freedom = (selector.projection.freedom - fit.directions as f64).max(1.0);
    let verdict = &settings.verdict;
    let limit = verdict.excess_sigmas * (2.0 / freedom).sqrt() + verdict.excess_floor;
    // Much below it the noise is not what was stated.
    let is_near = |ratio: f64| ratio < 1.0 + limit && ratio > 1.0 / (1.0 + limit).powi(2);
    noise.is_some_and(|noise| is_near(fit.squares / freedom / (noise * noise)))
}

/// A fold for each configuration.
fn dealt(problem: &LinearProblem, settings: &Settings) -> Vec<Option<usize>> {
    let mut order: Vec<usize> = (0..problem.poses().len()).collect();
    order.shuffle(&mut ChaCha8Rng::seed_from_u64(settings.seed));
    let mut fold = vec![None; order.len()];
    order.into_iter().enumerate().for_each(|(k, pose)| fold[pose] = Some(k % settings.folds));
    fold
}

/// Sets of configurations that are left out whole: both ends of the range of each variable, of the time and of the
/// temperature; each session where there are several.
fn blocks(problem: &LinearProblem, readings: Readings, settings: &Settings) -> Vec<HeldOut> {
    let (poses, campaign, reading) = (problem.poses(), readings.campaign, readings.first);
    let ends = |value: &dyn Fn(usize) -> Option<f64>| {
        let of = |pose: usize| Some((value(reading[pose]?)?, pose));
        let mut order: Vec<(f64, usize)> = (0..poses.len()).filter_map(of).collect();
        order.sort_by(|a, b| a.0.total_cmp(&b.0));
        let count = (settings.claims.outer * order.len() as f64).round() as usize;
        let varies = order.first().zip(order.last()).is_some_and(|(low, high)| high.0 > low.0);
        let mut fold = vec![None; poses.len()];
        order.iter().take(count).for_each(|(_, pose)| fold[*pose] = Some(0));
        order.iter().rev().take(count).for_each(|(_, pose)| fold[*pose] = Some(1));
        varies.then(|| HeldOut::new(problem, &fold))
    };
    let conditions = &campaign.conditions;
    let variables = (0..campaign.variables)
        .filter_map(|variable| ends(&|reading| campaign.configuration(reading).get(variable).copied()));
    let noted = [&conditions.time, &conditions.temperature].into_iter().flatten();
    let noted = noted.filter_map(|all| ends(&|reading| all.get(reading).copied()));
    let mut all: Vec<HeldOut> = variables.chain(noted).collect();
    let mut sessions: Vec<_> = campaign.readings.iter().map(|reading| reading.session).collect();
    sessions.sort_unstable();
    sessions.dedup();
    if sessions.len() > 1 {
        let of = |reading: usize| sessions.iter().position(|own| *own == campaign.readings[reading].session);
        let fold: Vec<Option<usize>> = reading.iter().map(|reading| of((*reading)?)).collect();
        all.push(HeldOut::new(problem, &fold));
    }
    all
}
