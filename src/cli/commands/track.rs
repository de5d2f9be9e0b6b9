//! `track`: campaigns of one robot over time.

use chrono::{Datelike, NaiveDate};

use super::identify::left_to_fit;
use super::report::page;
use crate::Error;
use crate::cli::args::{AlarmAt, Track as Asked};
use crate::cli::output::Output;
use crate::cli::session::Session;
use crate::cli::values::{known_parameters, within};
use crate::diagnosis::{self, diagnose};
use crate::diagnostic::{Code, Diagnostic};
use crate::estimation::{self, split};
use crate::files::LoadedCampaign;
use crate::model::Model;
use crate::parameter::Group;
use crate::plausibility::{Evidence, Limits, judge};
use crate::render::diagnosis::finding;
use crate::render::html::track_page;
use crate::render::track as render;
use crate::results::{self, About, OwnWeight, Track};
use crate::tracking::{
    Calibrated, EventKind, Measured, NextCheck, Settings, TrackingError, calibrated, monitor, next_check, usual_changes,
};

pub fn run(command: &Asked, session: &Session) -> Result<Output, Error> {
    let page = page(session.arguments, "track.html", None)?;
    within("--check", command.check, |v| (0.0..=0.9).contains(&v), "give a share from 0 to 0.9")?;
    let loaded = loaded(command, session)?;
    let (days, unused) = dates(command, &loaded)?;
    let measured = measured(command, session, &loaded, &days)?;
    let bar = session.terminal.bar(None, "{spinner} {msg}");
    let mut progress = |what: &str| bar.set_message(what.to_string());
    let settings = Settings { checks_a_year: f64::from(command.a_year), ..Settings::default() };
    let Some(first) = loaded.first() else { return Err(refused(TrackingError::OneCheck)) };
    let fit = first.robot.raw.calibration.fit.as_ref().map(|fit| (fit, -1.0));
    let all = calibrated(&measured, fit, &estimation::Settings::default(), &mut progress).map_err(refused)?;
    let judged = judged(&all, &measured);
    let history = monitor(&all.checks, &settings).map_err(refused)?;
    let model = &first.robot.model;
    let next = wanted(command, model, &all, &history, &settings)?;
    let mut dates: Vec<Option<String>> = days.iter().map(|date| Some(date.to_string())).collect();
    if all.with_description {
        dates.insert(0, None);
    }
    let unit_of_time = if days.is_empty() { "check" } else { "month" };
    let own_weight = OwnWeight::of_campaign(model, &model.registry.nominal(), &first.campaign);
    let about = About { robot: command.robot.clone(), dates, unit_of_time, own_weight };
    let mut found = Track::new(model, &all, &history, &next, &about, &settings);
    explain(&mut found, &all, &measured, session, &mut progress);
    drop(bar);
    let mut output = Output::new(render::track(&found, session.terminal.screen), &found)?;
    output.diagnostics = loaded.iter().flat_map(|loaded| loaded.diagnostics.clone()).collect();
    output.diagnostics.dedup_by(|a, b| a.message == b.message);
    output.diagnostics.extend(unused);
    output.diagnostics.extend(found.checks.iter().filter_map(|check| of_the_reference(&check.name, check.statistic?)));
    let mut output = output.judged(judged, session.arguments.force)?;
    if page.is_some() {
        output.page("\ncontrol charts", page.as_deref(), track_page(&found)?);
    }
    output.alarm = match command.alarm {
        Some(AlarmAt::Last) => found.last_alarms(),
        Some(AlarmAt::Any) => found.any_alarms(),
        None => false,
    };
    Ok(output)
}

/// What cannot be compared, as it is reported to the user.
fn refused(error: TrackingError) -> Error {
    let remedy = match &error {
        TrackingError::OneCheck => "give two campaigns or more, or a description that `identify --save` wrote",
        TrackingError::Calibration { .. } | TrackingError::NothingKept { .. } => {
            "look at it with `identify`, or leave it out"
        }
        TrackingError::NotConverged { campaign, .. } => {
            let message = format!("{error}");
            let remedy = format!("see what `identify {campaign}` says, or leave it out");
            return Diagnostic::error(message).code(Code::NotConverged).remedy(remedy).into();
        }
        TrackingError::NothingCommon => {
            "compare campaigns that observe the same, at enough poses, and state the noise of the instrument: against a great one no constant shows"
        }
        TrackingError::Singular { .. } => "compare campaigns with noise, and more readings than parameters",
    };
    Diagnostic::error(error.to_string()).code(Code::NotComputed).remedy(remedy).into()
}

/// Days of the campaigns: of `--dates`, else of their certificates where each has one; none where no dates are known, with a
/// warning where some are.
fn dates(command: &Asked, loaded: &[LoadedCampaign]) -> Result<(Vec<NaiveDate>, Option<Diagnostic>), Error> {
    let (given, wanted) = (command.dates.len(), command.campaigns.len());
    if given > 0 && given != wanted {
        let days = if given == 1 { "day" } else { "days" };
        let campaigns = if wanted == 1 { "campaign" } else { "campaigns" };
        let message = format!("--dates has {given} {days} for {wanted} {campaigns}");
        return Err(Error::input(message, "give one for each"));
    }
    let unused = |why: String| {
        let remedy = "write days as 2026-01-31 in all campaigns, or give --dates";
        Some(Diagnostic::warning(format!("{why}: checks count as equally far apart")).remedy(remedy))
    };
    let certified: Vec<Option<String>> = loaded
        .iter()
        .map(|own| own.raw.certificate.as_ref().and_then(|certificate| certificate.date.clone()))
        .collect();
    if given == 0
        && certified.iter().any(Option::is_some)
        && let Some((_, without)) = certified.iter().zip(&command.campaigns).find(|(date, _)| date.is_none())
    {
        return Ok((Vec::new(), unused(format!("`{without}` has no `certificate: date`, and others have one"))));
    }
    let (texts, place) = match given {
        0 => (certified.into_iter().flatten().collect(), "certificate: date"),
        _ => (command.dates.clone(), "--dates"),
    };
    let mut dates: Vec<NaiveDate> = Vec::with_capacity(texts.len());
    for (text, campaign) in texts.into_iter().zip(&command.campaigns) {
        let date = text.trim().parse::<NaiveDate>().ok().filter(|date| date.year() >= FIRST_YEAR);
        let Some(date) = date else {
            // A certificate's date is free text; without a day that can be compared checks count as equally far apart.
            if given == 0 {
                return Ok((Vec::new(), unused(format!("certificate: date: `{text}` of `{campaign}` is no day"))));
            }
            return Err(Error::input(format!("{place}: `{text}` is no day"), "write it as 2026-01-31"));
        };
        if dates.last().is_some_and(|last| *last >= date) {
            let message = format!("{place}: `{text}` of `{campaign}` is not after the day of the campaign before it");
            return Err(Error::input(message, "give campaigns and days in the order of time"));
        }
        dates.push(date);
    }
    Ok((dates, None))
}

/// Least statistic of a campaign that was measured anew: noise alone makes one of the number of parameters.
const SAME: f64 = 1e-6;

/// A warning of a campaign that agrees with what is before it to rounding: the description was calibrated with it.
fn of_the_reference(name: &str, statistic: f64) -> Option<Diagnostic> {
    let message = format!("`{name}` agrees with the reference to rounding: the description was calibrated with it");
    let remedy = "leave it out: it is counted twice, and narrows the reference";
    (statistic < SAME).then(|| Diagnostic::warning(message).code(Code::SuspectReadings).remedy(remedy))
}

/// Years before this one are written with too few digits.
const FIRST_YEAR: i32 = 1000;

/// All campaigns with the robot given, checked to be of it and different.
fn loaded(command: &Asked, session: &Session) -> Result<Vec<LoadedCampaign>, Error> {
    let mut all: Vec<LoadedCampaign> = Vec::with_capacity(command.campaigns.len());
    for name in &command.campaigns {
        let loaded = session.reader.campaign(name, Some(&command.robot))?;
        let own = loaded.raw.robot.as_ref().and_then(|_| session.reader.campaign(name, None).ok());
        if let Some(why) = own.and_then(|own| another(&loaded.robot.model, &own.robot.model)) {
            let message = format!("`{name}` is of another robot than `{}`: {why}", command.robot);
            return Err(Error::input(message, "compare campaigns of one robot"));
        }
        let is_same = |known: &&LoadedCampaign| {
            let (a, b) = (&known.campaign, &loaded.campaign);
            let measured = |of: &crate::description::campaign::Campaign| {
                of.readings.iter().map(|r| r.measured).collect::<Vec<_>>()
            };
            a.joints == b.joints && measured(a) == measured(b)
        };
        if let Some(k) = all.iter().position(|known| is_same(&known)) {
            let first = command.campaigns.get(k).map_or("", String::as_str);
            let message = match first == name {
                true => format!("`{name}` is given twice"),
                false => format!("`{name}` holds the same readings as `{first}`"),
            };
            return Err(Error::input(message, "give each campaign once, in the order of time"));
        }
        all.push(loaded);
    }
    Ok(all)
}

/// Constants farther from another description's than so many tolerances are another robot's: calibration moves them by a few.
const ANOTHER: f64 = 20.0;

/// Why two descriptions cannot be of one robot.
fn another(one: &Model, other: &Model) -> Option<String> {
    let variables = |model: &Model| model.variables.iter().map(|variable| variable.name.clone()).collect::<Vec<_>>();
    let frames = |model: &Model| model.frames.iter().map(|frame| frame.name.clone()).collect::<Vec<_>>();
    if variables(one) != variables(other) || frames(one) != frames(other) {
        return Some("its description has other joints".into());
    }
    let far = one.registry.all().iter().filter(|parameter| parameter.group == Group::Geometry).find(|parameter| {
        let theirs = other.registry.slot(&parameter.name).map(|slot| other.registry[slot].nominal);
        theirs.is_some_and(|theirs| (theirs - parameter.nominal).abs() > ANOTHER * parameter.tolerance)
    });
    far.map(|parameter| format!("`{}` of its description is far off", parameter.name))
}

/// The campaigns as they are compared.
fn measured<'a>(
    command: &Asked,
    session: &Session,
    loaded: &'a [LoadedCampaign],
    days: &[NaiveDate],
) -> Result<Vec<Measured<'a>>, Error> {
    let mut all = Vec::with_capacity(loaded.len());
    for (k, (loaded, name)) in loaded.iter().zip(&command.campaigns).enumerate() {
        let campaign = &loaded.campaign;
        let held_out = split(campaign, command.check, session.seed());
        left_to_fit(campaign, &held_out)?;
        let since_first = days.first().zip(days.get(k)).map(|(first, day)| (*day - *first).num_days() as f64 / MONTH);
        let time = since_first.unwrap_or(k as f64);
        all.push(Measured { name: name.clone(), time, model: &loaded.robot.model, campaign, held_out });
    }
    Ok(all)
}

/// Days in a month, the mean of the Gregorian calendar.
const MONTH: f64 = 365.2425 / 12.0;

/// What is implausible about the campaigns as calibrated, each with its name.
fn judged(all: &Calibrated, measured: &[Measured]) -> Vec<Diagnostic> {
    let of = |((model, found), measured): (&(Model, estimation::Calibration), &Measured)| {
        let judged = judge(&Evidence::with(model, measured.campaign, found), &Limits::default());
        let name = measured.name.clone();
        // Of a robot that stands still there is nothing to calibrate, and noise is what a fit then fits.
        let judged = judged.into_iter().filter(|found| found.code != Code::WorseThanRegistered);
        judged.map(move |found| Diagnostic { message: format!("{name}: {}", found.message), ..found })
    };
    all.campaigns.iter().zip(measured).flat_map(of).collect()
}

/// Poses of the next check for the changes asked for.
fn wanted(
    command: &Asked,
    model: &Model,
    all: &Calibrated,
    history: &crate::tracking::History,
    settings: &Settings,
) -> Result<Vec<NextCheck>, Error> {
    let names = all.checks.first().map_or(&[][..], |check| &check.robot.names);
    let mut changes = Vec::new();
    for text in &command.change {
        let malformed = || Error::input(format!("--change `{text}`"), "write NAME=VALUE, as `3.theta=0.02`");
        let (name, value) = text.split_once('=').ok_or_else(malformed)?;
        let value: f64 =
            value.trim().parse().ok().filter(|value: &f64| value.is_finite() && *value != 0.0).ok_or_else(malformed)?;
        known_parameters(model, [name.trim()])?;
        let parameter = names.iter().position(|known| known == name.trim()).ok_or_else(|| {
            let message = format!("--change `{}`: not all campaigns determine it", name.trim());
            Error::input(message, format!("name one of {}", names.join(", ")))
        })?;
        let slot = model.registry.slot(name.trim()).map(|slot| &model.registry[slot]);
        let size = slot.map_or(1.0, |parameter| results::units::unit(parameter.kind).1);
        changes.push((parameter, value * size));
    }
    if changes.is_empty() {
        changes = usual_changes(&all.checks, settings);
    }
    Ok(next_check(&all.checks, history, &changes, settings).unwrap_or_default())
}

/// What the diagnosis says of campaigns whose change is not one of constants.
fn explain(
    found: &mut Track,
    all: &Calibrated,
    measured: &[Measured],
    session: &Session,
    progress: &mut dyn FnMut(&str),
) {
    let first = usize::from(all.with_description);
    for (check, ((model, _), measured)) in found.checks.iter_mut().skip(first).zip(all.campaigns.iter().zip(measured)) {
        let Some(event) =
            check.event.as_mut().filter(|event| event.kind == EventKind::Effect || event.changes.len() > 1)
        else {
            continue;
        };
        let (campaign, held_out) = (measured.campaign, &measured.held_out);
        progress(&format!("{}: diagnosis", measured.name));
        let settings = diagnosis::Settings::new(campaign, session.seed());
        // What the checks show stands, whether a cause can be sought or not.
        event.diagnosis = Some(match diagnose(model, campaign, held_out, &settings, &mut |_| {}) {
            Ok(diagnosed) => finding(&results::Diagnosis::new(model, campaign, &diagnosed, 0.0)),
            Err(error) => format!("not diagnosed: {error}"),
        });
    }
}
