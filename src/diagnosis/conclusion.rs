//! From the hypotheses selected to the diagnosis: verdict, location, causes with their figures, and what to measure next.

use super::autocorrelation::autocorrelation;
use super::bootstrap::Bootstrap;
use super::competition::Competition;
use super::explanation::{Explanation, OF_INSTRUMENT, OTHER_KINDS, TELL_APART};
use super::few_angles::few_angles;
use super::inputs::Inputs;
use super::level::Level;
use super::linear_fit::{LinearFit, Structure};
use super::location::sites;
use super::next_poses::next_poses;
use super::outliers;
use super::refinement::slopes;
use super::refit::refit;
use super::regions::{excess_compliance, regions};
use super::result::{Autocorrelation, Cause, Diagnosis, FewAngles, Gap, Location, NoiseSource, Rest, Verdict};
use super::rivals::{Rival, look_alikes, rejected};
use super::selection::Selector;
use super::settings::Settings;
use super::untried::is_of_instrument;
use super::verdict::{Judgement, judge, without_noise};
use crate::description::campaign::Amount;
use crate::effects::{Family, SiteKind};
use crate::estimation::{CHECK, CalibrationError, SEED, split};
use crate::math::quantiles::normal95;
use crate::math::{mean_rms_max, orthonormal, project_off};
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
    let slopes = slopes(inputs.model, &competition.campaign, &competition.values, problem, members)?;
    let left = structures(&selector, members, judgement.noise);
    let linear = LinearFit::new(problem, members, judgement.noise, left, slopes);
    let refit = refit(inputs, competition, members, &linear);
    let bootstrap = Bootstrap::new(problem, members, settings.draws, settings.seed);
    let last = members.len();
    let found = Explanation::new(competition, &judgement, bootstrap, settings);
    let rivals: Vec<Vec<Rival>> = found.claims.iter().map(|claim| claim.rivals.clone()).collect();
    let mut causes = found.causes(inputs.model, &refit.parameters, &linear);
    let (rms_after, shrinkage) = (judgement.steps[last].left.rms, found.shrinkage(0, last));
    let marked_readings = || inputs.campaign.readings.iter().zip(marked).filter(|(_, marked)| **marked);
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
    let moves_base = |cause: &Cause| {
        let is_base = cause.entries.iter().any(|entry| entry.site.kind == SiteKind::Base);
        let carried = (cause.rms_before.powi(2) - cause.rms_after.powi(2)).max(0.0).sqrt();
        is_base && cause.family == Family::Time && is_of_instrument(inputs.campaign, carried)
    };
    causes.iter_mut().filter(|cause| moves_base(cause)).for_each(|cause| cause.remedy = OF_INSTRUMENT);
    let verdict = concluded(inputs, competition, &judgement, &gap, (verdict, has_outliers));
    let few_angles = at_few_angles(inputs, competition, &judgement, verdict)?;
    let is_nothing = matches!(verdict, Verdict::NoGap | Verdict::Undecided);
    Ok(Diagnosis {
        gap,
        location,
        verdict,
        causes,
        rejected,
        rms_with_none,
        rms_after,
        rms_after_ci95: found.bootstrap.rms(last, rms_after),
        rms_of_robot: found.of_session(inputs.model, &refit.parameters, &linear).map(|rms| rms.hypot(rms_after)),
        autocorrelation,
        shrinkage,
        next_poses,
        outliers: marked_readings().map(|(reading, _)| reading.row).collect(),
        outliers_at: marked_readings().map(|(reading, _)| inputs.campaign.address(reading)).collect(),
        with_outliers,
        values: refit.values,
        is_pulled: competition.is_pulled,
        calibration: competition.calibration.clone(),
        refitted: competition.kept.clone(),
        drawn_from: None,
        evidence: if is_nothing { evidence_of_a_fit(competition) } else { evidence(competition) },
        calibrated: competition.values.clone(),
        look_alikes: look_alikes(&selector, members, settings.look_alikes),
        not_tried: competition.not_tried.clone(),
        excluded: competition.excluded.clone(),
        rest: Rest { few_angles, ..rest(inputs, competition, &selector, &linear, (rms_after, gap.noise)) },
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

/// The verdict with outliers, and where nothing is called for by whether that could have shown.
fn concluded(
    inputs: &Inputs,
    competition: &Competition,
    judgement: &Judgement,
    gap: &Gap,
    (verdict, has_outliers): (Verdict, bool),
) -> Verdict {
    match verdict {
        Verdict::NoGap => without_causes(inputs, competition, gap, evidence_of_a_fit(competition), has_outliers),
        // Outliers are certain where it is not known whether the rest is noise.
        Verdict::Undecided if has_outliers && judgement.noise_source == NoiseSource::Residual => {
            Verdict::PartlyExplained
        }
        other => other,
    }
}

/// How much was fitted: readings, configurations and rows; and how many parameters.
fn evidence(competition: &Competition) -> (Amount, usize) {
    let is_fitted = |index: usize| !competition.held_out.get(index).copied().unwrap_or(false);
    (competition.campaign.select(|index, _| is_fitted(index)).amount(), competition.kept.len())
}

/// The same of a calibration that holds readings out, as `identify` does by default: that nothing is missing is concluded from
/// no fewer readings than a calibration needs.
fn evidence_of_a_fit(competition: &Competition) -> (Amount, usize) {
    if competition.held_out.contains(&true) {
        return evidence(competition);
    }
    let held_out = split(&competition.campaign, CHECK, SEED);
    let fitted = competition.campaign.select(|index, _| !held_out.get(index).copied().unwrap_or(false));
    (fitted.amount(), competition.kept.len())
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
/// certainly takes more by direction than what is left has. `noise` is over the sigmas.
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
    // Of noise alone the squares are chi-square.
    let certain = |directions: usize| {
        let directions = directions as f64;
        directions + normal95() * (2.0 * directions).sqrt()
    };
    let at_sites = members.iter().filter_map(|&own| {
        let here = |h: &usize| {
            hypotheses[*h].site.name == hypotheses[own].site.name
                && gains[*h].squares > certain(gains[*h].directions) * scale
        };
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
    inputs: &Inputs,
    competition: &Competition,
    selector: &Selector,
    linear: &LinearFit,
    (after, noise): (f64, f64),
) -> Rest {
    let hypotheses = &selector.projection.problem.hypotheses;
    // It names the site only where it carries most of what is above the noise.
    let members = linear.members;
    let left = selector.fit(members);
    let of_noise = (noise / selector.projection.problem.error_of_one_sigma()).powi(2);
    let above = left.squares - of_noise * (selector.projection.freedom - left.directions as f64);
    let structure = linear.structures.iter().find(|own| own.is_certain);
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
