//! The causes with the figures that are reported of them.

use super::bootstrap::Bootstrap;
use super::claims::Claim;
use super::competition::Competition;
use super::cross_validation::errors_of;
use super::implied::{curve, curves, implied};
use super::level::Level;
use super::linear_fit::{FittedParameter, LinearFit, entry, reported};
use super::result::{Cause, EffectAtSite, Shrinkage, Verdict};
use super::settings::Settings;
use super::verdict::Judgement;
use crate::math::{orthonormal, project_off};
use crate::model::Model;
use crate::parameter::{Group, Slot};

/// What to do about a site or a family of which no law is known.
pub const TELL_APART: &str =
    "measure where the nearest laws differ (`next_poses`) before anything is changed on the machine";

/// The same where no configuration tells them apart.
pub const OTHER_KINDS: &str = "read something else before anything is changed on the machine: a marker on another body, an indicator at the joint, a reflector on the base";

/// What to do about a base that moves with time where reflectors beside the robot moved as much.
pub const OF_INSTRUMENT: &str = "fasten the instrument, or let it warm up: reflectors beside the robot moved as much against it, so the robot need not have moved on its mount";

/// The causes with what their figures are made from.
pub struct Explanation<'a> {
    competition: &'a Competition,
    judgement: &'a Judgement,
    pub bootstrap: Bootstrap,
    /// Of each member.
    pub claims: Vec<Claim>,
    /// [`super::settings::ClaimSettings::odds`].
    odds: [f64; 3],
    /// How much wider the interval of the whole shrinkage is, and those of single causes.
    promise: f64,
    alone: f64,
}

impl<'a> Explanation<'a> {
    /// Of a competition and what was judged of it.
    pub fn new(
        competition: &'a Competition,
        judgement: &'a Judgement,
        bootstrap: Bootstrap,
        settings: &Settings,
    ) -> Self {
        // Every member is the hypothesis of a claim.
        let claim = |&m: &usize| competition.claims.iter().find(|claim| claim.hypothesis == m);
        let claims = judgement.members().iter().filter_map(claim).cloned().collect();
        let odds = settings.claims.odds;
        let [explained, open] = settings.verdict.promise;
        let promise = if judgement.verdict == Verdict::Explained { explained } else { open };
        let found = Self { competition, judgement, bootstrap, claims, odds, promise, alone: explained };
        // Where the noise does not decide, and a fresh campaign may be no better with all causes, no more than their families is known.
        let is_decided = judgement.verdict == Verdict::Explained;
        let last = judgement.members().len();
        if is_decided || found.shrinkage(0, last).ci95.is_none_or(|[low, _]| low > 0.0) {
            return found;
        }
        let of_family = |claim: &Claim| Claim { level: Level::Family, ..claim.clone() };
        Self { claims: found.claims.iter().map(of_family).collect(), ..found }
    }

    /// Shrinkage of the error from one step to a later one.
    pub fn shrinkage(&self, from: usize, to: usize) -> Shrinkage {
        let value = 1.0 - self.judgement.steps[to].left.rms / self.judgement.steps[from].left.rms;
        // What stays open elsewhere is no part of what one cause takes away.
        let is_whole = from == 0 && to == self.judgement.members().len();
        let wider = if is_whole { self.promise } else { self.alone };
        Shrinkage { value, ci95: self.bootstrap.shrinkage(from, to, value, wider) }
    }

    /// The causes with their fitted parameters by step. Those that are reported as one, whose claims follow one another, are one.
    pub fn causes(&self, model: &Model, fitted: &[Vec<FittedParameter>], linear: &LinearFit) -> Vec<Cause> {
        let hypotheses = &self.competition.problem.hypotheses;
        let mut all: Vec<Cause> = Vec::new();
        let mut first = 0;
        for (step, own) in fitted.iter().enumerate() {
            let cause = self.cause(model, step, own, linear);
            let is_part = step > 0 && self.claims[step].is_one_with(&self.claims[first], hypotheses);
            let Some(known) = all.last_mut().filter(|_| is_part) else {
                first = step;
                all.push(cause);
                continue;
            };
            known.parameters.extend(cause.parameters);
            known.entries.extend(cause.entries);
            known.rms_after = cause.rms_after;
            known.shrinkage = self.shrinkage(first, step + 1);
            // A law is certain by the greatest of its variants; a family may be any of its members.
            let is_new = |rival: &EffectAtSite| known.level == Level::Family && !known.rivals.contains(rival);
            let new: Vec<EffectAtSite> = cause.rivals.into_iter().filter(is_new).collect();
            known.rivals.extend(new);
        }
        for cause in &mut all {
            cause.rivals.retain(|rival| (&rival.effect, &rival.site) != (&cause.effect, &cause.site));
        }
        all
    }

    /// Root mean square displacement of the readings by what belongs to the session, m, that base and tool cannot take up, or anything that
    /// is re-fitted where part of it is no law; `None` where nothing belongs to it.
    pub fn of_session(&self, model: &Model, fitted: &[Vec<FittedParameter>], linear: &LinearFit) -> Option<f64> {
        let problem = &self.competition.problem;
        let causes = fitted.iter().enumerate().map(|(step, own)| (step, self.cause(model, step, own, linear)));
        let is_left_out = |(_, cause): &(usize, Cause)| {
            cause.entries.iter().any(|entry| cause.is_of_the_session(entry) && cause.remains(model, entry).is_none())
        };
        let left_out: Vec<(usize, Cause)> = causes.filter(is_left_out).collect();
        let are_laws = left_out.iter().all(|(_, cause)| cause.level == Level::Law);
        let moved = left_out.iter().map(|(step, _)| linear.contribution(*step)).reduce(|all, own| all + own)?;
        let is_placed = |slot: Slot| matches!(model.registry[slot].group, Group::Base | Group::Tool);
        let kept = self.competition.kept.iter().enumerate();
        let refitted: Vec<usize> = kept.filter(|(_, slot)| !are_laws || is_placed(**slot)).map(|(k, _)| k).collect();
        let left = project_off(&moved, &orthonormal(&problem.nuisance.select_columns(&refitted), None));
        Some(errors_of(problem, &left, problem.reading.clone())[1])
    }

    /// The cause that enters at a step.
    fn cause(&self, model: &Model, step: usize, fitted: &[FittedParameter], linear: &LinearFit) -> Cause {
        let hypotheses = &self.competition.problem.hypotheses;
        let hypothesis = &hypotheses[self.judgement.members()[step]];
        let claim = &self.claims[step];
        let EffectAtSite { mut effect, site } = hypothesis.named();
        let family = hypothesis.family();
        let mut rivals: Vec<EffectAtSite> = claim.rivals.iter().map(|rival| rival.named(hypotheses)).collect();
        let mut remedy = hypothesis.effect.remedy();
        let is_unknown_law = claim.level != Level::Law && !hypothesis.is_free();
        if claim.level == Level::Family || is_unknown_law {
            effect = format!("family:{}", family.name());
        }
        // The law that stands for its site or its family is one of those that it could be.
        if is_unknown_law {
            rivals.insert(0, hypothesis.named());
            remedy = TELL_APART;
        }
        Cause {
            effect,
            site,
            is_free: hypothesis.is_free() && claim.level != Level::Family,
            probability: Some(claim.probability(self.odds)),
            entries: vec![entry(hypothesis, fitted)],
            parameters: reported(model, hypothesis, fitted, linear.width_of_nonlinear(step)),
            rms_before: self.judgement.steps[step].left.rms,
            rms_after: self.judgement.steps[step + 1].left.rms,
            shrinkage: self.shrinkage(step, step + 1),
            rivals,
            family,
            level: claim.level,
            follows: hypothesis.follows(&model.coordinate_names(), self.competition.is_loaded()),
            stability: Some(claim.stability),
            support: claim.support,
            curve: curve(model, hypothesis, fitted, &linear.correlations(step)),
            curves: curves(model, hypothesis, fitted),
            implies: if is_unknown_law { Vec::new() } else { implied(hypothesis, fitted, &self.competition.values) },
            signature: hypothesis.effect.signature(),
            remedy,
        }
    }
}
