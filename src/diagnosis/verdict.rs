//! The verdict: which of the hypotheses selected are causes, and whether they explain the gap.

use super::bootstrap::Bootstrap;
use super::competition::Competition;
use super::cross_validation::{Validated, folds, validated};
use super::held_out::paired;
use super::inputs::Inputs;
use super::projection::Subset;
use super::result::{Autocorrelation, NoiseSource, Verdict};
use super::selection::Selector;
use super::settings::VerdictSettings;
use crate::description::campaign::NoiseOrigin;

/// A subset on the way to the causes, with its cross-validated error.
pub struct Step {
    /// The subset.
    pub subset: Subset,
    /// What it leaves of readings that were not fitted.
    pub left: Validated,
}

/// The causes and what they explain.
pub struct Judgement {
    /// From the empty subset to that of all causes; never empty.
    pub steps: Vec<Step>,
    /// The verdict by the noise alone.
    pub verdict: Verdict,
    /// Variance that the causes leave above that of the noise, over it.
    pub excess: f64,
    /// Noise over the sigmas of the rows.
    pub noise: f64,
    /// Where it comes from.
    pub noise_source: NoiseSource,
}

impl Judgement {
    /// Whether causes that explain nearly all leave more than noise with a pattern, `excess` being the variance above that of the noise, over it,
    /// from which that counts.
    pub fn is_open(&self, tests: &[Autocorrelation], chance: f64, excess: f64) -> bool {
        self.verdict == Verdict::Explained && self.excess > excess && is_autocorrelated(tests, chance)
    }

    /// The causes, as indices of hypotheses.
    pub fn members(&self) -> &[usize] {
        self.steps.last().map_or(&[], |step| &step.subset.members)
    }
}

/// Judges the hypotheses selected. `selector` holds the readings that are fitted.
pub fn judge(inputs: &Inputs, competition: &Competition, selector: &Selector) -> Judgement {
    let settings = &inputs.settings.verdict;
    let folds = folds(&competition.problem, &competition.held_out, inputs.settings.folds, inputs.settings.seed);
    let step = |members: &[usize]| Step {
        subset: selector.fit(members),
        left: validated(&competition.problem, members, &folds),
    };
    let mut steps = vec![step(&[])];
    for &member in competition.members() {
        if let Some(last) = steps.last() {
            steps.push(step(&[last.subset.members.as_slice(), &[member]].concat()));
        }
    }
    let freedom = selector.projection.freedom;
    let variance = |step: &Step| step.subset.squares / (freedom - step.subset.directions as f64).max(1.0);
    let limit = settings.excess_sigmas * (2.0 / freedom).sqrt() + settings.excess_floor;
    let is_noise = |step: &Step| competition.noise.is_some_and(|noise| variance(step) / (noise * noise) - 1.0 <= limit);
    // Causes that make readings worse which were not fitted are none, whatever they do to the fitted ones. Where the noise does
    // not decide, those are none either of which it is not certain that they make them better, configuration by configuration; where
    // calibration leaves no more than noise, which may be correlated, and of curves alone, which fit whatever there is, not certain
    // that a fresh campaign will be better.
    while let [first, .., last] = &steps[..] {
        let is_decided = !is_noise(first) && is_noise(last);
        let is_better = || paired(&first.left.losses, &last.left.losses).t > inputs.settings.claims.paired_t;
        let are_curves = || last.subset.members.iter().all(|&member| competition.problem.hypotheses[member].is_free());
        let is_certain = || match is_noise(first) {
            true => is_promised(inputs, competition, &steps),
            false => is_better() && (!are_curves() || is_promised(inputs, competition, &steps)),
        };
        if last.left.rms < first.left.rms && (is_decided || is_certain()) {
            break;
        }
        steps.pop();
    }
    if let Some(members) = without_the_idle(competition, &steps, &|members| step(members).left.rms) {
        steps = (0..=members.len()).map(|count| step(&members[..count])).collect();
    }
    let [before, after] = [steps.first(), steps.last()].map(|step| step.map_or(0.0, variance));
    let is_stated = competition.campaign.sigma.is_some() && competition.campaign.noise_origin == NoiseOrigin::Stated;
    let noise_source = match competition.noise {
        Some(_) if is_stated => NoiseSource::Stated,
        Some(_) => NoiseSource::Repeated,
        None => NoiseSource::Residual,
    };
    let noise = competition.noise.unwrap_or_else(|| after.sqrt());
    let [before, after] = [before, after].map(|variance| variance / (noise * noise) - 1.0);
    // Against a noise that is stated far too great no gap could show.
    let is_drowned = (before + 1.0).max(0.0).sqrt() < settings.least_noise;
    let is_significant = before > limit || steps.len() > 1;
    let verdict = match steps.len() {
        1 if is_significant => Verdict::Unexplained,
        1 if is_drowned => Verdict::Undecided,
        1 => Verdict::NoGap,
        _ if is_explained(before, after, limit, settings) => Verdict::Explained,
        _ => Verdict::PartlyExplained,
    };
    Judgement { steps, verdict, excess: after, noise, noise_source }
}

/// The causes without those that leave more of unseen readings than the others do alone, in an order in which each one takes something away,
/// where there is one; `None` where the steps are so already. What is reported as one cause stays together.
fn without_the_idle(competition: &Competition, steps: &[Step], left: &dyn Fn(&[usize]) -> f64) -> Option<Vec<usize>> {
    let is_worse = |pair: &[Step]| pair[1].left.rms > pair[0].left.rms;
    if !steps.windows(2).any(is_worse) {
        return None;
    }
    let mut causes = together(competition, &steps.last()?.subset.members);
    while causes.len() > 1 {
        let all = left(&causes.concat());
        let without = |at: usize| {
            let others: Vec<usize> = (0..causes.len()).filter(|&k| k != at).flat_map(|k| causes[k].clone()).collect();
            (left(&others), at)
        };
        let least = (0..causes.len()).map(without).min_by(|a, b| a.0.total_cmp(&b.0))?;
        if least.0 > all {
            break;
        }
        causes.remove(least.1);
    }
    let mut members: Vec<usize> = Vec::new();
    let is_free = |cause: &[usize]| cause.iter().all(|&member| competition.problem.hypotheses[member].is_free());
    while !causes.is_empty() {
        let with = |at: usize| (is_free(&causes[at]), left(&[members.as_slice(), causes[at].as_slice()].concat()), at);
        // Curves are of what laws leave.
        let (.., at) = (0..causes.len()).map(with).min_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)))?;
        members.extend(causes.remove(at));
    }
    Some(members)
}

/// Members by what is reported as one cause.
fn together(competition: &Competition, members: &[usize]) -> Vec<Vec<usize>> {
    let claim = |member: usize| competition.claims.iter().find(|claim| claim.hypothesis == member);
    let hypotheses = &competition.problem.hypotheses;
    let mut causes: Vec<Vec<usize>> = Vec::new();
    for &member in members {
        let is_part = |cause: &&mut Vec<usize>| {
            let first = cause.first().and_then(|&first| claim(first));
            claim(member).zip(first).is_some_and(|(own, first)| own.is_one_with(first, hypotheses))
        };
        match causes.last_mut().filter(is_part) {
            Some(cause) => cause.push(member),
            None => causes.push(vec![member]),
        }
    }
    causes
}

/// Whether the 95 % interval of what all causes take away, on readings that were not fitted, excludes nothing.
fn is_promised(inputs: &Inputs, competition: &Competition, steps: &[Step]) -> bool {
    let [Some(first), Some(last)] = [steps.first(), steps.last()] else { return false };
    let value = 1.0 - last.left.rms / first.left.rms;
    let settings = inputs.settings;
    let drawn = Bootstrap::new(&competition.problem, &last.subset.members, settings.draws, settings.seed);
    drawn.excludes_nothing(steps.len() - 1, value)
}

fn is_explained(before: f64, after: f64, limit: f64, settings: &VerdictSettings) -> bool {
    after <= limit || after < settings.near && after / before.max(1e-9) < settings.explained
}

/// Whether residuals show a pattern, `chance` being the probability over all tests below which they do.
fn is_autocorrelated(tests: &[Autocorrelation], chance: f64) -> bool {
    tests.iter().any(|test| test.p < chance / tests.len() as f64)
}

/// The verdict where the noise is not known: what the causes leave cannot show that nothing is left, and autocorrelated
/// residuals show a gap. `chance` is the probability over all tests below which they are autocorrelated.
pub fn without_noise(verdict: Verdict, tests: &[Autocorrelation], chance: f64) -> Verdict {
    match verdict {
        Verdict::NoGap if is_autocorrelated(tests, chance) => Verdict::Unexplained,
        Verdict::NoGap => Verdict::Undecided,
        Verdict::Explained => Verdict::PartlyExplained,
        other => other,
    }
}
