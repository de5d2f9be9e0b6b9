//! Readings that are simply wrong: a digit that was mistyped, a reflector that was lost. They are few, and far from what all the
//! others say.
//!
//! Before a calibration they are found by fitting base and tool to the others, again and again, until the same ones stay out
//! (least trimmed squares by concentration steps: Rousseeuw and Van Driessen, *Data Min. Knowl. Discov.* 12, 2006). After one, each
//! fitted reading is judged by what the fit would leave of it if it were not fitted (deletion: Cook and Weisberg, *Residuals and
//! Influence in Regression*, 1982, section 2.2), the worst first, and each one held out by its error.

use std::collections::BTreeMap;

use nalgebra::{DMatrix, DVector};

use super::again::fitted;
use super::evidence::{Evidence, Limits};
use super::fitted::Fitted;
use super::shown::{mm, unit_of};
use super::trial::{Trials, errors, is_of_torques, lever, noise, searching};
use crate::description::campaign::{Campaign, Reading};
use crate::diagnostic::{Code, Diagnostic};
use crate::estimation::{Calibration, Settings, calibrate, least_median, registered};
use crate::least_squares::Loss;
use crate::math::quantiles::HUBER;
use crate::math::{median, norm, orthonormal, quantiles::f_tail};
use crate::model::Model;
use crate::observation::Rows;
use crate::prediction::{Linearised, Predictor, residuals};

/// Rounds of registration in which readings are left out.
const ROUNDS: usize = 6;
/// Most readings named in one message.
const NAMED: usize = 3;
/// Median error, in standard deviations of a coordinate, from which the others are not noise alone: half as much again as the 1.54 of
/// three normal coordinates.
const OPEN: f64 = 2.3;
/// Most readings that are taken out of a fit one after the other.
const MOST: usize = 20;

/// What is said of readings that are far from all others when base and tool are fitted to these, where tolerances and noise
/// allow an error of `allowed` (m).
pub(super) fn before(evidence: &Evidence, limits: &Limits, allowed: f64) -> Option<Diagnostic> {
    let (model, campaign) = (evidence.model, evidence.campaign);
    let settings = searching(campaign, limits);
    let count = campaign.readings.len();
    let mut kept = vec![true; count];
    let mut last = Vec::new();
    let mut all = Linearised::default();
    for _ in 0..ROUNDS {
        let own = campaign.select(|index, _| kept[index]);
        let (values, _) = registered(model, &own, &model.registry.nominal(), &settings).ok()?;
        Predictor::new(model, campaign, Vec::new()).ok()?.linearise(&values, false, &mut all).ok()?;
        last = errors(campaign, &all.residual, limits).collect();
        let middle = median(&mut last.clone())?;
        let next: Vec<bool> = last.iter().map(|error| *error <= limits.trimmed * middle).collect();
        let fewest = (1.0 - limits.wrong_share) * count as f64;
        if next == kept || (next.iter().filter(|kept| **kept).count() as f64) < fewest {
            break;
        }
        kept = next;
    }
    let middle = median(&mut last.clone())?;
    let wrong: Vec<usize> = (0..count).filter(|&k| last[k] > limits.hopeless * middle.max(allowed)).collect();
    let is_few = !wrong.is_empty() && wrong.len() as f64 <= limits.wrong_share * count as f64;
    (is_few && middle <= limits.far * allowed).then(|| described(evidence, &wrong, &|k| last[k], middle))
}

/// Greatest share of readings that a registration may leave out: half of them must be right.
const MOST_WRONG: f64 = 0.4;

/// Readings that are far from the others where base and tool are those of the better half ([`least_median`]), and what is said of them.
/// A fit by least squares bends to them, and hides them.
pub fn far_when_registered(model: &Model, campaign: &Campaign, seed: u64) -> Option<(Vec<usize>, Diagnostic)> {
    let limits = Limits::default();
    // Torques say nothing of where the robot stands, and have no scale in common with what does.
    let all = campaign;
    let is_placed = |index: usize| all.readings[index].observes.by_variable().is_none();
    let placed: Vec<usize> = (0..all.readings.len()).filter(|&index| is_placed(index)).collect();
    let campaign = &all.select(|index, _| is_placed(index));
    let settings = searching(campaign, &limits);
    let values = least_median(model, campaign, &model.registry.nominal(), &settings, seed).ok()??;
    let residual = residuals(model, campaign, &values).ok()?;
    let size: Vec<f64> = errors(campaign, &residual, &limits).collect();
    let middle = median(&mut size.clone())?;
    let floor = limits.outlying * (size.len() as f64).cbrt() * middle.max(noise(campaign));
    let wrong: Vec<usize> = (0..size.len()).filter(|&k| size[k] > floor).collect();
    // Where half of a session's or of a marker's are far off, it is not single readings that are wrong.
    let of = |k: usize| (campaign.readings[k].session, campaign.readings[k].marker);
    let is_of_part = |&k: &usize| {
        let all = (0..size.len()).filter(|&other| of(other) == of(k)).count();
        2 * wrong.iter().filter(|&&other| of(other) == of(k)).count() >= all
    };
    let is_few =
        !wrong.is_empty() && wrong.len() as f64 <= MOST_WRONG * size.len() as f64 && !wrong.iter().any(is_of_part);
    let evidence = Evidence::of(model, campaign);
    is_few.then(|| {
        let diagnostic = described(&evidence, &wrong, &|k| size[k], middle);
        (
            wrong.into_iter().map(|k| placed[k]).collect(),
            diagnostic.remedy(
                "they are left out here: correct or delete those rows; with `--loss squares` all readings count alike",
            ),
        )
    })
}

/// How the error of one reading is shown, as [`unit_of`]: among readings of lengths a torque or an orientation alone in its own unit.
fn own_unit(campaign: &Campaign, reading: &Reading) -> (f64, &'static str) {
    let limits = Limits::default();
    let is_mixed = unit_of(campaign).1 == "mm" && reading.observes.length_rows() == 0;
    match reading.observes.by_variable() {
        Some(_) if is_mixed => (1e-3 / lever(reading, 0, false, &limits), "N.m"),
        None if is_mixed => ((1e-3 / limits.arm).to_degrees(), "deg"),
        _ => unit_of(campaign),
    }
}

/// The worst of so many readings, and how many more there are.
fn listed(named: &[String], count: usize) -> String {
    let more = count - named.len();
    named.join(", ") + &if more > 0 { format!(" and {more} more") } else { String::new() }
}

/// Figure of a diagnostic: how many readings are far off.
const READINGS: &str = "readings";

/// How many readings a diagnostic says are far off; `None` of another.
pub fn far_readings(diagnostic: &Diagnostic) -> Option<f64> {
    diagnostic.figures.get(READINGS).copied().filter(|_| diagnostic.code == Code::OutlyingReadings)
}

/// What is said of readings that are far off, of which others leave `left` (m).
fn described(evidence: &Evidence, wrong: &[usize], by: &dyn Fn(usize) -> f64, left: f64) -> Diagnostic {
    let campaign = evidence.campaign;
    let mut worst = wrong.to_vec();
    worst.sort_by(|&a, &b| by(b).total_cmp(&by(a)));
    let (scale, unit) = unit_of(campaign);
    let named: Vec<String> = worst
        .iter()
        .take(NAMED)
        .map(|&k| {
            let reading = &campaign.readings[k];
            let (scale, unit) = own_unit(campaign, reading);
            format!("{} ({} {unit})", campaign.address(reading), mm(scale * by(k)))
        })
        .collect();
    let verb = if wrong.len() == 1 { "is" } else { "are" };
    let message = format!(
        "{} of {} readings {verb} far off where half of the others are within {} {unit}: {}",
        wrong.len(),
        campaign.readings.len(),
        mm(scale * left),
        listed(&named, wrong.len())
    );
    let remedy = match of_one_kind(campaign, wrong) {
        Some((kind, depends_on)) => format!(
            "most readings of {kind} are among them: look at what the campaign declares for these rather than at single rows: {depends_on}"
        ),
        None => correct_rows(evidence).into(),
    };
    Diagnostic::warning(message)
        .code(Code::OutlyingReadings)
        .remedy(remedy)
        .figure(READINGS, wrong.len() as f64)
        .figure("greatest_mm", worst.first().map_or(0.0, |&k| 1e3 * by(k)))
        .figure("others_mm", 1e3 * left)
}

/// What to do about single rows that are far off.
fn correct_rows(evidence: &Evidence) -> &'static str {
    match evidence.found.is_some_and(|found| found.loss != Loss::Squares) {
        true => {
            "look at those rows and correct or delete them: they count little in this fit, and are wrong all the same"
        }
        false => "look at those rows and correct or delete them; or let outliers count little (`--loss huber`)",
    }
}

/// Share of the readings of one kind, and of those that are far off, from which it is that kind that is wrong. A judgement.
const ONE_KIND: [f64; 2] = [0.5, 0.9];

/// The kind, among others, of which most readings are far off and to which nearly all of these belong; and what it depends on.
fn of_one_kind(campaign: &Campaign, wrong: &[usize]) -> Option<(&'static str, &'static str)> {
    let observes = |k: usize| campaign.readings[k].observes;
    let of =
        |kind: &str, all: &mut dyn Iterator<Item = usize>| all.filter(|&k| observes(k).name() == kind).count() as f64;
    let own = observes(*wrong.first()?);
    let every = of(own.name(), &mut (0..campaign.readings.len()));
    let far = of(own.name(), &mut wrong.iter().copied());
    let is_one = (every as usize) < campaign.readings.len();
    let is_wrong = far >= ONE_KIND[0] * every && far >= ONE_KIND[1] * wrong.len() as f64;
    (is_one && is_wrong).then(|| (own.name(), own.depends_on()))
}

/// After a calibration: fitted readings by deletion, held-out ones by their errors.
pub(super) fn after(evidence: &Evidence, limits: &Limits) -> Vec<Diagnostic> {
    let described = |found: (Vec<usize>, Vec<f64>, f64)| by_lengths_or_turned(evidence, limits, found);
    // A robust fit shows what the plain one hides.
    let few = || {
        let plain = outlying(evidence, limits).map(described).or_else(|| turned(evidence, limits));
        plain.or_else(|| {
            let robust = robust(evidence, limits)?;
            let evidence = Evidence::with(evidence.model, evidence.campaign, &robust);
            let few = outlying(&evidence, limits).map(described).or_else(|| turned(&evidence, limits));
            few.or_else(|| many(&evidence, limits))
        })
    };
    many(evidence, limits).or_else(few).into_iter().collect()
}

/// What is said of readings that are far off, or of their orientations where their lengths alone are as those of the others.
fn by_lengths_or_turned(
    evidence: &Evidence,
    limits: &Limits,
    (wrong, size, middle): (Vec<usize>, Vec<f64>, f64),
) -> Diagnostic {
    let campaign = evidence.campaign;
    let lengths = |(reading, rows): (&Reading, &[f64])| norm(&rows[..reading.observes.length_rows().min(rows.len())]);
    let of_lengths = || {
        let found = evidence.found?;
        let all: Vec<f64> = campaign.by_reading(&found.residual, 1).map(lengths).collect();
        let floor = limits.outlying * (all.len() as f64).cbrt() * median(&mut all.clone())?;
        let has_angles = |k: usize| campaign.readings[k].observes.angle_rows() > 0;
        wrong.iter().all(|&k| has_angles(k) && all[k] <= floor).then(|| turned(evidence, limits))?
    };
    of_lengths().unwrap_or_else(|| described(evidence, &wrong, &|k| size[k], middle))
}

/// What is said of readings whose lengths are as those of the others, and whose rotations are far off: each of the two is judged by its
/// own kind.
fn turned(evidence: &Evidence, limits: &Limits) -> Option<Diagnostic> {
    let found = evidence.found.filter(|found| found.converged())?;
    let campaign = evidence.campaign;
    let rotation = |(reading, rows): (&Reading, &[f64])| {
        let lengths = reading.observes.length_rows();
        let has_both = lengths > 0 && reading.observes.angle_rows() > 0;
        has_both.then(|| rows.iter().skip(lengths).map(|row| row * row).sum::<f64>().sqrt())
    };
    let errors: Vec<Option<f64>> = campaign.by_reading(&found.residual, 1).map(rotation).collect();
    let mut known: Vec<f64> = errors.iter().flatten().copied().collect();
    let count = known.len();
    let middle = median(&mut known)?;
    let floor = limits.outlying * (count as f64).cbrt() * middle;
    let mut wrong: Vec<(usize, f64)> =
        errors.iter().enumerate().filter_map(|(k, error)| Some((k, error.filter(|own| *own > floor)?))).collect();
    if wrong.is_empty()
        || wrong.len() as f64 > limits.wrong_share * count as f64
        || count < limits.fewest_configurations
    {
        return None;
    }
    wrong.sort_by(|a, b| b.1.total_cmp(&a.1));
    let shown = |angle: f64| format!("{:.3} deg", angle.to_degrees());
    let named: Vec<String> = wrong
        .iter()
        .take(NAMED)
        .map(|(k, error)| format!("{} ({})", campaign.address(&campaign.readings[*k]), shown(*error)))
        .collect();
    let message = format!(
        "orientations of {} of {count} readings are far off where half of the others are within {}: {}",
        wrong.len(),
        shown(middle),
        listed(&named, wrong.len())
    );
    let diagnostic = Diagnostic::warning(message).code(Code::OutlyingReadings).remedy(correct_rows(evidence));
    Some(diagnostic.figure(READINGS, wrong.len() as f64))
}

/// What is said where more readings than can be simply wrong are far from the others: a robust loss fits these, and bears those in
/// silence.
fn many(evidence: &Evidence, limits: &Limits) -> Option<Diagnostic> {
    let found = evidence.found.filter(|found| found.converged())?;
    let campaign = evidence.campaign;
    let size: Vec<f64> = errors(campaign, &found.residual, limits).collect();
    let middle = median(&mut size.clone())?;
    let least = Fitted::of(evidence)?.least();
    let allowances = allowances(campaign, &size, least, limits);
    let is_beyond = |floor: f64, k: usize| size[k] > floor * allowances[k];
    let beyond = |floor: f64| (0..size.len()).filter(|&k| is_beyond(floor, k)).count();
    let is_few = |far: usize| (far as f64) < limits.wrong_share * size.len() as f64;
    if is_few(beyond(limits.outlying_open * middle)) {
        return None;
    }
    let floor = limits.outlying_open * middle.max(least);
    // Torques and positions have no scale in common: of the kind that is far off, half are near.
    let mut kinds: BTreeMap<&str, [usize; 2]> = BTreeMap::new();
    for (k, reading) in campaign.readings.iter().enumerate() {
        let [all, far] = kinds.entry(reading.observes.name()).or_default();
        *all += 1;
        *far += usize::from(is_beyond(floor, k));
    }
    let far: usize = kinds.values().filter(|[all, far]| 2 * far < *all).map(|[_, far]| far).sum();
    if is_few(far) {
        return None;
    }
    let (scale, unit) = unit_of(campaign);
    let message = format!(
        "{far} of {} readings are more than {} {unit} off where half of all are within {} {unit}: a part of the readings is of something else",
        size.len(),
        mm(scale * floor),
        mm(scale * middle),
    );
    let remedy = "find what they have in common (a session, a marker, a time: `residuals` lists them) and leave them out, or say what differs there";
    let diagnostic = Diagnostic::warning(message).code(Code::UnlikeDescription).remedy(remedy);
    Some(diagnostic.figure(READINGS, far as f64).figure("others_mm", 1e3 * middle))
}

/// Residuals over the stated noise from which outliers may have hidden each other, or a wrong constraint may hold: a judgement, which decides
/// only whether a further fit is made.
pub(super) const HIDING: f64 = 1.2;

/// Root mean square over median of errors, over that of three normal coordinates, from which they have long tails: where one in a hundred is four
/// times the others' size. It decides only whether a further fit is made.
const LONG_TAILS: f64 = 1.07;

/// Median error of three normal coordinates over its root mean square, sqrt(2.366 / 3).
const MEDIAN: f64 = 0.888;

/// Readings up to which a further fit costs little: many outliers among so few can bend the plain one until its residuals have no tails.
const FEW: usize = 600;

/// The same parameters fitted by a loss that many outliers do not bend, where more than the stated noise is left; where none is stated, where readings
/// are few or errors have long tails.
fn robust(evidence: &Evidence, limits: &Limits) -> Option<Calibration> {
    let (model, campaign) = (evidence.model, evidence.campaign);
    let has_tails = |found: &Calibration| {
        let mut size: Vec<f64> = errors(campaign, &found.residual, limits).collect();
        let rms = (size.iter().map(|own| own * own).sum::<f64>() / size.len().max(1) as f64).sqrt();
        median(&mut size).is_some_and(|middle| MEDIAN * rms > LONG_TAILS * middle)
    };
    let found = evidence.found.filter(|found| match campaign.sigma {
        Some(_) => found.noise_ratio > HIDING,
        None => campaign.readings.len() <= FEW || has_tails(found),
    })?;
    let loss = Loss::Huber(HUBER);
    let asked = Settings { only: Some(found.kept_slots()), loss, second_order: false, ..Settings::default() };
    calibrate(model, campaign, &found.held_out, &asked, &mut |_| {}).ok().filter(Calibration::converged)
}

/// Readings that are far off after a calibration, by index, the errors of all and the median of the others' (m).
pub(super) fn outlying(evidence: &Evidence, limits: &Limits) -> Option<(Vec<usize>, Vec<f64>, f64)> {
    let found = evidence.found.filter(|found| found.converged())?;
    let campaign = evidence.campaign;
    let mut size: Vec<f64> = errors(campaign, &found.residual, limits).collect();
    let mut fit = Fitted::of(evidence)?;
    let most = (limits.wrong_share * size.len() as f64) as usize;
    let least = fit.least();
    // Many together hide each other from deletion, and are plain where a robust loss has not let them bend the fit.
    let floor = limits.outlying_open * median(&mut size.clone())?.max(least);
    let allowances = allowances(campaign, &size, least, limits);
    let is_plain = |reading: usize| size[reading] > floor * allowances[reading];
    let plain: Vec<usize> = (0..fit.readings().len()).filter(|&k| is_plain(fit.reading(k))).collect();
    let plain = if plain.len() < most { plain } else { Vec::new() };
    let mut wrong: Vec<usize> = plain.iter().map(|&k| fit.reading(k)).collect();
    plain.into_iter().for_each(|k| fit.leave_out(k));
    fit.errors(limits).into_iter().for_each(|(reading, error)| size[reading] = error);
    while let Some((k, by)) = fit.worst(limits).filter(|_| wrong.len() < MOST) {
        fit.leave_out(k);
        wrong.push(fit.reading(k));
        size[fit.reading(k)] = by;
        // Of the others without it.
        for (reading, error) in fit.errors(limits) {
            size[reading] = error;
        }
    }
    // What a fit of hardly more rows than parameters leaves says nothing of readings that it did not see.
    let tells_others = 2.0 * fit.freedom() >= fit.residual.len() as f64;
    let far = |size: &[f64], among: &[usize], response: Option<&[f64]>| -> Option<(Vec<usize>, f64)> {
        let others = (0..size.len()).filter(|k| !among.contains(k)).map(|k| size[k]);
        let middle = median(&mut others.collect::<Vec<f64>>())?;
        let mut factor = limits.outlying * (size.len() as f64).cbrt();
        // What a model does not describe is no noise, and may be great at a few readings: of deflections in proportion to them.
        let is_open = middle > OPEN * least;
        let response = response.filter(|_| is_open);
        if response.is_some() {
            factor = factor.max(limits.outlying_open);
        }
        let floor = factor * middle.max(least);
        let in_proportion = |k: usize| response.and_then(|all| all.get(k)).copied().unwrap_or(1.0);
        let is_far = |&k: &usize| {
            size[k] > floor * allowances[k] * in_proportion(k)
                && (among.contains(&k) || tells_others && found.holds_out(k))
        };
        let mut far: Vec<usize> = (0..size.len()).filter(is_far).collect();
        // Most of those held out are not wrong: few readings do not tell what others are.
        let held_out = |all: &mut dyn Iterator<Item = usize>| all.filter(|&k| found.holds_out(k)).count();
        if 2 * held_out(&mut far.iter().copied()) > held_out(&mut (0..size.len())) {
            far.retain(|&k| !found.holds_out(k));
        }
        (!far.is_empty()).then_some((far, middle))
    };
    let (mut wrong, middle) = far(&size, &wrong, None)?;
    // Deletion is to first order, and a reading that is far off bends the fit and makes others look so: once more, fitted without
    // the worst of them.
    wrong.sort_by(|&a, &b| size[b].total_cmp(&size[a]));
    wrong.truncate(most);
    let (wrong, size, middle) = match without(evidence, &wrong, limits) {
        None => (wrong, size, middle),
        Some((size, response)) => far(&size, &wrong, Some(&response)).map(|(wrong, middle)| (wrong, size, middle))?,
    };
    (wrong.len() < most.max(2)).then_some((wrong, size, middle))
}

/// How many times farther off than the others each reading may be: its noise, where that is stated, over the median of all, at least 1, since
/// kinds of readings, files and rows may state noises of their own; and the median error of places, and of deflections, over that of all: nothing that
/// moves the unloaded robot is part of a deflection or a torque. `least` is an error of the noise, m.
fn allowances(campaign: &Campaign, size: &[f64], least: f64, limits: &Limits) -> Vec<f64> {
    let torques = is_of_torques(campaign);
    let stated = |reading: &Reading| {
        let is_stated = |row: usize| {
            let lengths = reading.observes.length_rows();
            let kind = if reading.observes.by_variable().is_some() { 2 } else { usize::from(row >= lengths) };
            reading.noise.is_stated[kind]
        };
        let sigmas = reading.observes.sigmas(&reading.noise).into_iter().take(reading.observes.rows()).enumerate();
        let own = sigmas.filter(|(row, _)| is_stated(*row));
        own.map(|(row, sigma)| (lever(reading, row, torques, limits) * sigma).powi(2)).sum::<f64>().sqrt()
    };
    let stated: Vec<f64> = campaign.readings.iter().map(stated).collect();
    let usual = median(&mut stated.clone()).unwrap_or_default();
    let by_noise = stated.into_iter().map(|own| if usual > 0.0 { (own / usual).max(1.0) } else { 1.0 });
    let middle = |is_own: &dyn Fn(&Reading) -> bool| {
        let own = campaign.readings.iter().zip(size).filter(|(reading, _)| is_own(reading));
        median(&mut own.map(|(_, size)| *size).collect::<Vec<f64>>()).unwrap_or_default().max(least)
    };
    let all = middle(&|_| true);
    let is_place = |reading: &Reading| !reading.observes.is_difference() && reading.observes.by_variable().is_none();
    let places = middle(&is_place);
    let differences = middle(&|reading| reading.observes.is_difference());
    let of_kind = |reading: &Reading| match (reading.observes.is_difference(), is_place(reading)) {
        _ if all <= 0.0 => 1.0,
        (true, _) => differences / all,
        (_, true) => places / all,
        // Of torques half are near where the model says what they hold.
        _ => 1.0,
    };
    by_noise.zip(&campaign.readings).map(|(by_noise, reading)| by_noise * of_kind(reading)).collect()
}

/// Errors (m) of all readings, the same parameters fitted without some, and [`responses`]; `None` where that cannot be done.
fn without(evidence: &Evidence, wrong: &[usize], limits: &Limits) -> Option<(Vec<f64>, Vec<f64>)> {
    let (model, campaign, found) = (evidence.model, evidence.campaign, evidence.found?);
    let is_used = |k: usize| !found.holds_out(k) && !wrong.contains(&k);
    let some = campaign.select(|index, _| is_used(index));
    let none = vec![false; some.readings.len()];
    let fitted = fitted(model, &some, &none, Some(found.kept_slots()))?;
    let mut all = Linearised::default();
    Predictor::new(model, campaign, Vec::new()).ok()?.linearise(&fitted.values, false, &mut all).ok()?;
    Some((errors(campaign, &all.residual, limits).collect(), responses(campaign, &all.predicted)))
}

/// Predicted deflections over the median of all, at least 1: near a singular posture what a constant is off by moves the
/// point so much farther. 1 of readings that are no deflections.
fn responses(campaign: &Campaign, predicted: &[Rows]) -> Vec<f64> {
    let length = |(reading, rows): (&Reading, &Rows)| {
        let lengths = rows.iter().take(reading.observes.length_rows());
        lengths.map(|row| row * row).sum::<f64>().sqrt()
    };
    let size: Vec<f64> = campaign.readings.iter().zip(predicted).map(length).collect();
    match median(&mut size.clone()).filter(|middle| campaign.is_difference() && *middle > 0.0) {
        Some(middle) => size.into_iter().map(|own| (own / middle).max(1.0)).collect(),
        None => vec![1.0; size.len()],
    }
}

/// Readings that are simply wrong, where a calibration could not be computed with them: by registration, and already where
/// they are as far off as tolerances could put them.
pub(super) fn before_failure(evidence: &Evidence, limits: &Limits) -> Option<Diagnostic> {
    let allowed = Trials::new(evidence.model, evidence.campaign, limits).allowed(&[])?;
    before(evidence, &Limits { hopeless: limits.far, ..*limits }, allowed)
}

impl Fitted<'_> {
    /// The fitted reading that a fit without it would leave most certainly elsewhere, and how far (m).
    fn worst(&self, limits: &Limits) -> Option<(usize, f64)> {
        let total = self.residual.norm_squared();
        let mut best: Option<(usize, f64, f64)> = None;
        for k in 0..self.rows.len().saturating_sub(1) {
            let own = self.rows[k]..self.rows[k + 1];
            if self.is_out[k] || own.is_empty() {
                continue;
            }
            let residual = self.residual.rows(own.start, own.len());
            // Without columns the residual itself is the least that it can be.
            let basis = self.basis.rows(own.start, own.len());
            let free = DMatrix::identity(own.len(), own.len()) - basis * basis.transpose();
            let Some(deleted) = free.cholesky().map(|factor| factor.solve(&residual)) else { continue };
            let gain = residual.dot(&deleted);
            if best.as_ref().is_none_or(|(_, most, _)| gain > *most) {
                best = Some((k, gain, self.distance(k, &deleted, limits)));
            }
        }
        let (k, gain, by) = best?;
        let count = (self.rows[k + 1] - self.rows[k]) as f64;
        let freedom = self.freedom() - count;
        if freedom < limits.noise_freedom {
            return None;
        }
        let ratio = (gain / count) / ((total - gain).max(f64::MIN_POSITIVE) / freedom);
        let chance = f_tail(ratio, count, freedom) * self.rows.len() as f64;
        (chance < limits.chance).then_some((k, by))
    }

    /// Takes a reading out of the fit.
    pub(super) fn leave_out(&mut self, k: usize) {
        let own = self.rows[k]..self.rows[k + 1];
        let mut columns = DMatrix::zeros(self.residual.len(), own.len());
        own.enumerate().for_each(|(column, row)| columns[(row, column)] = 1.0);
        let added = orthonormal(&columns, Some(&self.basis));
        // What a robust loss leaves is not orthogonal to what its parameters span.
        let spanned: DVector<f64> = self.basis.tr_mul(&self.residual);
        self.residual -= &self.basis * spanned;
        let part: DVector<f64> = added.tr_mul(&self.residual);
        self.residual -= &added * part;
        self.basis = crate::math::joined(&self.basis, &added);
        self.is_out[k] = true;
    }
}
