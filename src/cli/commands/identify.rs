//! `identify`: calibration.

use std::path::Path;
use std::time::Instant;

use super::convert::{Expected, can_write, unusable, written};
use super::identifiability::{reduction, what};
use crate::Error;
use crate::cli::args::{Identify, LossName, Robust};
use crate::cli::output::Output;
use crate::cli::session::Session;
use crate::cli::values::{known_parameters, within};
use crate::description::campaign::{Campaign, Sharing};
use crate::description::raw::{RawRobot, RawValidity};
use crate::diagnostic::{Code, Diagnostic};
use crate::effects::{Family, Nonlinear, Site};
use crate::estimation::{
    Calibration, CalibrationError, OtherSet, Settings, What, against, calibrate, changes, comparable, compare,
    loss_fault, not_stated, split, with_uncertainties,
};
use crate::files::{LoadedCampaign, writable_table};
use crate::least_squares::Loss;
use crate::math::distinct;
use crate::math::quantiles::{HUBER, TUKEY};
use crate::model::{Model, of_sessions, with_values};
use crate::parameter::{Group, Slot};
use crate::plausibility::{Evidence, Limits, forced, is_above_noise, judge, why_not_computed};
use crate::prediction::with_holding_loads;
use crate::render::identification as render;
use crate::render::tables;
use crate::results::{AgainstOther, CombinedParameters, Identification, SchemeComparison, Since};

pub fn run(command: &Identify, session: &Session) -> Result<Output, Error> {
    let seed = session.seed();
    let by_rules = super::identify_fuzzy::asked(command)?;
    let what = if by_rules { None } else { what(&command.what)? };
    let loss = loss(&command.robust)?;
    can_be_done(command, by_rules)?;
    let (scaling, criterion) = reduction(&command.reduction)?;
    let loaded = session
        .reader
        .campaign(&command.campaign, command.since.as_ref().or(command.robot.as_ref()).map(String::as_str))?;
    let model = &loaded.robot.model;
    known_parameters(model, command.reduction.hold.iter().map(String::as_str))?;
    let mut settings = Settings { scaling, criterion, loss, ..settings(command, what) };
    if command.since.is_some() {
        settings = comparable(&loaded.robot.raw, model, &loaded.campaign, settings)?;
    }
    let campaign = match command.train {
        Some(count) => fewer(&loaded.campaign, count, command.check, seed)?,
        None => loaded.campaign.clone(),
    };
    let held_out = split(&campaign, command.check, seed);
    left_to_fit(&campaign, &held_out)?;
    if by_rules {
        return super::identify_fuzzy::run(command, &loaded, &campaign, &held_out, &settings, session);
    }
    if command.compare {
        let started = Instant::now();
        let both = compare(model, &campaign, &held_out, &settings)?;
        let found = SchemeComparison::new(model, &campaign, &both, started.elapsed().as_secs_f64());
        let mut output = Output::new(render::comparison(&found, session.terminal.screen), &found)?;
        output.diagnostics = loaded.diagnostics;
        return Ok(output);
    }
    let mut other =
        command.against.as_deref().map(|name| other(name, &command.campaign, &loaded, session)).transpose()?;
    if let (Some(Other { loaded, .. }), Some(count)) = (&mut other, command.train) {
        loaded.campaign = fewer(&loaded.campaign, count, command.check, seed)?;
    }
    let asked = Asked {
        since: command.since.as_deref(),
        against: other.as_ref(),
        save: command.save.as_deref(),
        table: command.table.as_deref(),
        configurations: command.configurations.as_deref(),
        parts: command.parts.as_deref(),
    };
    calibrated(session, &loaded, &campaign, &held_out, &settings, &asked)
}

/// Refuses options out of range, files that could not be written, and what rules have not.
fn can_be_done(command: &Identify, by_rules: bool) -> Result<(), Error> {
    within("--check", command.check, |v| (0.0..=0.9).contains(&v), "give a share from 0 to 0.9")?;
    command.save.as_deref().map_or(Ok(()), can_write)?;
    let tables =
        [("--table", &command.table), ("--configurations", &command.configurations), ("--parts", &command.parts)];
    for (flag, path) in tables {
        let Some(path) = path else { continue };
        writable_table(path)?;
        if by_rules {
            let message = format!("{flag}: rules are no list of parameters");
            return Err(Error::input(message, "write them with --save-rules"));
        }
    }
    let compared = [("--since", command.since.is_some()), ("--against", command.against.is_some())];
    match compared.into_iter().find(|(_, is_given)| by_rules && *is_given) {
        Some((flag, _)) => {
            Err(Error::input(format!("{flag}, and rules are identified"), "leave --what out: parameters are compared"))
        }
        None => Ok(()),
    }
}

/// What to do where another set of parameters cannot be compared.
const OTHER_REMEDY: &str =
    "give a description of the same robot: the same variables, and the markers that the campaign reads";

/// A campaign as another description reads it.
#[derive(Debug)]
pub(super) struct Other {
    /// Name of the description.
    pub name: String,
    /// The campaign.
    pub loaded: LoadedCampaign,
}

/// The campaign as another description reads it.
///
/// # Errors
/// What the description lacks of what the campaign reads.
pub(super) fn other(name: &str, campaign: &str, ours: &LoadedCampaign, session: &Session) -> Result<Other, Error> {
    let refuse = |what: String| Err(Error::input(format!("--against {name}: {what}"), OTHER_REMEDY));
    let (model, theirs) = (&ours.robot.model, session.reader.robot(name)?.model);
    let variables = |model: &Model| model.variables.iter().map(|own| own.name.clone()).collect::<Vec<_>>().join(", ");
    if variables(&theirs) != variables(model) {
        let (theirs, ours) = (variables(&theirs), variables(model));
        return refuse(format!("its variables are {theirs}, those of the campaign's robot {ours}"));
    }
    let read = ours.campaign.readings.iter().filter_map(|reading| Some(&model.markers[reading.marker?].name));
    // What is read of a body goes by the body's name.
    let is_lacking = |marker: &String| theirs.marker(marker).is_none() && theirs.frame(marker).is_none();
    if let Some(marker) = read.into_iter().find(|marker| is_lacking(marker)) {
        return refuse(format!("it has no marker `{marker}`, which the campaign reads"));
    }
    Ok(Other { name: name.into(), loaded: session.reader.campaign(campaign, Some(name))? })
}

/// A calibration compared with another set of parameters.
///
/// # Errors
/// Another robot, or readings that it cannot predict.
pub(super) fn compared(
    other: &Other,
    model: &Model,
    campaign: &Campaign,
    found: &Calibration,
    settings: &Settings,
) -> Result<Option<AgainstOther>, Error> {
    let Other { name, loaded } = other;
    let set = OtherSet { raw: &loaded.robot.raw, model: &loaded.robot.model, campaign: &loaded.campaign };
    let compared = against(model, campaign, found, settings, &set)
        .map_err(|error| Error::input(format!("--against {name}: {error}"), OTHER_REMEDY))?;
    Ok(AgainstOther::new(name, model, campaign, found, &compared))
}

/// What a calibration is asked for in addition to its result.
#[derive(Debug, Default)]
pub(super) struct Asked<'a> {
    /// Name of the description, an earlier one: what has moved since.
    pub since: Option<&'a str>,
    /// Another set of parameters.
    pub against: Option<&'a Other>,
    /// File of the calibrated description.
    pub save: Option<&'a Path>,
    /// File of the parameters as a table.
    pub table: Option<&'a Path>,
    /// File of the errors of the configurations held out, as a table.
    pub configurations: Option<&'a Path>,
    /// File of the figures of the parts of the readings, as a table.
    pub parts: Option<&'a Path>,
}

/// A campaign (with the marks of its readings held out) calibrated.
pub(super) fn calibrated(
    session: &Session,
    loaded: &LoadedCampaign,
    campaign: &Campaign,
    held_out: &[bool],
    settings: &Settings,
    asked: &Asked,
) -> Result<Output, Error> {
    let (raw, model) = (&loaded.robot.raw, &loaded.robot.model);
    let started = Instant::now();
    let bar = session.terminal.bar(None, "{spinner} iteration {pos}  {msg}");
    let found = calibrate(model, campaign, held_out, settings, &mut |progress| {
        bar.set_position(progress.iteration as u64);
        bar.set_message(format!("cost {:.6e}", progress.cost));
    });
    drop(bar);
    let found = match found {
        Ok(found) => found,
        Err(error) => return Err(not_computed(error.into(), model, campaign, session)),
    };
    let loaded_joints = with_holding_loads(model, campaign, &found.values)?;
    let campaign = &*loaded_joints;
    let mut saved = with_uncertainties(&with_values(raw, model, &found.values), model, &found);
    let range = RawValidity::of(campaign, &model.variable_names());
    saved.validity = Some(range);
    let mut judged = judge(&Evidence::with(model, campaign, &found), &Limits::default());
    // What registration leaves is the robot's own error.
    let is_registration = settings.only == Some(Vec::new());
    judged.retain(|diagnostic| !is_above_noise(diagnostic) || !is_registration);
    judged.extend(unusable(
        &saved,
        session,
        &Expected { campaign, residual: Some(&found.residual), fitted: (model, &found.values) },
    )?);
    if session.arguments.force {
        judged = forced(judged);
    }
    let mut result = Identification::new(model, campaign, &found, started.elapsed().as_secs_f64());
    result.refusals = judged.iter().filter(|diagnostic| diagnostic.is_error()).cloned().collect();
    result.conventions = CombinedParameters::all(&loaded.robot.robot.calibration.combinations, model, &found);
    result.since =
        asked.since.map(|name| Since::new(name, model, &changes(raw, model, &found), &not_stated(raw, model, &found)));
    if let Some(other) = asked.against {
        result.against = compared(other, model, campaign, &found, settings)?;
    }
    let mut output = Output::new(render::identification(&result, session.terminal.screen), &result)?;
    output.diagnostics.clone_from(&loaded.diagnostics);
    output.diagnostics.extend(loaded.outside());
    output.diagnostics.extend(result.since.as_ref().and_then(certain));
    output.diagnostics.extend(nothing_elastic(model, settings));
    output.diagnostics.extend(not_declared(model, campaign, &found).filter(|_| !is_registration));
    output.diagnostics.extend(not_asked(model, campaign, &found).filter(|_| settings.what.is_none()));
    let mut output = output.judged(judged, session.arguments.force)?;
    write_tables(&mut output, &result, asked)?;
    if let Some(path) = asked.save {
        // A robust loss is there for readings that are far off.
        let is_robust = settings.loss != Loss::Squares;
        let is_borne = |of: &Diagnostic| of.code == Code::OutlyingReadings && is_robust;
        let doubt = output.doubt_in_values(session.arguments.force, is_borne);
        save(&mut output, path, doubt, &saved, unwritten(model, campaign, &found.values, path))?;
    }
    Ok(output)
}

/// Writes the calibrated description, where it is to be used and no doubt forbids it.
fn save(
    output: &mut Output,
    path: &Path,
    doubt: Option<Code>,
    saved: &RawRobot,
    unwritten: Vec<Diagnostic>,
) -> Result<(), Error> {
    if output.failed || doubt.is_some() {
        output.not_written(path, doubt);
        return Ok(());
    }
    let (text, diagnostics) = written(saved, path)?;
    output.diagnostics.extend(diagnostics.into_iter().chain(unwritten));
    output.file("calibrated description", path, text);
    Ok(())
}

/// The tables asked for of a calibration: its parameters, its configurations held out.
fn write_tables(output: &mut Output, result: &Identification, asked: &Asked) -> Result<(), Error> {
    if let Some(path) = asked.table {
        output.table("parameters", path, tables::parameters(result, path)?);
    }
    if let Some(path) = asked.configurations {
        if result.configurations.is_empty() {
            let message = "--configurations: no configuration with positions is held out";
            return Err(Error::input(message, "hold some out with --check, or mark them `check` in the column `set`"));
        }
        let table = tables::configurations(&result.configurations, path)?;
        output.table("observed and predicted error of configurations", path, table);
    }
    if let Some(path) = asked.parts {
        output.table("residuals by session, file and marker", path, tables::parts(&result.parts, path)?);
    }
    Ok(())
}

/// Warnings of what a description does not hold: bases, tools and markers that are a session's or station's, of which it has one of each;
/// gains and offsets of sensors of torques.
fn unwritten(model: &Model, campaign: &Campaign, values: &[f64], path: &Path) -> Vec<Diagnostic> {
    let reported = |why: &str, what: Vec<String>, remedy: &str| {
        let text = format!("`{}` holds {why}: {}", path.display(), what.join(", "));
        (!what.is_empty()).then(|| Diagnostic::warning(text).remedy(remedy))
    };
    let arranged = reported(
        "one base and one of each marker, and those of the campaign's sessions are not written to it",
        of_sessions(model, values),
        "find them again with `register` and the campaign; `identify --table` or `--format json` holds them",
    );
    let prefixes: Vec<_> = campaign.readings.iter().filter_map(|reading| reading.observes.by_variable()).collect();
    let sensors = campaign.targets.iter().filter(|target| prefixes.contains(&target.column));
    let unknown = sensors.flat_map(|target| &target.values).filter_map(|value| value.parameter.as_deref());
    let shown = unknown.filter_map(|name| Some(format!("{name} = {:.5e}", values.get(model.registry.slot(name)?)?)));
    let of_sensors = reported(
        "no sensors of torques, and what was found of them is not written to it",
        shown.collect(),
        "write them under `torques:` of the campaign, in its units, where they are to be used again",
    );
    arranged.into_iter().chain(of_sensors).collect()
}

/// Why a calibration of a campaign could not be computed: what is wrong with its readings, where that is known.
pub(super) fn not_computed(error: Error, model: &Model, campaign: &Campaign, session: &Session) -> Error {
    // No reading is the reason where nothing was asked for.
    if matches!(error, Error::Calibration(CalibrationError::NothingElastic | CalibrationError::NothingFree)) {
        return error;
    }
    let evidence = Evidence::of(model, campaign);
    let why = why_not_computed(&error.explained(), &evidence, &Limits::default(), session.arguments.force);
    why.map_or(error, Error::from)
}

/// A warning of an earlier description that does not say how certain its values are.
pub(super) fn certain(since: &Since) -> Option<Diagnostic> {
    let without = since.parameters.iter().filter(|parameter| !parameter.both).count();
    (without > 0).then(|| {
        let text = format!(
            "`{}` states no uncertainty of {without} of the {} parameters compared: their earlier values count as exact",
            since.description,
            since.parameters.len()
        );
        Diagnostic::warning(text).remedy("compare with a description that `identify --save` wrote")
    })
}

/// A warning of compliances that `calibrate:` names and of which the description declares none to be identified.
fn not_declared(model: &Model, campaign: &Campaign, found: &Calibration) -> Option<Diagnostic> {
    let is_missing = |name: &&String| {
        let Some(effect) = model.catalogue.get(name) else { return false };
        let (sites, nonlinear) = (effect.sites(model), Nonlinear::default());
        let is_fitted =
            |site: &Site| effect.constants(model, site, &nonlinear).iter().any(|slot| found.slots.contains(slot));
        effect.family(&nonlinear) == Family::Elastic && !effect.is_free_form() && !sites.iter().any(is_fitted)
    };
    let missing: Vec<String> = campaign.calibrate.iter().filter(is_missing).map(|name| format!("`{name}`")).collect();
    (!missing.is_empty()).then(|| {
        let text = format!(
            "`calibrate:` names {}, and the description declares nothing of it to be identified: it is not fitted here",
            missing.join(", ")
        );
        Diagnostic::warning(text)
            .remedy("write the springs with `identifiable: true` into the description; `diagnose` fits it without")
    })
}

/// A warning that `--what` asks for springs where the description declares none to be identified.
fn nothing_elastic(model: &Model, settings: &Settings) -> Option<Diagnostic> {
    let is_asked = settings.what.is_some_and(|what| what.elastic);
    (is_asked && model.elastic_slots().is_empty()).then(|| {
        Diagnostic::warning(
            "`--what` asks for springs, and the description declares none to be identified: none is fitted",
        )
        .remedy("write the springs with `identifiable: true` into the description")
    })
}

/// A warning of constants that are fitted although `calibrate:` does not name them.
fn not_asked(model: &Model, campaign: &Campaign, found: &Calibration) -> Option<Diagnostic> {
    let is_constant = |slot: &Slot| model.registry[*slot].group == Group::Geometry;
    let count = found.kept_slots().into_iter().filter(is_constant).count();
    let is_named = campaign.calibrate.is_empty() || campaign.calibrate.iter().any(|name| name == "geometry");
    (count > 0 && !is_named).then(|| {
        let names: Vec<String> = campaign.calibrate.iter().map(|name| format!("`{name}`")).collect();
        let text = format!(
            "`calibrate:` names {} alone, and {count} constants of the geometry are fitted here: `diagnose` heeds it",
            names.join(", ")
        );
        Diagnostic::warning(text).remedy("say what is to be fitted (`--what`, `--hold`), or add `geometry` to it")
    })
}

/// What the flags ask of the fit, but for the reduction.
fn settings(command: &Identify, what: Option<What>) -> Settings {
    Settings {
        what,
        split: command.split,
        logarithms: command.logarithms,
        scheme: command.scheme,
        weights: command.weights,
        prior: command.prior,
        hold: command.reduction.hold.clone(),
        ..Settings::default()
    }
}

/// The loss that the flags ask for.
pub(super) fn loss(robust: &Robust) -> Result<Loss, Error> {
    let [huber, cauchy, tukey] = USUAL_SCALES.map(|usual| robust.loss_scale.unwrap_or(usual));
    let loss = match robust.loss {
        None | Some(LossName::Squares) => Loss::Squares,
        Some(LossName::Huber) => Loss::Huber(huber),
        Some(LossName::Cauchy) => Loss::Cauchy(cauchy),
        Some(LossName::Tukey) => Loss::Tukey(tukey),
    };
    match loss_fault(loss) {
        Some(fault) => {
            Err(Error::input(format!("--loss-scale: {fault}"), "leave it out, or give a few standard deviations"))
        }
        None => Ok(loss),
    }
}

/// Scales of the losses where none is given: 95 % efficient on normal noise.
const USUAL_SCALES: [f64; 3] = [HUBER, 2.385, TUKEY];

/// Refuses a campaign of which all readings, or all that are loaded, are held out to check.
pub fn left_to_fit(campaign: &Campaign, held_out: &[bool]) -> Result<(), Error> {
    let mut fitted = campaign
        .readings
        .iter()
        .zip(held_out)
        .filter(|(_, held_out)| !**held_out)
        .map(|(reading, _)| reading)
        .peekable();
    if fitted.peek().is_none() {
        return Err(Error::input(
            "no reading is left to fit: all are held out to check",
            "mark readings to fit with `fit` in the column `set`",
        ));
    }
    if campaign.is_difference() && fitted.all(|reading| !reading.is_loaded()) {
        return Err(Error::input(
            format!("no reading to fit is loaded, and {}s are observed", campaign.observes.name()),
            "mark loaded readings with `fit` in the column `set`",
        ));
    }
    let is_place = |index: usize| !campaign.readings[index].observes.is_difference();
    let mut places = (0..campaign.readings.len()).filter(|&index| is_place(index)).peekable();
    if places.peek().is_some() && places.all(|index| held_out.get(index) == Some(&true)) {
        return Err(Error::input(
            "no place is left to fit: all readings but deflections are held out to check",
            "mark some of them with `fit` in the column `set`, or leave them out",
        ));
    }
    match unfitted(campaign, held_out) {
        None => Ok(()),
        Some((noun, name)) => Err(Error::input(
            format!(
                "{noun} `{name}` has readings to check alone: nothing determines the base or tool of its own that is estimated"
            ),
            format!(
                "mark some of its readings `fit` in the column `set`, or let it share base and tool of another {noun}"
            ),
        )),
    }
}

/// A session or station with a base, a tool or a scale of its own of which no reading is fitted: what it is called, and its name.
fn unfitted(campaign: &Campaign, held_out: &[bool]) -> Option<(&'static str, String)> {
    let sessions = &campaign.sessions;
    let nouns = [(Sharing::PerSession, "session"), (Sharing::PerStation, "station")];
    let own = nouns.into_iter().filter(|(by, _)| [sessions.base, sessions.tool, sessions.scale].contains(by));
    own.flat_map(|(by, noun)| sessions.parts(by).into_iter().enumerate().map(move |part| (by, noun, part))).find_map(
        |(by, noun, (part, name))| {
            let of_part = || campaign.readings.iter().zip(held_out).filter(|(of, _)| of.session.part(by) == part);
            let is_checked_alone = of_part().next().is_some() && of_part().all(|(_, held_out)| *held_out);
            is_checked_alone.then(|| (noun, name.to_owned()))
        },
    )
}

/// Why a campaign of angles or torques alone is not diagnosed.
pub const NO_LENGTHS: &str = "the readings hold no lengths, in which a diagnosis compares effects";

/// Refuses a campaign of angles or torques alone, in which effects are not compared.
pub fn has_lengths(campaign: &Campaign) -> Result<(), Error> {
    let remedy = "`identify` fits angles or torques alone and shows what is left of them, and `report` writes a page of it; a diagnosis needs \
                  positions, poses, distances, contacts or deflections with them";
    if campaign.holds_lengths() { Ok(()) } else { Err(Error::input(NO_LENGTHS, remedy)) }
}

/// Only `count` of the configurations that would be fitted, drawn with the seed, and all those to check.
fn fewer(campaign: &Campaign, count: usize, share: f64, seed: u64) -> Result<Campaign, Error> {
    use rand::seq::SliceRandom;
    let held_out = split(campaign, share, seed);
    let fitted = campaign.readings.iter().zip(&held_out).filter(|(_, held_out)| !**held_out);
    let mut poses = distinct(fitted.map(|(reading, _)| reading.pose));
    if count > poses.len() {
        let message = format!("--train `{count}`, and {} configurations are there to fit", poses.len());
        return Err(Error::input(message, "give at most as many, or leave it out"));
    }
    poses.shuffle(&mut crate::simulation::generator(seed));
    poses.truncate(count);
    let mut drawn = campaign.select(|i, reading| held_out[i] || poses.contains(&reading.pose));
    let check: Vec<bool> = campaign
        .readings
        .iter()
        .zip(&held_out)
        .filter(|(reading, held_out)| **held_out || poses.contains(&reading.pose))
        .map(|(_, held_out)| *held_out)
        .collect();
    for (reading, check) in drawn.readings.iter_mut().zip(check) {
        reading.check = Some(check);
    }
    Ok(drawn)
}
