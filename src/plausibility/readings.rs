//! Readings against the description: where registration leaves far more than tolerances and noise allow, other ways to read
//! the files are tried, and the one with which the error falls decisively is named.

use rayon::prelude::*;

use super::beyond::is_noise_beyond;
use super::evidence::{Evidence, Limits};
use super::hypothesis::{Hypothesis, total_length};
use super::outlying;
use super::shown::{both, mm, unit_of};
use super::trial::{Trials, errors, noise, typical};
use super::words::{Words, words_of};
use crate::description::campaign::{Campaign, NoiseOrigin, Reading, Sharing, Target};
use crate::diagnostic::{Code, Diagnostic, Severity};
use crate::math::{distinct, median};
use crate::observation::{ANCHOR_COLUMN, CONTACT_COLUMN};

/// A way to read the files, and what a fit then leaves, m.
pub(super) type Trial = (Vec<Hypothesis>, f64);

pub(super) fn fit_the_description(evidence: &Evidence, limits: &Limits) -> Vec<Diagnostic> {
    let found = all_together(evidence, limits);
    let is_explained = |found: &Diagnostic| matches!(found.code, Code::WrongUnits | Code::Misread);
    let campaign = evidence.campaign;
    let Some(parts) = super::sessions::parts(campaign).filter(|_| !found.iter().any(is_explained)) else {
        return found;
    };
    // What is wrong in one session hides behind the others' readings.
    let of = |part: usize| {
        let own = campaign.select(|index, _| parts.of.get(index) == Some(&part));
        let poses = distinct(own.readings.iter().map(|reading| reading.pose));
        if poses.len() < limits.least_configurations || own.readings.len() == campaign.readings.len() {
            return None;
        }
        let found = all_together(&Evidence::of(evidence.model, &own), limits).into_iter().find(is_explained)?;
        let message =
            format!("in {} `{}`: {}", parts.noun.trim_end_matches('s'), parts.names.get(part)?, found.message);
        Some(Diagnostic { message, ..found })
    };
    let own: Vec<Diagnostic> = (0..parts.names.len()).filter_map(of).collect();
    if own.is_empty() { found } else { own }
}

fn all_together(evidence: &Evidence, limits: &Limits) -> Vec<Diagnostic> {
    let (model, campaign) = (evidence.model, evidence.campaign);
    // What a noise far beyond the robot itself does not place, hundreds of ways to read the files would not either; it is doubted as such.
    if campaign.is_difference() || campaign.readings.is_empty() || is_noise_beyond(model, campaign) {
        return Vec::new();
    }
    let trials = Trials::new(model, campaign, limits);
    // Where the robot cannot be assembled as the files are read, what its tolerances allow is that of a way in which it can.
    let other = || Hypothesis::all(model, campaign).par_iter().find_map_first(|way| trials.allowed(&[*way]));
    let Some(by_tolerances) = trials.allowed(&[]).or_else(other) else { return Vec::new() };
    // Against tolerances that are guesses nothing is far off: beyond a share of the robot's lengths other ways are tried all the same.
    let allowed = by_tolerances.min(limits.hopeless_share * total_length(model) / limits.far);
    // With its scale estimated a registration fits in any unit.
    let observed = match evidence.registered.filter(|_| !campaign.estimate_scale) {
        Some(residual) => typical(campaign, residual, limits),
        None => trials.error(&[]),
    };
    if let Some(computed) = observed.and_then(|observed| computed(evidence, limits, observed)) {
        return vec![computed];
    }
    if observed.is_some_and(|observed| observed <= limits.far * allowed) {
        return Vec::new();
    }
    let before = trials.error(&[]);
    let is_near = |error: Option<f64>| error.is_some_and(|error| error <= limits.far * allowed);
    if is_near(before) || campaign.readings.iter().any(|own| own.observes.touches()) && is_near(trials.registered()) {
        return Vec::new();
    }
    let is_tolerable = before.is_some_and(|before| before <= limits.far * by_tolerances);
    let outlying = || outlying::before(evidence, limits, by_tolerances);
    if let Some(wrong) = before.filter(|_| !is_tolerable).and_then(|_| outlying()) {
        return vec![wrong];
    }
    // A way that leaves hardly less than a robot that stands still explains nothing.
    let decisive = |(ways, error): &Trial| {
        *error <= limits.far * allowed
            && before.is_none_or(|before| error * limits.fall <= before)
            && trials.still(ways).is_none_or(|still| error * limits.fall <= still)
    };
    let (tried, named) = searched(evidence, &trials, limits, decisive);
    // A session that was set up elsewhere explains as much, and is named by its own check.
    if named.is_empty() && (is_tolerable || super::sessions::differ(evidence, limits).is_some()) {
        return Vec::new();
    }
    let allowed = by_tolerances;
    if named.is_empty() {
        // Readings that are all too long, or too short, and by no unit.
        let scaled = trials.scaled().and_then(|way| Some((vec![way], trials.error(&[way])?)));
        if let Some((trial, before)) = scaled.filter(&decisive).zip(before) {
            let parts = |ways: &[Hypothesis]| trials.parts(ways);
            let diagnostic = explained(evidence, "registration", Some(before), &[trial], &parts);
            let severity = severity(evidence, limits, [before, allowed], &trials);
            return vec![Diagnostic { severity, ..diagnostic }.figure("allowed_mm", 1e3 * allowed)];
        }
        return before
            .and_then(|before| unlike(evidence, limits, [before, allowed], &trials, tried))
            .into_iter()
            .collect();
    }
    let parts = |ways: &[Hypothesis]| trials.parts(ways);
    let diagnostic = explained(evidence, "registration", before, &named, &parts).figure("allowed_mm", 1e3 * allowed);
    vec![with_shift(diagnostic, &named, &trials, limits)]
}

/// The same with how far the tool is off, where that is what is wrong.
fn with_shift(diagnostic: Diagnostic, named: &[Trial], trials: &Trials, limits: &Limits) -> Diagnostic {
    let Some((ways, _)) = named.first() else { return diagnostic };
    let is_tool = matches!(ways[..], [Hypothesis::Unknown { base: false, tool: true }]);
    let Some(shift) = is_tool.then(|| trials.tool_shift(ways)).flatten() else { return diagnostic };
    let (size, axis) = (shift.norm(), shift.iamax());
    let is_radius = size < limits.reflector && shift[axis].abs() > ALONG * size;
    let what = if is_radius { ": is the radius of a reflector missing?" } else { "" };
    let axis = ["x", "y", "z"][axis];
    let message = format!("{} It comes out {} mm away, most of it along {axis}{what}", diagnostic.message, mm(size));
    Diagnostic { message, ..diagnostic }.figure("shift_mm", 1e3 * size)
}

/// Share of a displacement along one axis from which it is one along that axis.
const ALONG: f64 = 0.9;

/// How many ways were tried, and those that explain, the best first: single ones; else signs of several joints together, and
/// two ways at once.
fn searched(
    evidence: &Evidence,
    trials: &Trials,
    limits: &Limits,
    decisive: impl Fn(&Trial) -> bool,
) -> (usize, Vec<Trial>) {
    let singles: Vec<Vec<Hypothesis>> =
        Hypothesis::all(evidence.model, evidence.campaign).into_iter().map(|way| vec![way]).collect();
    let mut found = tried(trials, &singles);
    let mut count = singles.len();
    // Few configurations are explained by two of hundreds of changes whatever they are.
    let configurations = distinct(evidence.campaign.readings.iter().map(|reading| reading.pose)).len();
    let tells_pairs = configurations >= limits.fewest_configurations;
    if !found.first().is_some_and(&decisive) && tells_pairs {
        let begun: Vec<Hypothesis> = found.iter().take(BEGUN).flat_map(|(ways, _)| ways.iter().copied()).collect();
        let pairs = begun.iter().flat_map(|&first| {
            let others = singles.iter().flatten().filter(move |way| **way != first && !way.undoes(&first));
            others.map(move |&way| vec![first, way])
        });
        let zeros = Hypothesis::two_zeros(evidence.model);
        let elsewhere = Hypothesis::counted_from_elsewhere(evidence.model);
        let signs = signs(evidence.model.variables.len());
        let more: Vec<Vec<Hypothesis>> = signs.into_iter().chain(pairs).chain(zeros).chain(elsewhere).collect();
        count += more.len();
        found = tried(trials, &more);
    }
    // An arm is its own mirror image with some of its joints counted the other way.
    let is_mirrored = |(ways, _): &Trial| ways.iter().any(|way| matches!(way, Hypothesis::Mirrored(..)));
    if found.first().is_some_and(|first| decisive(first) && is_mirrored(first)) {
        let more = signs(evidence.model.variables.len());
        count += more.len();
        found.extend(tried(trials, &more));
        found.sort_by(|a, b| a.1.total_cmp(&b.1));
    }
    found.retain(decisive);
    // More unknowns take up what tolerances make, to a third or so, and readings that are made smaller leave less: a way without
    // either goes before.
    let least = |found: &[Trial]| found.first().map_or(f64::INFINITY, |(_, error)| *error);
    for flatters in [Hypothesis::adds_unknowns, Hypothesis::shrinks] {
        let does = |(ways, _): &Trial| ways.iter().any(flatters);
        let bound = limits.far * least(&found);
        if found.iter().any(|trial| !does(trial) && trial.1 <= bound) {
            found.retain(|trial| !does(trial));
        }
    }
    let bound = AS_GOOD * least(&found);
    found.retain(|trial| trial.1 <= bound);
    if let Some(single) = enough_alone(trials, &found) {
        found = vec![single];
    }
    // The same ways in another order are the same.
    let mut different: Vec<Trial> = Vec::new();
    for trial in found {
        let is_same = |(ways, _): &Trial| ways.len() == trial.0.len() && trial.0.iter().all(|way| ways.contains(way));
        if !different.iter().any(is_same) {
            different.push(trial);
        }
    }
    let mut found = different;
    // Half a turn of a joint whose axis is level reverses gravity as well: a sensor's sign is mistaken more easily than a zero.
    found.sort_by_key(|(ways, _)| !ways.iter().any(|way| matches!(way, Hypothesis::DirectionsReversed(_))));
    found.truncate(SAID);
    (count, found)
}

/// One of two ways that explain the readings together, where it explains them alone once it is searched longer.
fn enough_alone(trials: &Trials, found: &[Trial]) -> Option<Trial> {
    let (ways, least) = found.first().filter(|(ways, _)| ways.len() == 2)?;
    let alone = |way: &Hypothesis| Some((vec![*way], trials.error_searched_long(&[*way])?));
    let best = ways.iter().filter_map(alone).min_by(|a, b| a.1.total_cmp(&b.1))?;
    (best.1 <= AS_GOOD * least).then_some(best)
}

/// Single ways upon which a second one is tried.
const BEGUN: usize = 3;
/// Joints up to which all combinations of signs are tried: 2^7 of them.
const MOST_SIGNS: usize = 7;
/// Ways whose error is within this factor of the best one's are named with it.
pub(super) const AS_GOOD: f64 = 1.25;
/// Most ways named.
pub(super) const SAID: usize = 3;

/// Signs of two joints and more together.
fn signs(joints: usize) -> Vec<Vec<Hypothesis>> {
    if joints > MOST_SIGNS {
        return Vec::new();
    }
    let negated = |pattern: u32| -> Vec<Hypothesis> {
        (0..joints).filter(|k| pattern >> k & 1 == 1).map(Hypothesis::Negated).collect()
    };
    (0..1u32 << joints).filter(|pattern| pattern.count_ones() > 1).map(negated).collect()
}

/// All ways tried, the best first; the order does not depend on threads.
fn tried(trials: &Trials, ways: &[Vec<Hypothesis>]) -> Vec<Trial> {
    let mut found: Vec<Trial> =
        ways.par_iter().filter_map(|ways| trials.error(ways).map(|error| (ways.clone(), error))).collect();
    found.sort_by(|a, b| a.1.total_cmp(&b.1));
    found
}

/// What the best way explains, `fit` being what leaves an error. `parts` are the errors of lengths (m) and rotations (rad) that it
/// leaves of readings of both: one number does not say which of them is wrong.
pub(super) fn explained(
    evidence: &Evidence,
    fit: &str,
    before: Option<f64>,
    named: &[Trial],
    parts: &dyn Fn(&[Hypothesis]) -> Option<[f64; 2]>,
) -> Diagnostic {
    let words = |ways: &[Hypothesis]| -> Vec<Words> {
        ways.iter().map(|way| words_of(way, evidence.model, evidence.campaign)).collect()
    };
    let with =
        |ways: &[Hypothesis]| format!("with {}", joined(words(ways).into_iter().map(|words| words.with), " and "));
    let Some((best, after)) = named.first() else { return Diagnostic::error("") };
    let first = words(best);
    let (scale, unit) = unit_of(evidence.campaign);
    let single = |error: f64| mm(scale * error);
    let found: Vec<Option<[f64; 2]>> = named.iter().map(|(ways, _)| parts(ways)).collect();
    let shown = |k: usize, error: f64| found[k].map_or_else(|| format!("{} {unit}", single(error)), both);
    let at_first = before.and_then(|_| parts(&[]));
    let fall = match (before, at_first) {
        (Some(_), Some(parts)) => format!("the error of {fit} falls from {} to {}", both(parts), shown(0, *after)),
        (Some(before), None) => format!("the error of {fit} falls from {} to {}", single(before), shown(0, *after)),
        (None, _) => format!("the robot can be assembled, and {fit} leaves {}", shown(0, *after)),
    };
    let question = joined(first.iter().map(|words| words.question.clone()), " ");
    let others = named.iter().enumerate().skip(1);
    let others: Vec<String> =
        others.map(|(k, (ways, error))| format!("{} ({})", with(ways), shown(k, *error))).collect();
    let others = if others.is_empty() { String::new() } else { format!("; or {}", others.join(", or ")) };
    let message = format!("{} {fall}: {question}{others}", with(best));
    let code = if first.iter().any(|words| words.is_unit) { Code::WrongUnits } else { Code::Misread };
    let remedies = |words: Vec<Words>| joined(words.into_iter().map(|words| words.remedy), "; ");
    let others = named.iter().skip(1).map(|(ways, _)| remedies(words(ways)));
    let remedy = joined(std::iter::once(remedies(first)).chain(others), "; or: ");
    // Of lengths alone, where they are told apart.
    let length = |parts: Option<[f64; 2]>, error: f64| 1e3 * parts.map_or(error, |[lengths, _]| lengths);
    let diagnostic = Diagnostic::error(message).code(code).remedy(remedy);
    let diagnostic = match before {
        Some(before) => diagnostic.figure("before_mm", length(at_first, before)),
        None => diagnostic,
    };
    diagnostic.figure("after_mm", length(found[0], *after))
}

/// Parts in their order, each once.
fn joined(parts: impl Iterator<Item = String>, between: &str) -> String {
    let mut all: Vec<String> = Vec::new();
    for part in parts {
        if !all.contains(&part) {
            all.push(part);
        }
    }
    all.join(between)
}

/// What no way explains.
fn unlike(
    evidence: &Evidence,
    limits: &Limits,
    [before, allowed]: [f64; 2],
    trials: &Trials,
    tried: usize,
) -> Option<Diagnostic> {
    let (scale, unit) = unit_of(evidence.campaign);
    let shown = |error: f64| format!("{} {unit}", mm(scale * error));
    let left = match trials.parts(&[]) {
        Some(parts) => format!("{} (at an arm of {} mm together {})", both(parts), mm(limits.arm), shown(before)),
        None => shown(before),
    };
    let message = format!(
        "registration leaves {left} where the description's tolerances and the noise allow {}, and none of {tried} other ways to read the \
         files explains it",
        shown(allowed)
    );
    let severity = severity(evidence, limits, [before, allowed], trials);
    let diagnostic = Diagnostic { severity, ..Diagnostic::warning(message) };
    let declared = distinct(evidence.campaign.readings.iter().map(|reading| reading.observes.depends_on()));
    let remedy = format!(
        "compare description and controller: lengths, zeros and senses of the joints; {}; look at some configurations by hand (`residuals`); where many readings \
         are wrong, fit with `--loss tukey`{}",
        declared.join("; "),
        in_several_frames(evidence.campaign).unwrap_or_default()
    );
    Some(
        diagnostic
            .code(Code::UnlikeDescription)
            .remedy(remedy)
            .figure("registration_mm", 1e3 * before)
            .figure("allowed_mm", 1e3 * allowed),
    )
}

/// What to do where something that is sought in the measurement frame is read in several sessions or stations, each with a base of its own.
fn in_several_frames(campaign: &Campaign) -> Option<String> {
    let shared = campaign.sessions.base;
    let part = |reading: &Reading| (shared != Sharing::All).then(|| reading.session.part(shared));
    let is_in_several = |(index, target): &(usize, &Target)| {
        let own = campaign.readings.iter().filter(|reading| reading.target == Some(*index));
        let is_placed = [CONTACT_COLUMN, ANCHOR_COLUMN].contains(&target.column);
        is_placed && target.is_estimated() && distinct(own.map(part)).len() > 1
    };
    let (_, target) = campaign.targets.iter().enumerate().find(is_in_several)?;
    Some(format!(
        "; `{}` is one place in the measurement frame, although each part of the readings has a base of its own: where the instrument moved and not the \
         robot, it is another place in each: `group: session` of a contact, an anchor of another name",
        target.name
    ))
}

/// Whether so great an error is refused, or may be that of a poor description of the right robot.
fn severity(evidence: &Evidence, limits: &Limits, [before, allowed]: [f64; 2], trials: &Trials) -> Severity {
    let reach = total_length(evidence.model);
    // Of a robot that moves little the spread of its readings says more than its lengths.
    let explains_little = trials.still(&[]).is_some_and(|still| before * limits.fall > still);
    let is_hopeless = before > limits.hopeless * allowed && (before > limits.hopeless_share * reach || explains_little);
    if is_hopeless { Severity::Error } else { Severity::Warning }
}

/// Positions that agree with the description, before anything is calibrated, to within less than an instrument reads, its noise not
/// stated: against a stated noise residuals are judged by [`super::stated_noise`].
fn computed(evidence: &Evidence, limits: &Limits, observed: f64) -> Option<Diagnostic> {
    let campaign = evidence.campaign;
    let is_measured =
        |own: &Reading| own.observes.measured_position(&own.measured).is_some() && !own.noise.is_stated[0];
    if observed >= limits.finest || !campaign.readings.iter().all(is_measured) {
        return None;
    }
    let message = format!(
        "with base and tool fitted alone the description predicts these positions to {} mm (median): no instrument measures a robot so well",
        mm(observed)
    );
    let remedy = "look whether they were computed, by the controller from its own model, and not measured; state the noise under \
                  `instrument: {sigma: ..}` if they are simulated";
    Some(Diagnostic::warning(message).code(Code::Implausible).remedy(remedy).figure("registration_mm", 1e3 * observed))
}

/// Share of the error of registration down to which calibration brings it at least, where constants are what is wrong. A judgement;
/// the calibrated machines and practice campaigns that it was tried on are not doubted by it.
const LITTLE: f64 = 0.5;
/// Share of the error, by its median, below which calibration takes nearly all away: a hundredth of its squares is left. A judgement.
const NEARLY_ALL: f64 = 0.1;

/// What calibration leaves where it explains little: more than constants off by their tolerances would leave, were they not fitted; or far
/// more than the stated noise. Readings of which some are of another robot, as one wrong column of one session makes them, pull
/// it to where it fits none.
pub(super) fn describes_the_readings(evidence: &Evidence, limits: &Limits) -> Vec<Diagnostic> {
    let Some(found) = evidence.calibrated() else { return Vec::new() };
    let campaign = evidence.campaign;
    let is_fitted = |index: usize| !found.holds_out(index);
    let left = |residual: &[f64]| {
        let own = errors(campaign, residual, limits).enumerate().filter(|(index, _)| is_fitted(*index));
        median(&mut own.map(|(_, error)| error).collect::<Vec<f64>>())
    };
    let (Some(after), Some(before)) = (left(&found.residual), left(&found.registered)) else { return Vec::new() };
    let (scale, unit) = unit_of(campaign);
    let shown = |metres: f64| mm(scale * metres);
    let is_little = after > LITTLE * before && !campaign.is_difference();
    let allowed = || Trials::new(evidence.model, campaign, limits).allowed(&[]).filter(|allowed| after > *allowed);
    let is_noise_known = campaign.readings.iter().all(|reading| reading.noise.is_stated[0]);
    let ratio = after / noise(campaign);
    // A noise that is stated far too small is reported as such where calibration takes nearly everything away.
    let is_much = after > NEARLY_ALL * before || campaign.is_difference();
    let beyond = if is_noise_known && is_much && ratio > limits.noise_hopeless {
        match campaign.noise_origin {
            NoiseOrigin::Stated => format!("{ratio:.0} times the stated noise"),
            _ => format!("{ratio:.0} times the noise that these readings show without the robot"),
        }
    } else {
        let Some(allowed) = is_little.then(allowed).flatten() else { return Vec::new() };
        format!("where the description's tolerances and the noise allow {} {unit} before it", shown(allowed))
    };
    let message = format!(
        "calibration leaves {} {unit} (median; before it {}), {beyond}: no constants describe these readings together",
        shown(after),
        shown(before)
    );
    let remedy = "compare figures by session and file: a column of one of them may be wrong; look at some configurations by hand (`residuals`)";
    vec![Diagnostic::warning(message).code(Code::UnlikeDescription).remedy(remedy)]
}
