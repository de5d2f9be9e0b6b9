//! `diagnose`: where the gap lies, which effect causes it, how far it shrinks.

use std::path::Path;
use std::time::Instant;

use super::convert::{Expected, can_write, error, leaves, read_back, unusable, written};
use super::identify::{certain, has_lengths, left_to_fit, not_computed};
use crate::Error;
use crate::cli::args::Diagnose;
use crate::cli::output::Output;
use crate::cli::session::Session;
use crate::description::campaign::{Campaign, Reading};
use crate::description::raw::{RawApplied, RawRobot, RawValidity};
use crate::diagnosis::{Cause, Diagnosis, Level, Settings, diagnose};
use crate::diagnostic::{Code, Diagnostic};
use crate::effects::EffectEntry;
use crate::estimation::{self, changes, not_stated};
use crate::files::LoadedRobot;
use crate::model::{Model, with_values};
use crate::observation::Purpose;
use crate::parameter::Group;
use crate::plausibility::{Evidence, Limits, doubts, far_readings, judge};
use crate::render::diagnosis as render;
use crate::results;
use crate::results::Since;
use crate::results::units::mm;

pub fn run(command: &Diagnose, session: &Session) -> Result<Output, Error> {
    let seed = session.seed();
    command.apply.as_deref().map_or(Ok(()), can_write)?;
    let loaded = session.reader.campaign(&command.campaign, command.since.as_deref().or(command.robot.as_deref()))?;
    let model = &loaded.robot.model;
    let campaign = &loaded.campaign;
    let held_out: Vec<bool> = campaign.readings.iter().map(|reading| reading.check == Some(true)).collect();
    left_to_fit(campaign, &held_out)?;
    has_lengths(campaign)?;
    let mut judged = judge(&Evidence::of(model, campaign), &Limits::default());
    let force = session.arguments.force;
    Output::gate(&judged, force, &loaded.diagnostics)?;
    let bar = session.terminal.bar(None, "{spinner} {msg}");
    let started = Instant::now();
    let mut progress = |doing: &str| bar.set_message(doing.to_string());
    let found = diagnose(model, campaign, &held_out, &Settings::new(campaign, seed), &mut progress)
        .map_err(|error| not_computed(error.into(), model, campaign, session))?;
    drop(bar);
    let seconds = started.elapsed().as_secs_f64();
    let mut result = results::Diagnosis::new(model, campaign, &found, seconds);
    result.since = command.since.as_deref().map(|name| since(name, &loaded.robot, campaign, &found)).transpose()?;
    let mut output = Output::new(render::diagnosis(&result, session.terminal.screen), &result)?;
    output.diagnostics = loaded.diagnostics;
    output.diagnostics.extend(result.since.as_ref().and_then(certain));
    judged.extend(doubts(model, campaign, &found, &Limits::default()));
    let written = Described::new(&loaded.robot, campaign, &found);
    judged.extend(worse_than_found(&written, session)?);
    let mut output = output.judged(judged, session.arguments.force)?;
    output.diagnostics.extend(nothing_refitted(campaign, model));
    match &command.apply {
        Some(path) => apply(path, written, output, session),
        None => Ok(output),
    }
}

/// What has moved since the description `name` that was diagnosed: the constants and springs of which it states uncertainties, fitted without
/// causes and without outliers.
fn since(name: &str, robot: &LoadedRobot, campaign: &Campaign, found: &Diagnosis) -> Result<Since, Error> {
    let (raw, model) = (&robot.raw, &robot.model);
    let own = campaign.select(|_, reading| !found.outliers.contains(&reading.row));
    let held_out: Vec<bool> = own.readings.iter().map(|reading| reading.check == Some(true)).collect();
    let settings = estimation::comparable(raw, model, &own, estimation::Settings::default())?;
    let fitted = estimation::calibrate(model, &own, &held_out, &settings, &mut |_| {})?;
    Ok(Since::new(name, model, &changes(raw, model, &fitted), &not_stated(raw, model, &fitted)))
}

/// The description as diagnosed, and what it is of.
pub struct Described<'a> {
    raw: RawRobot,
    /// The same without what stays of causes that belong to the session: with these themselves it is what was diagnosed.
    without_rest: RawRobot,
    expected: Expected<'a>,
    found: &'a Diagnosis,
    /// Of what belongs to the session, and is left out.
    of_the_session: Vec<Diagnostic>,
}

impl<'a> Described<'a> {
    pub fn new(robot: &'a LoadedRobot, campaign: &'a Campaign, found: &'a Diagnosis) -> Self {
        let model = &robot.model;
        let mut raw = with_values(&robot.raw, model, &found.values);
        let mut without_rest = raw.clone();
        let of_the_session = applied(&mut raw, model, found, true);
        applied(&mut without_rest, model, found, false);
        if !raw.effects.is_empty() || model.registry.nominal() != found.values {
            raw.validity = Some(RawValidity::of(campaign, &model.variable_names()));
        }
        let expected = Expected { campaign, residual: None, fitted: (model, &found.values) };
        Self { raw, without_rest, expected, found, of_the_session }
    }
}

/// The description without what belongs to the session, with what that was fitted together with fitted anew: base and tool, which drifts
/// start from; all that was re-fitted where what is left out is no law, since a curve takes part of what constants do, and where the others leave
/// more than calibration alone. `None` where that cannot be fitted.
fn placed_anew(described: &Described, session: &Session) -> Result<Option<RawRobot>, Error> {
    let Described { raw, found, expected: Expected { campaign, fitted: (of, _), .. }, .. } = described;
    let Some(robot) = read_back(raw, session)? else { return Ok(None) };
    let model = robot.model.arranged(campaign);
    let is_left_out = |cause: &Cause| cause.entries.iter().any(|entry| cause.is_of_the_session(entry));
    let are_laws = found.causes.iter().filter(|cause| is_left_out(cause)).all(|cause| cause.level == Level::Law);
    let refitted = found.refitted.iter().filter_map(|&slot| model.registry.slot(&of.registry[slot].name));
    let is_worse = found.rms_of_robot.is_some_and(|left| left > found.gap.rms);
    let only = if are_laws && !is_worse { Vec::new() } else { refitted.collect() };
    let is_used = |reading: &Reading| !found.outliers.contains(&reading.row);
    let own = campaign.select(|_, reading| is_used(reading));
    let held_out: Vec<bool> = own.readings.iter().map(|reading| reading.check == Some(true)).collect();
    let settings = estimation::Settings { only: Some(only), second_order: false, ..estimation::Settings::default() };
    let fitted = estimation::calibrate(&model, &own, &held_out, &settings, &mut |_| {});
    let fitted = fitted.ok().filter(estimation::Calibration::converged);
    Ok(fitted.map(|fitted| with_values(raw, &model, &fitted.values)))
}

/// Writes the description as diagnosed, where it may be.
fn apply(path: &Path, described: Described, mut output: Output, session: &Session) -> Result<Output, Error> {
    let anew = if described.of_the_session.is_empty() { None } else { placed_anew(&described, session)? };
    let Described { raw, expected, found, of_the_session, .. } = described;
    let raw = anew.unwrap_or(raw);
    // Readings that are far off are borne where all of them were set aside.
    let is_borne =
        |diagnostic: &Diagnostic| far_readings(diagnostic).is_some_and(|count| count <= found.outliers.len() as f64);
    let doubt = output.doubt_in_values(session.arguments.force, is_borne);
    if doubt.is_some() {
        output.text.push('\n');
        output.not_written(path, doubt);
        return Ok(output);
    }
    let refused = unusable(&raw, session, &expected)?;
    if refused.is_some() {
        output.text.push('\n');
        output.not_written(path, None);
        return output.judged(refused.into_iter().collect(), session.arguments.force);
    }
    let (text, diagnostics) = written(&raw, path)?;
    output.diagnostics.extend(diagnostics);
    output.diagnostics.extend(of_the_session);
    output.file("\ndescription as diagnosed", path, text);
    Ok(output)
}

/// A written description may leave so many times of what the causes were found to leave. That is of readings which were not fitted, and
/// mostly more than is left of those that were; over the dozen configurations that a diagnosis needs at least it scatters by a
/// tenth or two. Half as much again is no chance.
const BEYOND: f64 = 1.5;

/// What is left of exact readings by rounding alone, m.
const ROUNDING: f64 = 1e-8;

/// A doubt where the description, read back, leaves more of the readings than was found to be left.
pub fn worse_than_found(described: &Described, session: &Session) -> Result<Option<Diagnostic>, Error> {
    let Described { without_rest: raw, expected, found, .. } = described;
    let (campaign, model) = (expected.campaign, expected.fitted.0);
    let used = |reading: usize| !found.outliers.contains(&campaign.readings[reading].row);
    let of_session = found.causes.iter().flat_map(|cause| cause.entries.iter().map(move |entry| (cause, entry)));
    let of_session: Vec<EffectEntry> =
        of_session.filter(|(cause, entry)| cause.is_of_the_session(entry)).map(|(_, entry)| entry.clone()).collect();
    let Some(left) = leaves(raw, session, expected, &of_session, used)? else { return Ok(None) };
    let claimed = found.rms_after.max(found.gap.noise) + ROUNDING;
    let limit = (BEYOND * claimed).max(found.rms_after_ci95.map_or(0.0, |[_, most]| most));
    let without = error(model, &found.calibrated, campaign, used).filter(|_| !found.causes.is_empty());
    let is_worse = without.is_some_and(|without| left > without.max(claimed));
    if left <= limit && !is_worse {
        return Ok(None);
    }
    let has_springs = model.registry.all().iter().any(|parameter| parameter.group == Group::Elastic && parameter.free);
    let [what, why, remedy] = match found.causes.is_empty() {
        true if !has_springs => [
            "the calibrated description",
            "what the noise of these configurations hides stays as described, and is more than that elsewhere",
            "measure configurations that differ more, or see what `identify` leaves and which parameters it keeps",
        ],
        true => [
            "the calibrated description",
            "its springs are held above zero, and what the noise hides as described",
            "`identify` says which parameters are weak, and which springs end at a bound: a load, a payload or the gravity may be declared wrong",
        ],
        false => [
            "the description with the causes",
            "it was computed to first order, which the amounts exceed",
            "mend the first cause in the description (its size, its springs), or measure poses that separate the tied causes, and diagnose again",
        ],
    };
    let message = format!(
        "{what}, read back, leaves {:.4} mm of the readings, and the diagnosis {:.4} mm: {why}",
        mm(left),
        mm(claimed)
    );
    Ok(Some(
        Diagnostic::warning(message)
            .code(Code::UnusableResult)
            .remedy(remedy)
            .figure("left_mm", mm(left))
            .figure("claimed_mm", mm(claimed)),
    ))
}

/// A warning where nothing is re-fitted: what `identify` fits then competes as causes.
fn nothing_refitted(campaign: &Campaign, model: &Model) -> Option<Diagnostic> {
    let [message, remedy] = match campaign.purpose() {
        Purpose::Geometry => [
            "`calibrate:` of the campaign is empty: geometry competes as a cause, a frame at a time",
            "leave `calibrate:` out if the robot has not been calibrated",
        ],
        Purpose::Stiffness if model.elastic_slots().is_empty() => return None,
        Purpose::Stiffness => [
            "`calibrate:` of the campaign is empty: springs compete as causes, one at a time; `identify` fits all of them",
            "leave `calibrate:` out, or name them there, if they have not been identified",
        ],
    };
    campaign.calibrate.is_empty().then(|| Diagnostic::warning(message).remedy(remedy))
}

/// Writes the causes into a description, with what each was tied with. What belongs to the session, and not to the robot,
/// is left out, and said; with what stays of it where that is asked for.
fn applied(raw: &mut RawRobot, model: &Model, found: &Diagnosis, keeps_rest: bool) -> Vec<Diagnostic> {
    let mut left_out = Vec::new();
    for cause in &found.causes {
        for entry in &cause.entries {
            let own = entry.to_string();
            if let Some(stays) = cause.remains(model, entry) {
                let message =
                    format!("{own} belongs to this session: the robot is written as it is after it, with {stays}");
                raw.effects.extend(keeps_rest.then(|| stays.raw(model)));
                let remedy = "leave that entry out of `effects` if the joint has been set back since";
                left_out.push(Diagnostic::warning(message).code(Code::OfTheSession).remedy(remedy));
                continue;
            }
            if cause.is_of_the_session(entry) {
                let message = format!("{own} belongs to this session, and is not written into the robot");
                left_out.push(
                    Diagnostic::warning(message)
                        .code(Code::OfTheSession)
                        .remedy("write it under `effects` by hand to keep it"),
                );
                continue;
            }
            let mut written = entry.raw(model);
            if !cause.rivals.is_empty() {
                let others = cause.rivals.iter().map(|rival| format!("{}@{}", rival.effect, rival.site));
                let mut tied = vec![own.clone()];
                for other in others {
                    if !tied.contains(&other) {
                        tied.push(other);
                    }
                }
                written.applied = Some(RawApplied { member: Some(own), tied });
            }
            raw.effects.push(written);
        }
    }
    left_out
}
