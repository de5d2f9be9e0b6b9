//! From the hypotheses selected to the diagnosis: verdict, location, causes with their figures, and what to measure next.

use super::autocorrelation::autocorrelation;
use super::bootstrap::Bootstrap;
use super::claims::Claim;
use super::competition::Competition;
use super::cross_validation::errors_of;
use super::few_angles::few_angles;
use super::implied::{curve, curves, implied};
use super::inputs::Inputs;
use super::level::Level;
use super::linear_fit::{FittedParameter, LinearFit, Structure, entry, reported};
use super::location::sites;
use super::next_poses::next_poses;
use super::outliers;
use super::refinement::slopes;
use super::refit::refit;
use super::regions::{excess_compliance, regions};
use super::result::{
    Autocorrelation, Cause, Diagnosis, EffectAtSite, FewAngles, Gap, Location, NoiseSource, Rest, Shrinkage, Verdict,
};
use super::rivals::{Rival, look_alikes, rejected};
use super::selection::Selector;
use super::settings::Settings;
use super::verdict::{Judgement, judge, without_noise};
use crate::description::campaign::{Amount, Reading};
use crate::estimation::CalibrationError;
use crate::math::{mean_rms_max, orthonormal, project_off};
use crate::model::Model;
use crate::parameter::{Group, Slot};
use crate::prediction::PredictionError;

/// Concludes a competition that was held without the readings marked as outliers.
///
/// # Errors
/// A configuration that cannot be assembled.
pub fn conclude(
    inputs: &Inputs,
    competition: &Competition,
    marked: &[bool],
    progress: &mut dyn FnMut(&str),
) -> Result<Diagnosis, CalibrationError> {
    progress("judging");
    let (settings, problem) = (inputs.settings, &competition.problem);
    let training = problem.without(&competition.held_out);
    let selector = Selector::new(&training, &settings.selection);
    let judgement = judge(inputs, competition, &selector);
    let members = judgement.members();
    let autocorrelation = residual_autocorrelation(inputs, competition, members);
    let verdict = by_noise(&judgement, &autocorrelation, settings);
    let gap = gap(competition, &judgement, verdict);
    progress("locating");
    let location = location(inputs, competition, &gap, judgement.noise)?;
    let structures = structures(&selector, members, judgement.noise);
    let structure = structures.iter().copied().find(|own| own.is_certain);
    let slopes = slopes(inputs.model, &competition.campaign, &competition.values, problem, members)?;
    let linear = LinearFit::new(problem, members, judgement.noise, structures, slopes);
    let refit = refit(inputs, competition, members, &linear);
    let bootstrap = Bootstrap::new(problem, members, settings.draws, settings.seed);
    let last = members.len();
    let found = Explanation::new(competition, &judgement, bootstrap, settings);
    let rivals: Vec<Vec<Rival>> = found.claims.iter().map(|claim| claim.rivals.clone()).collect();
    let mut causes = found.causes(inputs.model, &refit.parameters, &linear);
    let (rms_after, shrinkage) = (judgement.steps[last].left.rms, found.shrinkage(0, last));
    let of_session = found.of_session(inputs.model, &refit.parameters, &linear);
    let rms_of_robot = of_session.map(|rms| rms.hypot(rms_after));
    let both = inputs.campaign.readings.iter().zip(marked);
    let set_aside: Vec<&Reading> = both.filter(|(_, marked)| **marked).map(|(reading, _)| reading).collect();
    let outliers = outliers::cause(inputs, competition, members, marked, [gap.rms, rms_after])?;
    let with_outliers = outliers.as_ref().and_then(|outliers| outliers.with_all);
    let has_outliers = outliers.is_some();
    let is_open = verdict != Verdict::NoGap || has_outliers;
    let entered = if with_outliers.is_some() { 0 } else { causes.len() };
    causes.splice(entered..entered, outliers.map(|outliers| outliers.cause));
    let (rejected, rms_with_none) = rejected(&selector, members, &rivals);
    progress("proposing configurations");
    let is_asked = settings.propose && is_open;
    let next_poses = if is_asked { next_poses(inputs, competition, members, &rivals) } else { Vec::new() };
    if next_poses.is_empty() {
        causes.iter_mut().filter(|cause| cause.remedy == TELL_APART).for_each(|cause| cause.remedy = OTHER_KINDS);
    }
    let evidence = evidence(competition);
    let verdict = match verdict {
        Verdict::NoGap => without_causes(inputs, competition, &gap, evidence, is_open),
        // Outliers are certain where it is not known whether the rest is noise.
        Verdict::Undecided if has_outliers && judgement.noise_source == NoiseSource::Residual => {
            Verdict::PartlyExplained
        }
        other => other,
    };
    let few_angles = at_few_angles(inputs, competition, &judgement, verdict)?;
    Ok(Diagnosis {
        gap,
        location,
        verdict,
        causes,
        rejected,
        rms_with_none,
        rms_after,
        rms_after_ci95: found.bootstrap.rms(last, rms_after),
        rms_of_robot,
        autocorrelation,
        shrinkage,
        next_poses,
        outliers: set_aside.iter().map(|reading| reading.row).collect(),
        outliers_at: set_aside.iter().map(|reading| inputs.campaign.address(reading)).collect(),
        with_outliers,
        values: refit.values,
        is_pulled: competition.is_pulled,
        calibration: competition.calibration.clone(),
        refitted: competition.kept.clone(),
        drawn_from: None,
        evidence,
        calibrated: competition.values.clone(),
        look_alikes: look_alikes(&selector, members, settings.look_alikes),
        not_tried: competition.not_tried.clone(),
        excluded: competition.excluded.clone(),
        rest: Rest { few_angles, ..rest(competition, &selector, members, structure, (rms_after, gap.noise), inputs) },
        hypotheses: problem.named(),
        noise_source: judgement.noise_source,
    })
}

/// The verdict by the noise, where that is known.
fn by_noise(judgement: &Judgement, autocorrelation: &[Autocorrelation], settings: &Settings) -> Verdict {
    let chance = settings.autocorrelation.chance;
    match judgement.noise_source {
        NoiseSource::Residual => without_noise(judgement.verdict, autocorrelation, chance),
        _ if judgement.is_open(autocorrelation, chance, settings.verdict.open) => Verdict::PartlyExplained,
        _ => judgement.verdict,
    }
}

/// How much was fitted: readings, configurations and rows; and how many parameters.
fn evidence(competition: &Competition) -> (Amount, usize) {
    let is_fitted = |index: usize| !competition.held_out.get(index).copied().unwrap_or(false);
    (competition.campaign.select(|index, _| is_fitted(index)).amount(), competition.kept.len())
}

/// The verdict where no effect is called for: outliers explain what there is; too little evidence, or readings that were not seen
/// and are far off, leave it undecided.
fn without_causes(
    inputs: &Inputs,
    competition: &Competition,
    gap: &Gap,
    evidence: (Amount, usize),
    has_outliers: bool,
) -> Verdict {
    let settings = &inputs.settings.verdict;
    let is_held_out = |index: usize| competition.held_out.get(index).copied().unwrap_or(false);
    let held_out = competition.campaign.select(|index, _| is_held_out(index)).amount().configurations;
    let is_thin = settings.is_thin(evidence)
        || competition.problem.hypotheses.is_empty()
        || (1..settings.fewest_held_out).contains(&held_out);
    let is_drowned = gap.rms < settings.least_noise * gap.noise;
    match has_outliers {
        true => Verdict::Explained,
        false if is_thin || is_drowned || settings.is_beyond_noise(gap.rms, gap.noise) => Verdict::Undecided,
        false => Verdict::NoGap,
    }
}

/// Share of what is above the noise from which a free curve carries most of it.
const MOST_OF_REST: f64 = 0.5;

/// Curves in what the members leave: the one that takes most by direction, where that is no chance, and at the site of each member the one that
/// takes more by direction than what is left has, where there is one. `noise` is over the sigmas.
fn structures(selector: &Selector, members: &[usize], noise: f64) -> Vec<Structure> {
    let hypotheses = &selector.projection.problem.hypotheses;
    let gains = selector.gains_of_shapes(members);
    let per_direction = |h: &usize| gains[*h].squares / gains[*h].directions as f64;
    let greatest =
        |among: &mut dyn Iterator<Item = usize>| among.max_by(|a, b| per_direction(a).total_cmp(&per_direction(b)));
    let is_curve =
        |&h: &usize| hypotheses[h].is_free() && hypotheses[h].level() == Level::Site && gains[h].directions > 0;
    let curves: Vec<usize> = (0..hypotheses.len()).filter(is_curve).collect();
    let best = greatest(&mut curves.iter().copied()).filter(|&h| !selector.is_chance(gains[h]));
    let left = selector.fit(members);
    let freedom = (selector.projection.freedom - left.directions as f64).max(1.0);
    let scale = (left.squares / freedom).max(noise * noise);
    let at_sites = members.iter().filter_map(|&own| {
        let here = |h: &usize| hypotheses[*h].site.name == hypotheses[own].site.name && per_direction(h) > scale;
        greatest(&mut curves.iter().copied().filter(here))
    });
    let of = |curve: usize, least: f64, is_certain: bool| {
        let squares = (gains[curve].squares - least * gains[curve].directions as f64).max(0.0);
        Structure { curve, squares, is_certain }
    };
    let best = best.map(|curve| of(curve, noise * noise, true));
    best.into_iter().chain(at_sites.map(|curve| of(curve, scale, false))).collect()
}

/// What the causes leave above the noise (m), and the free curve that would take most of it away.
fn rest(
    competition: &Competition,
    selector: &Selector,
    members: &[usize],
    structure: Option<Structure>,
    (after, noise): (f64, f64),
    inputs: &Inputs,
) -> Rest {
    let hypotheses = &selector.projection.problem.hypotheses;
    // It names the site only where it carries most of what is above the noise.
    let left = selector.fit(members);
    let of_noise = (noise / selector.projection.problem.error_of_one_sigma()).powi(2);
    let above = left.squares - of_noise * (selector.projection.freedom - left.directions as f64);
    let own = structure.map(|own| &hypotheses[own.curve]);
    let best = structure.filter(|own| own.squares > MOST_OF_REST * above).map(|own| &hypotheses[own.curve]);
    Rest {
        rms: (after * after - noise * noise).max(0.0).sqrt(),
        site: best.map(|hypothesis| hypothesis.site.name.clone()),
        follows: best.and_then(|own| own.follows(&inputs.model.coordinate_names(), competition.is_loaded())),
        few_angles: None,
        allowed_for: own.filter(|_| !members.is_empty()).map(|hypothesis| hypothesis.site.name.clone()),
    }
}

/// The few angles of one joint at which most of an open rest lies.
fn at_few_angles(
    inputs: &Inputs,
    competition: &Competition,
    judgement: &Judgement,
    verdict: Verdict,
) -> Result<Option<FewAngles>, PredictionError> {
    if !matches!(verdict, Verdict::Unexplained | Verdict::PartlyExplained) {
        return Ok(None);
    }
    // Residuals that stand for the noise are never above it.
    let is_known = judgement.noise_source != NoiseSource::Residual;
    few_angles(inputs, competition, judgement.members(), if is_known { judgement.noise } else { 0.0 })
}

/// Tests of the residuals that the causes leave.
fn residual_autocorrelation(inputs: &Inputs, competition: &Competition, members: &[usize]) -> Vec<Autocorrelation> {
    let problem = &competition.problem;
    let residual = project_off(&problem.residual, &orthonormal(&problem.design(members), None));
    let settings = inputs.settings;
    autocorrelation(inputs.model, &competition.campaign, &residual, &settings.autocorrelation, settings.seed)
}

/// The gap that calibration leaves.
fn gap(competition: &Competition, judgement: &Judgement, verdict: Verdict) -> Gap {
    let (rms, max) = (judgement.steps[0].left.rms, judgement.steps[0].left.max);
    let noise = judgement.noise * competition.problem.error_of_one_sigma();
    Gap {
        rms,
        max,
        noise,
        closable: (rms * rms - noise * noise).max(0.0).sqrt(),
        is_significant: verdict != Verdict::NoGap,
        registration: competition.registration,
    }
}

/// Where the gap lies, by the residuals that calibration leaves in all readings.
fn location(inputs: &Inputs, competition: &Competition, gap: &Gap, noise: f64) -> Result<Location, PredictionError> {
    let (model, campaign, settings) = (inputs.model, &competition.campaign, &inputs.settings.location);
    let problem = &competition.problem;
    let residual = project_off(&problem.residual, &orthonormal(&problem.nuisance, None));
    let errors = problem.errors(&residual);
    let directions = std::array::from_fn(|k| mean_rms_max(errors.iter().map(|error| error[k]))[1]);
    if !gap.is_significant {
        return Ok(Location { directions, ..Location::default() });
    }
    Ok(Location {
        sites: sites(inputs, competition, &residual, noise)?,
        regions: regions(model, campaign, &errors, settings),
        directions,
        excess_compliance: excess_compliance(model, campaign, &errors, settings),
    })
}

/// What to do about a site or a family of which no law is known.
const TELL_APART: &str =
    "measure where the nearest laws differ (`next_poses`) before anything is changed on the machine";

/// The same where no configuration tells them apart.
const OTHER_KINDS: &str = "read something else before anything is changed on the machine: a marker on another body, an indicator at the joint, a reflector on the base";

/// The causes with what their figures are made from.
struct Explanation<'a> {
    competition: &'a Competition,
    judgement: &'a Judgement,
    bootstrap: Bootstrap,
    /// Of each member.
    claims: Vec<Claim>,
    /// [`super::settings::ClaimSettings::odds`].
    odds: [f64; 3],
    /// How much wider the intervals of shrinkages are.
    promise: f64,
}

impl<'a> Explanation<'a> {
    fn new(competition: &'a Competition, judgement: &'a Judgement, bootstrap: Bootstrap, settings: &Settings) -> Self {
        // Every member is the hypothesis of a claim.
        let claim = |&m: &usize| competition.claims.iter().find(|claim| claim.hypothesis == m);
        let claims = judgement.members().iter().filter_map(claim).cloned().collect();
        let odds = settings.claims.odds;
        let [explained, open] = settings.verdict.promise;
        let promise = if judgement.verdict == Verdict::Explained { explained } else { open };
        let found = Self { competition, judgement, bootstrap, claims, odds, promise };
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
    fn shrinkage(&self, from: usize, to: usize) -> Shrinkage {
        let value = 1.0 - self.judgement.steps[to].left.rms / self.judgement.steps[from].left.rms;
        Shrinkage { value, ci95: self.bootstrap.shrinkage(from, to, value, self.promise) }
    }

    /// The causes with their fitted parameters by step. Those that are reported as one, whose claims follow one another, are one.
    fn causes(&self, model: &Model, fitted: &[Vec<FittedParameter>], linear: &LinearFit) -> Vec<Cause> {
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
    fn of_session(&self, model: &Model, fitted: &[Vec<FittedParameter>], linear: &LinearFit) -> Option<f64> {
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
