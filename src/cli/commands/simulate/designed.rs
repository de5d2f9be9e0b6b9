//! `simulate CAMPAIGN`: the readings that a campaign file asks for, with known truth.

use nalgebra::Vector3;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use super::campaign::{Simulated, as_seen_from, source, with_sets, written};
use super::drawn::{Configurations, configurations as drawn};
use super::errors::{effect, set_errors};
use crate::Error;
use crate::cli::args::Simulate;
use crate::cli::boxes::keep_out;
use crate::cli::commands::designed::{Cells, Wanted, blank, given, plain};
use crate::cli::output::Output;
use crate::cli::session::Session;
use crate::cli::values::wrench;
use crate::description::campaign::raw::{LoadSource, RawCampaign, RawEntry, RawInstrument, RawSigma};
use crate::description::campaign::{Campaign, InSession, Reading, Sharing, csv_in, kinds};
use crate::description::units::Units;
use crate::files::Design;
use crate::kinematics::{Geometry, Placements};
use crate::math::distinct;
use crate::model::Model;
use crate::observation::{Kinds, Noise, SOCKET};
use crate::prediction::{Toucher, target_values};
use crate::simulation::{
    conditions, direction, draw_configurations_in, draw_errors, generator, joint_box, lay_out, measure_with, set_up,
    within_limits,
};

/// Configurations tried for a reading of a contact before it is given up.
const TRIALS: usize = 400;

pub fn run(command: &Simulate, session: &Session) -> Result<Output, Error> {
    refuse(command)?;
    let mut design = session.reader.design(&command.robot, None)?;
    for text in &command.effect {
        let entry = effect(&design.robot.model, text)?;
        design.robot.model.switch_on(entry);
    }
    keep_out(&command.keep_out, &mut design.robot)?;
    let mut raw = stated(plain(&design.raw), command, &design.kinds);
    if raw.loads.joints == LoadSource::Measured {
        return Err(Error::input(
            "`loads: {joints: measured}`: simulated torques are those of the description",
            "leave `loads:` out for the simulation",
        ));
    }
    let mut random = generator(session.seed());
    let mut values = draw_errors(&design.robot.model, command.errors, command.elastic_errors, &mut random);
    let (configurations, rows, mut diagnostics) =
        configurations(command, session, &design, &raw, &values, &mut random)?;
    let units = &design.robot.raw.units;
    let wrenches = command.wrench.iter().map(|text| wrench(units, text)).collect::<Result<Vec<_>, Error>>()?;
    let runs = runs(command, session, &raw);
    let wanted = Wanted {
        markers: &command.markers,
        repeats: command.repeats,
        wrenches: &wrenches,
        placements: command.placements,
        runs: &runs,
        given: rows.as_deref(),
    };
    let loaded = blank(&design, raw.clone(), &wanted, &configurations)?;
    diagnostics.extend(loaded.diagnostics);
    let (model, mut campaign) = (&loaded.robot.model, loaded.campaign);
    values.extend_from_slice(&model.registry.nominal()[values.len()..]);
    arrange(model, &campaign, &mut values, &mut random)?;
    lay_out(model, &campaign, false, &mut values, &mut random)?;
    set_errors(&loaded.robot, &command.set, &mut values)?;
    if command.conditions || !model.effects.is_empty() {
        conditions(model, &mut campaign, &mut random);
    }
    bring_to_contacts(command, model, &values, &mut campaign, &mut random)?;
    let entries = raw.entries();
    let campaign = measured(model, &values, campaign, &entries, &mut random)?;
    raw.robot = Some(robot_of(command, &design));
    raw.source = Some(source(session.seed()));
    let campaign = with_sets(command, campaign, &mut random);
    let markers: Vec<String> = design.robot.model.markers.iter().map(|marker| marker.name.clone()).collect();
    let file = |entry: &RawEntry| {
        let own = campaign.select(|_, reading| campaign.file(reading) == Some(entry.file.as_str()));
        Ok((entry.file.clone(), csv_in(&own, &model.variables, &markers, &entry.units(Units::default()))?))
    };
    let files = entries.iter().map(file).collect::<Result<Vec<_>, Error>>()?;
    let simulated = Simulated { campaign: &campaign, header: &raw, files, points: None };
    let mut output = written(command, &loaded.robot, &values, session.seed(), simulated)?;
    output.diagnostics.extend(diagnostics);
    Ok(output)
}

/// The readings with noise, that of each file's instrument.
fn measured(
    model: &Model,
    values: &[f64],
    campaign: Campaign,
    entries: &[RawEntry],
    random: &mut ChaCha8Rng,
) -> Result<Campaign, Error> {
    let blank = campaign.clone();
    let ppm = |file: Option<&str>| {
        let entry = entries.iter().find(|entry| Some(entry.file.as_str()) == file);
        entry.and_then(|entry| entry.instrument.as_ref()?.ppm).unwrap_or(0.0) * 1e-6
    };
    let noise = |reading: &Reading| Noise { ppm: ppm(blank.file(reading)), ..reading.noise };
    Ok(measure_with(model, values, campaign, noise, random)?)
}

/// What the campaign file says, and the command must not.
fn refuse(command: &Simulate) -> Result<(), Error> {
    let stated = [
        ("--observes", command.observes.is_some(), "`observes:`"),
        ("--unknown-base", command.unknown_base, "`estimate: {base: true}`"),
        ("--unknown-tool", command.unknown_tool, "`estimate: {tool: true}`"),
        ("--process", command.process.is_some(), "readings along a path are simulated from the robot's description"),
    ];
    match stated.into_iter().find(|(_, is_given, _)| *is_given) {
        Some((flag, _, word)) => Err(Error::input(
            format!("{flag}, and `{}` is a campaign, which says what is read", command.robot),
            format!("leave {flag} out; in the campaign file it is {word}"),
        )),
        None if !(1..=1000).contains(&command.placements) => {
            Err(Error::input(format!("--placements {}", command.placements), "give a number from 1 to 1000"))
        }
        None => Ok(()),
    }
}

/// Of each file, the sessions and stations of its rows: those of the command, else those that the measured tables name in columns, where the
/// campaign estimates anything by them.
fn runs(command: &Simulate, session: &Session, raw: &RawCampaign) -> Vec<Vec<Cells>> {
    let entries = raw.measurements.as_ref().map_or(&[][..], |all| &all.0);
    let of = |column: &str, name: &String| Cells::from([(column.to_string(), name.clone())]);
    if !command.sessions.is_empty() {
        let all: Vec<Cells> = command.sessions.iter().map(|name| of("session", name)).collect();
        return vec![all; entries.len()];
    }
    let shared = [raw.estimate.base, raw.estimate.tool, raw.estimate.scale];
    if shared.iter().all(|sharing| sharing.0.unwrap_or_default() == Sharing::All) {
        return Vec::new();
    }
    let Ok(measured) = session.reader.campaign(&command.robot, None) else { return Vec::new() };
    let campaign = &measured.campaign;
    let mut begin = 0;
    let mut all = Vec::new();
    for ((_, end), entry) in campaign.files.iter().zip(entries) {
        let mut runs: Vec<Cells> = Vec::new();
        for reading in campaign.readings.iter().filter(|reading| (begin + 1..=*end).contains(&reading.row)) {
            let InSession { session, station } = reading.session;
            let names = [
                ("session", &entry.session, campaign.sessions.names.get(session)),
                ("station", &entry.station, campaign.sessions.stations.get(station)),
            ];
            let is_said = |name: &&String| !name.is_empty();
            let cells = names.into_iter().filter(|(_, key, _)| key.is_none());
            let cells = cells.filter_map(|(column, _, name)| Some(of(column, name.filter(is_said)?)));
            let cells: Cells = cells.flatten().collect();
            if !cells.is_empty() && !runs.contains(&cells) {
                runs.push(cells);
            }
        }
        begin = *end;
        all.push(runs);
    }
    all
}

/// The campaign file with the noise of the command, where it states none: as the measured files state it in columns, say.
fn stated(mut raw: RawCampaign, command: &Simulate, known: &Kinds) -> RawCampaign {
    let states = |instrument: &Option<RawInstrument>| instrument.is_some();
    if states(&raw.instrument) || raw.measurements.iter().flat_map(|all| &all.0).any(|entry| states(&entry.instrument))
    {
        let completed = raw.entries();
        let entries = raw.measurements.iter_mut().flat_map(|all| &mut all.0);
        for (entry, whole) in entries.zip(completed) {
            let has_lengths = kinds(&whole, known).iter().any(|kind| kind.length_rows() > 0 || kind.touches());
            let units = whole.units(raw.units);
            let instrument = whole.instrument.unwrap_or_default();
            if has_lengths && instrument.sigma.is_none() && command.noise > 0.0 {
                let unit = units.length.factor() / 1e-3;
                entry.instrument =
                    Some(RawInstrument { sigma: Some(RawSigma::All(command.noise / unit)), ..instrument });
            }
        }
        return raw;
    }
    let length = Units::default().length.factor() * 1e-3 / raw.units.length.factor();
    let angle = 1f64.to_radians() / raw.units.angle.factor();
    let instrument = RawInstrument {
        sigma: (command.noise > 0.0).then_some(RawSigma::All(command.noise * length)),
        orientation: (command.orientation_noise > 0.0).then_some(command.orientation_noise * angle),
        ..RawInstrument::default()
    };
    RawCampaign { instrument: Some(instrument), ..raw }
}

/// The robot as the new campaign names it: as the design does, seen from the folder.
fn robot_of(command: &Simulate, design: &Design) -> String {
    let named = design.raw.robot.clone().unwrap_or_default();
    let folder = std::path::Path::new(&command.robot);
    let folder = if folder.is_dir() { Some(folder) } else { folder.parent() };
    let next_to = folder.map_or_else(|| named.clone(), |folder| folder.join(&named).display().to_string());
    as_seen_from(&command.into, if std::path::Path::new(&next_to).is_file() { &next_to } else { &named })
}

/// Configurations of each file, and the rows in which a file has them.
type OfFiles = (Vec<Vec<Vec<f64>>>, Option<Vec<Cells>>, Vec<crate::diagnostic::Diagnostic>);

fn configurations(
    command: &Simulate,
    session: &Session,
    design: &Design,
    raw: &RawCampaign,
    values: &[f64],
    random: &mut ChaCha8Rng,
) -> Result<OfFiles, Error> {
    let (robot, files) = (&design.robot, raw.measurements.as_ref().map_or(1, |all| all.0.len()));
    let geometry = Geometry::new(&robot.model, values)?;
    if command.poses.parse::<usize>().is_ok() {
        let mut all = Vec::new();
        let mut diagnostics = Vec::new();
        for _ in 0..files {
            let (drawn, _, warnings): Configurations = drawn(command, session, robot, &geometry, random)?;
            all.push(drawn);
            diagnostics = warnings;
        }
        return Ok((all, None, diagnostics));
    }
    let rows = given(session, std::path::Path::new(&command.poses))?;
    let mut all = Vec::new();
    for (k, row) in rows.iter().enumerate() {
        let mut q = Vec::new();
        for variable in &robot.model.variables {
            let text = row.get(&variable.name).map_or("", String::as_str);
            let value = text.parse::<f64>().ok().filter(|value| value.is_finite()).ok_or_else(|| {
                let message =
                    format!("`{}`, row {}: `{text}` is no value of `{}`", command.poses, k + 1, variable.name);
                Error::input(message, "give a column for each variable, in the campaign's units")
            })?;
            q.push(value * raw.units.of(variable.kind()));
        }
        all.push(q);
    }
    Ok((vec![all; files], Some(rows), Vec::new()))
}

/// Puts base, tool and scale of each session somewhere, as far as they are unknown.
fn arrange(model: &Model, campaign: &Campaign, values: &mut [f64], random: &mut ChaCha8Rng) -> Result<(), Error> {
    let sessions = &campaign.sessions;
    let placed = campaign.readings.iter().filter(|reading| !reading.observes.ignores_arrangement());
    let markers: Vec<Option<usize>> = distinct(placed.map(|reading| reading.marker));
    for k in 0..sessions.parts(sessions.base).len() {
        let of = InSession { session: k, station: k };
        set_up(model, &markers, of, [campaign.estimate_base, false], values, random);
    }
    for k in 0..sessions.parts(sessions.tool).len() {
        let of = InSession { session: k, station: k };
        set_up(model, &markers, of, [false, campaign.estimate_tool], values, random);
    }
    for k in 0..sessions.parts(sessions.scale).len() {
        if let Some(slot) = model.scale_slot(InSession { session: k, station: k }) {
            let draw: f64 = StandardNormal.sample(random);
            values[slot] += 1e-4 * draw;
        }
    }
    Ok(())
}

/// Moves the joints of readings of contacts to where the ball touches, but for the noise of the contact.
fn bring_to_contacts(
    command: &Simulate,
    model: &Model,
    values: &[f64],
    campaign: &mut Campaign,
    random: &mut ChaCha8Rng,
) -> Result<(), Error> {
    let contacts: Vec<usize> =
        (0..campaign.readings.len()).filter(|k| campaign.readings[*k].observes.touches()).collect();
    if contacts.is_empty() {
        return Ok(());
    }
    let before = campaign.clone();
    let toucher = Toucher::new(model, values, &before)?;
    // Spheres are touched from all sides that are open, as points on them are.
    let mut pointed = before.clone();
    pointed.readings.iter_mut().filter(|reading| reading.observes.touches()).for_each(|own| own.observes = SOCKET);
    let pointer = Toucher::new(model, values, &pointed)?;
    let geometry = Geometry::new(model, values)?;
    let within = joint_box(model, command.share);
    let mut placements = Placements::default();
    let variables = campaign.variables;
    let mut known: Option<(usize, usize)> = None;
    for index in contacts {
        let reading = before.readings[index];
        // Repeats of a pose are brought there anew.
        if known == Some((reading.pose, reading.row)) {
            continue;
        }
        known = Some((reading.pose, reading.row));
        let target = target_values(model, &before, reading.target, values);
        let mut off = [0.0; 6];
        reading.observes.disturb(&mut off, &reading.noise, &mut || StandardNormal.sample(random));
        let mut start = before.configuration(index).to_vec();
        let mut found = None;
        for _ in 0..TRIALS {
            if reading.observes.touched_from(&target, &Vector3::z()).is_some() {
                let from = direction(random);
                let from = Vector3::new(from.x, from.y, from.z.abs());
                let Some(point) = reading.observes.touched_from(&target, &from) else { continue };
                let mut there = target;
                there[..3].copy_from_slice(point.as_slice());
                start = pointer.touching(index, &there, &start, &[0.0; 6]).unwrap_or(start);
            }
            found = toucher.touching(index, &target, &start, &off).filter(|q| {
                geometry.place(q, &mut placements).is_ok()
                    && within_limits(&geometry, q, &placements)
                    && q.iter().zip(&within).all(|(q, [low, high])| (*low..=*high).contains(q))
            });
            if found.is_some() {
                break;
            }
            start = draw_configurations_in(&geometry, &within, 1, random)?.pop().unwrap_or(start);
        }
        let Some(q) = found else {
            let name = before.target_of(&reading).map_or("", |target| target.name.as_str());
            return Err(Error::input(
                format!("`{name}`: the ball cannot be brought there"),
                "give `near: [x, y, z]` of the contact within the arm's reach, or widen --share",
            ));
        };
        let row = reading.row;
        for k in (0..campaign.readings.len()).filter(|k| before.readings[*k].row == row) {
            campaign.joints[k * variables..(k + 1) * variables].copy_from_slice(&q);
        }
    }
    Ok(())
}
