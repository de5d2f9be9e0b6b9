//! `simulate`: a campaign with known truth.

mod campaign;
mod process;

pub(super) use campaign::csv;
use campaign::{Made, delivered};

use indexmap::IndexMap;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use serde_json::Value;

use super::pose::loaded_configurations;
use crate::Error;
use crate::blind::seal as digest;
use crate::cli::args::Simulate;
use crate::cli::output::Output;
use crate::cli::session::Session;
use crate::cli::values::{known_parameters, ranges, wrench};
use crate::description::campaign::{Campaign, InSession, Sessions, Sharing};
use crate::description::raw::{RawAmount, RawEffect};
use crate::diagnostic::{Diagnostic, Severity};
use crate::effects::EffectEntry;
use crate::files::{LoadedRobot, settle};
use crate::kinematics::Geometry;
use crate::model::Model;
use crate::observation::Observes;
use crate::parameter::{Kind, Parameter};
use crate::simulation::{Plan, carry_out, draw_configurations_in, draw_errors, generator, joint_box, unmeasured};

pub fn run(command: &Simulate, session: &Session) -> Result<Output, Error> {
    let seed = session.seed();
    check(command)?;
    spares_readings(&command.into, session.arguments.force)?;
    let mut loaded = session.reader.robot(&command.robot)?;
    for text in &command.effect {
        let entry = effect(&loaded.model, text)?;
        loaded.model.switch_on(entry);
    }
    let mut diagnostics = Vec::new();
    let model = &loaded.model;
    let mut random = generator(seed);
    let mut values = draw_errors(model, command.errors, command.elastic_errors, &mut random);
    set_errors(&loaded, &command.set, &mut values)?;
    let markers = markers(&loaded, &command.markers)?;
    if command.sessions.is_empty() {
        set_up(command, model, &markers, InSession::default(), &mut values, &mut random);
    }
    let geometry = Geometry::new(model, &values)?;
    if let Some(file) = &command.process {
        let scene = process::Scene { command, loaded: &loaded, values: &values, markers: &markers };
        return process::run(&scene, file, session, &mut random);
    }
    let (configurations, row_loads, warnings) = configurations(command, session, &loaded, &geometry, &mut random)?;
    diagnostics.extend(warnings);
    let observes = observed(model, command.observes)?;
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
        estimate: [command.unknown_base, command.unknown_tool],
    };
    let mut blank = unmeasured(model, &plan);
    if !row_loads.is_empty() {
        blank = blank.select(|_, reading| reading.wrench == row_loads[reading.pose]);
        blank.readings.iter_mut().enumerate().for_each(|(k, reading)| reading.row = k + 1);
    }
    if !command.sessions.is_empty() {
        share_out(command, &mut blank)?;
        loaded.model = loaded.model.arranged(&blank);
        values.extend_from_slice(&loaded.model.registry.nominal()[values.len()..]);
        for session in 0..command.sessions.len() {
            let of = InSession { session, station: 0 };
            set_up(command, &loaded.model, &plan.markers, of, &mut values, &mut random);
        }
    }
    let campaign = carry_out(&loaded.model, &values, &plan, blank, &mut random)?;
    let mut output =
        delivered(&Made { command, loaded: &loaded, values: &values, plan: &plan, seed }, campaign, None, &mut random)?;
    output.diagnostics.extend(diagnostics);
    Ok(output)
}

/// Puts base and markers somewhere, as far as they are unknown.
fn set_up(
    command: &Simulate,
    model: &Model,
    markers: &[Option<usize>],
    of: InSession,
    values: &mut [f64],
    random: &mut ChaCha8Rng,
) {
    if command.unknown_base {
        for (k, size) in [0.5, 0.5, 0.5, 0.3, 0.3, 0.3].into_iter().enumerate() {
            values[model.base_slot(of) + k] += size * (2.0 * random.random::<f64>() - 1.0);
        }
    }
    if command.unknown_tool {
        let points = markers.iter().map(|marker| model.point_slot(*marker, of));
        for slot in points.flat_map(|slot| slot..slot + 3) {
            let draw: f64 = StandardNormal.sample(random);
            values[slot] += 2e-3 * draw;
        }
    }
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

/// Configurations, with loads of the rows where they come from a file that has loads, and warnings.
type Configurations = (Vec<Vec<f64>>, Vec<[f64; 6]>, Vec<Diagnostic>);

fn configurations(
    command: &Simulate,
    session: &Session,
    loaded: &LoadedRobot,
    geometry: &Geometry,
    random: &mut ChaCha8Rng,
) -> Result<Configurations, Error> {
    match command.poses.parse::<usize>() {
        Ok(0) => Err(Error::input("--poses 0", "give at least one configuration")),
        Ok(count) if count > 100_000 => Err(Error::input(format!("--poses {count}"), "at most 100000 configurations")),
        Ok(count) => {
            let (within, warnings) =
                ranges("--range", loaded, joint_box(&loaded.model, command.share), &command.range)?;
            Ok((draw_configurations_in(geometry, &within, count, random)?, Vec::new(), warnings))
        }
        Err(_) if !command.range.is_empty() => {
            Err(Error::input("--range and a file of configurations", "leave --range out, or give --poses a number"))
        }
        Err(_) => {
            let (rows, warnings) = loaded_configurations(session, loaded, std::path::Path::new(&command.poses))?;
            let (configurations, loads): (Vec<_>, Vec<_>) = rows.into_iter().unzip();
            let is_loaded = loads.iter().any(|load| *load != [0.0; 6]);
            Ok((configurations, if is_loaded { loads } else { Vec::new() }, warnings))
        }
    }
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
    for name in ["campaign.yaml", "measurements.csv"] {
        let Ok(now) = std::fs::read(folder.join(name)) else { continue };
        let Some(truth) = &truth else {
            let message = format!("--into: `{shown}` has a {name} that `simulate` did not write");
            return Err(Error::input(message, "give another folder"));
        };
        let written = truth.get(campaign::DIGESTS).and_then(|digests| digests.get(name)).and_then(Value::as_str);
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

/// `EFFECT@SITE:parameter=value,...`, SI.
fn effect(model: &Model, text: &str) -> Result<EffectEntry, Error> {
    let refused = |diagnostic: Diagnostic| {
        let message = format!("--effect `{text}`: {}", diagnostic.message);
        Error::from(Diagnostic { message, severity: Severity::Error, ..diagnostic })
    };
    let (name, rest) = text.split_once('@').unwrap_or((text, ""));
    // A site may hold a colon of its own: what follows the last one with `=` in it are parameters.
    let (site, stated) = match rest.rsplit_once(':') {
        Some((site, stated)) if stated.contains('=') => (site, stated),
        _ => (rest, ""),
    };
    let mut parameters = IndexMap::new();
    for entry in stated.split(',').filter(|entry| !entry.trim().is_empty()) {
        let Some((key, value)) = entry.split_once('=') else {
            return Err(Error::input(format!("--effect `{text}`: `{entry}`"), "write parameter=value, SI"));
        };
        let value = value.trim();
        let value = value.parse::<f64>().map_or_else(|_| value.into(), RawAmount::from);
        parameters.insert(key.trim().to_string(), value);
    }
    let raw =
        RawEffect { effect: Some(name.trim().into()), site: Some(site.into()), parameters, ..RawEffect::default() };
    let entry = model.resolve_effect(&raw).map_err(|fault| refused(fault.diagnostic))?;
    match entry.doubt(model) {
        Some(doubt) if entry.amounts.is_empty() => Err(refused(doubt)),
        _ => Ok(entry),
    }
}

fn set_errors(loaded: &LoadedRobot, set: &[String], values: &mut [f64]) -> Result<(), Error> {
    let model = &loaded.model;
    for entry in set {
        let Some((name, value)) = entry.split_once('=') else {
            return Err(Error::input(format!("--set `{entry}`"), "write name=value"));
        };
        known_parameters(model, [name.trim()])?;
        let Some(slot) = model.registry.slot(name.trim()) else { continue };
        let parameter = &model.registry[slot];
        let factor = loaded.raw.units.of(parameter.shown_kind());
        match value.trim().parse::<f64>() {
            // A stiffness without end is a compliance of zero.
            Ok(value) if value == f64::INFINITY && parameter.inverted => values[slot] = 0.0,
            Ok(value) if value.abs() * factor <= crate::description::resolve::GREATEST => {
                let changed = parameter.shown(parameter.nominal) + value * factor;
                stays_possible(entry, parameter, changed, factor)?;
                // Shown and held are each other's inverse, or the same.
                values[slot] = parameter.shown(changed);
            }
            _ => {
                return Err(Error::input(
                    format!("--set `{entry}`: `{value}` is no finite number"),
                    "write name=value",
                ));
            }
        }
    }
    Ok(())
}

/// Refuses a change after which a stiffness or the like would be negative; `changed` as it is shown, SI.
fn stays_possible(entry: &str, parameter: &Parameter, changed: f64, factor: f64) -> Result<(), Error> {
    let declared = parameter.shown(parameter.nominal);
    // What is left of a value and its inverse is nothing.
    let changed = if changed.abs() < 1e-9 * declared.abs() { 0.0 } else { changed };
    let must = match parameter.shown_kind() {
        Kind::LinearStiffness | Kind::RotationalStiffness | Kind::Pressure if changed <= 0.0 => "be above 0",
        Kind::LinearCompliance | Kind::RotationalCompliance | Kind::Mass if changed < 0.0 => "not be below 0",
        _ => return Ok(()),
    };
    let name = &parameter.name;
    let [changed, declared] = [changed, declared].map(|v| format!("{:.6e}", v / factor).parse().unwrap_or(v / factor));
    Err(Error::input(
        format!("--set `{entry}` makes `{name}` {changed}, and it must {must}"),
        format!("--set adds to what the description says, {declared}"),
    ))
}

pub(super) fn markers(loaded: &LoadedRobot, names: &[String]) -> Result<Vec<Option<usize>>, Error> {
    if names.is_empty() {
        return Ok(vec![None]);
    }
    let mut markers = Vec::new();
    for name in names {
        match loaded.model.marker(name) {
            Some(marker) => markers.push(Some(marker)),
            None => {
                let valid = loaded.model.markers.iter().map(|marker| marker.name.as_str());
                return Err(Error::from(vec![
                    Diagnostic::error(format!("unknown marker `{name}`")).suggest(name, valid),
                ]));
            }
        }
    }
    Ok(markers)
}
