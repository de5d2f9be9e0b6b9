//! `simulate`: a campaign with known truth.

mod campaign;
mod designed;
mod drawn;
mod errors;
mod process;

pub(super) use campaign::csv;
use campaign::{Made, delivered};
use drawn::configurations;
use errors::{effect, set_errors};

use rand_chacha::ChaCha8Rng;
use serde_json::Value;

use crate::Error;
use crate::blind::seal as digest;
use crate::cli::args::Simulate;
use crate::cli::boxes::keep_out;
use crate::cli::output::Output;
use crate::cli::session::Session;
use crate::cli::values::{markers, wrench};
use crate::description::campaign::{Campaign, InSession, Sessions, Sharing};
use crate::files::{LoadedRobot, settle};
use crate::kinematics::Geometry;
use crate::model::Model;
use crate::model::all_springs;
use crate::observation::{Observes, POSITION};
use crate::simulation::{Plan, carry_out, draw_errors, generator, set_up, unmeasured};

pub fn run(command: &Simulate, session: &Session) -> Result<Output, Error> {
    let seed = session.seed();
    check(command)?;
    spares_readings(&command.into, session.arguments.force)?;
    if session.reader.is_campaign(&command.robot) {
        return designed::run(command, session);
    }
    let mut loaded = robot(command, session)?;
    let mut diagnostics = Vec::new();
    let model = &loaded.model;
    let mut random = generator(seed);
    let mut values = draw_errors(model, command.errors, command.elastic_errors, &mut random);
    set_errors(&loaded, &command.set, &mut values)?;
    let markers = markers(&loaded.model, &command.markers)?;
    let unknown = [command.unknown_base, command.unknown_tool];
    if command.sessions.is_empty() {
        set_up(model, &markers, InSession::default(), unknown, &mut values, &mut random);
    }
    let geometry = Geometry::new(model, &values)?;
    if let Some(file) = &command.process {
        let scene = process::Scene { command, loaded: &loaded, values: &values, markers: &markers };
        return process::run(&scene, file, session, &mut random);
    }
    let (configurations, row_loads, warnings) = configurations(command, session, &loaded, &geometry, &mut random)?;
    diagnostics.extend(warnings);
    let observes = observed(model, command.observes.unwrap_or(POSITION))?;
    let wrenches = wrenches(command, &loaded, &row_loads)?;
    if observes.is_difference() && wrenches.is_empty() {
        return Err(Error::input(
            format!("--observes {}: nothing loads the robot", observes.name()),
            "give --wrench FX,FY,FZ,MX,MY,MZ",
        ));
    }
    let plan = Plan {
        wrenches,
        conditions: command.conditions || !model.effects.is_empty(),
        configurations,
        markers,
        repeats: command.repeats,
        observes,
        sigma: command.noise * 1e-3,
        sigma_orientation: command.orientation_noise.to_radians(),
        estimate: unknown,
    };
    let mut blank = blank(command, model, &plan, &row_loads);
    if !command.sessions.is_empty() {
        in_sessions(command, &plan, &mut blank, &mut loaded.model, &mut values, &mut random)?;
    }
    let campaign = carry_out(&loaded.model, &values, &plan, blank, &mut random)?;
    let mut output =
        delivered(&Made { command, loaded: &loaded, values: &values, plan: &plan, seed }, campaign, None, &mut random)?;
    output.diagnostics.extend(diagnostics);
    Ok(output)
}

/// The readings to come; where the rows of a file have loads (N, N.m), each under its own.
fn blank(command: &Simulate, model: &Model, plan: &Plan, row_loads: &[[f64; 6]]) -> Campaign {
    let mut blank = unmeasured(model, plan);
    if plan.observes.is_difference() && command.elastic_errors != 0.0 {
        blank.calibrate = all_springs(model, &blank);
    }
    if !row_loads.is_empty() {
        blank = blank.select(|_, reading| reading.wrench == row_loads[reading.pose]);
        blank.readings.iter_mut().enumerate().for_each(|(k, reading)| reading.row = k + 1);
    }
    blank
}

/// The robot with the effects asked for and with what it must not touch.
fn robot(command: &Simulate, session: &Session) -> Result<LoadedRobot, Error> {
    if command.placements != 1 {
        return Err(Error::input(
            format!("--placements, and `{}` is no campaign", command.robot),
            "give a campaign file with `contacts:` of a `group:`",
        ));
    }
    let mut loaded = session.reader.robot(&command.robot)?;
    for text in &command.effect {
        let entry = effect(&loaded.model, text)?;
        loaded.model.switch_on(entry);
    }
    keep_out(&command.keep_out, &mut loaded)?;
    Ok(loaded)
}

/// Sets each session up for itself, and shares the configurations out to them.
fn in_sessions(
    command: &Simulate,
    plan: &Plan,
    campaign: &mut Campaign,
    model: &mut Model,
    values: &mut Vec<f64>,
    random: &mut ChaCha8Rng,
) -> Result<(), Error> {
    share_out(command, campaign)?;
    *model = model.arranged(campaign);
    values.extend_from_slice(&model.registry.nominal()[values.len()..]);
    for session in 0..command.sessions.len() {
        set_up(model, &plan.markers, InSession { session, station: 0 }, plan.estimate, values, random);
    }
    Ok(())
}

/// Shares the configurations out to the sessions, in order.
fn share_out(command: &Simulate, campaign: &mut Campaign) -> Result<(), Error> {
    let (names, poses) = (&command.sessions, campaign.poses.len());
    let is_name =
        |name: &String| !name.is_empty() && name.chars().all(|c| c.is_ascii_alphanumeric() || matches!(c, '_' | '-'));
    let is_twice = names.iter().enumerate().any(|(k, name)| names[..k].contains(name));
    if is_twice || !names.iter().all(is_name) || names.len() > poses {
        return Err(Error::input(
            format!("--sessions {}", names.join(",")),
            "give different names of letters, digits, `_` and `-`, no more than configurations",
        ));
    }
    let sharing = |is_unknown: bool| if is_unknown { Sharing::PerSession } else { Sharing::All };
    campaign.sessions = Sessions {
        names: names.clone(),
        base: sharing(command.unknown_base),
        tool: sharing(command.unknown_tool),
        ..Sessions::default()
    };
    for reading in &mut campaign.readings {
        reading.session.session = reading.pose * names.len() / poses;
    }
    Ok(())
}

fn check(command: &Simulate) -> Result<(), Error> {
    let finite = [command.noise, command.orientation_noise, command.errors, command.elastic_errors];
    if finite.iter().any(|v| !(0.0..=1e6).contains(v))
        || !(0.0..=1.0).contains(&command.share)
        || !(0.0..=0.9).contains(&command.check)
        || !(1..=1000).contains(&command.repeats)
    {
        return Err(Error::input(
            "a number is out of range",
            "--noise, --orientation-noise and --errors are from 0 to 1e6, --share from 0 to 1, --check from 0 to 0.9, --repeats from 1 to 1000",
        ));
    }
    Ok(())
}

/// The loads of all readings: as asked, or as the rows of the file have them.
fn wrenches(command: &Simulate, loaded: &LoadedRobot, row_loads: &[[f64; 6]]) -> Result<Vec<[f64; 6]>, Error> {
    let asked = command.wrench.iter().map(|text| wrench(&loaded.raw.units, text));
    let asked = asked.collect::<Result<Vec<[f64; 6]>, Error>>()?;
    if row_loads.is_empty() {
        return Ok(asked);
    }
    if !asked.is_empty() {
        return Err(Error::input(
            format!("`{}` has loads of its own", command.poses),
            "leave --wrench out, or the columns fx, .., mz",
        ));
    }
    let mut wrenches = row_loads.to_vec();
    wrenches.sort_by(|a, b| a.partial_cmp(b).unwrap_or(std::cmp::Ordering::Equal));
    wrenches.dedup();
    Ok(wrenches)
}

/// Refuses a folder with readings that were not simulated, or that were edited since (unless `force`).
fn spares_readings(folder: &std::path::Path, force: bool) -> Result<(), Error> {
    settle(folder)?;
    let truth = std::fs::read_to_string(folder.join("truth.json")).ok();
    let truth = truth.and_then(|text| serde_json::from_str::<Value>(&text).ok());
    let truth = truth.filter(|truth| truth.get("seed").is_some() && truth.get("parameters").is_some());
    let shown = folder.display();
    let digests = || truth.as_ref().and_then(|truth| truth.get(campaign::DIGESTS)).and_then(Value::as_object);
    let further = digests().into_iter().flat_map(|digests| digests.keys().map(String::as_str));
    let names: std::collections::BTreeSet<&str> =
        ["campaign.yaml", "measurements.csv"].into_iter().chain(further).collect();
    for name in names {
        let Ok(now) = std::fs::read(folder.join(name)) else { continue };
        if truth.is_none() {
            let message = format!("--into: `{shown}` has a {name} that `simulate` did not write");
            return Err(Error::input(message, "give another folder"));
        }
        let written = digests().and_then(|digests| digests.get(name)).and_then(Value::as_str);
        let is_edited = written.is_some_and(|written| written != digest(&String::from_utf8_lossy(&now)));
        if is_edited && !force {
            let message = format!("--into: {name} in `{shown}` was edited since `simulate` wrote it");
            return Err(Error::input(message, "give another folder, or replace it with --force"));
        }
    }
    Ok(())
}

/// Refuses a kind of readings that needs anchors where the description has none.
pub(super) fn observed(model: &Model, observes: Observes) -> Result<Observes, Error> {
    if observes.target_column().is_some() && model.anchors.is_empty() {
        return Err(Error::input(
            format!("--observes {}: the description has no anchors", observes.name()),
            "add `anchors: {name: [x, y, z]}` to the description",
        ));
    }
    Ok(observes)
}
