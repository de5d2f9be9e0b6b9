//! `compensate`: commands under which the real robot passes where it should.

mod controller;
mod program;
mod stream;

pub use controller::ControllerFile;

use controller::Shown;
use program::Program;

use crate::Error;
use crate::cli::args::Compensate;
use crate::cli::output::Output;
use crate::cli::session::Session;
use crate::cli::values::{hold, joints, units_with, wrench};
use crate::compensation::{Desired, Hold, Outcome, Point, Refusal, Settings, compensate};
use crate::description::campaign::Reading;
use crate::description::path::Path;
use crate::diagnostic::Diagnostic;
use crate::elastics::Elastics;
use crate::files::{LoadedRobot, writable_table};
use crate::fuzzy;
use crate::kinematics::Geometry;
use crate::model::{Condition, Model};
use crate::render::compensation as render;
use crate::results::Compensation;

pub fn run(command: &Compensate, session: &Session) -> Result<Output, Error> {
    if let Some(table) = &command.table {
        writable_table(table)?;
    }
    let within = |value: f64, most: f64| value > 0.0 && value <= most;
    if !within(command.residual, 10.0) || !within(command.largest, 90.0) {
        return Err(Error::input(
            "a number is out of range",
            "--residual is above 0 and at most 10 mm, --largest above 0 and at most 90 deg",
        ));
    }
    if command.keep_going && command.table.is_none() && command.program.is_none() {
        return Err(Error::input(
            "--keep-going, and nothing is to be written",
            "add --table FILE or --program LANGUAGE",
        ));
    }
    let program = Program::new(command, session)?;
    let held = if command.hold.is_empty() { None } else { Some(hold(&command.hold)?) };
    let loaded = session.reader.robot(&command.robot)?;
    let model = &loaded.model;
    let settings = settings(command, model, held);
    let units = units_with(&loaded.raw.units, command.units.as_deref())?;
    let from = command.from.as_deref().map(|text| joints(model, &loaded.raw.units, text)).transpose()?;
    let Some(file) = &command.path else {
        return stream::run(&stream::Stream { command, session, loaded: &loaded, units, settings, from });
    };
    let mut path = session.reader.path(file, &loaded, units)?;
    load(command, &loaded, &mut path)?;
    let mut diagnostics = loaded.diagnostics.clone();
    let process = match &command.process {
        Some(file) => {
            let (process, mut warnings) = session.reader.process(file)?;
            diagnostics.append(&mut warnings);
            Some(process)
        }
        None => None,
    };
    diagnostics.extend(condition_doubts(model, &path));
    let controller = ControllerFile::new(command.nominal.as_deref(), &loaded, &path, session)?;
    diagnostics.extend(controller.diagnostics.iter().cloned());
    let shown = controller.geometry(&loaded)?;
    let desired = shown.desired(&path, from.as_deref(), command.frame, settings.hold)?;
    diagnostics.extend(compliance_doubts(model, &path, &desired, process.is_some())?);
    let values = model.registry.nominal();
    let outcome = compensate(model, &values, &path.campaign, &desired, process.as_ref(), &settings)?;
    let corrected = outcome.points.iter().zip(&path.campaign.readings);
    let corrected = corrected.filter_map(|(point, reading)| Some((point.as_ref().ok()?, reading)));
    let states = corrected.map(|(point, reading)| (point.corrected.joints.as_slice(), &reading.wrench));
    diagnostics.extend(loaded.outside(states));
    let mut found = found(&loaded, &path, &shown, &desired, &outcome, settings.hold)?;
    found.process = process.map(|process| process.name);
    let all_met = found.refused.is_empty();
    let is_written = all_met || command.keep_going;
    let mut text = render::compensation(&found, session.terminal.screen);
    let mut tables = Vec::new();
    if let Some(file) = &command.table {
        let shown = file.display();
        if is_written {
            tables.push((file.clone(), render::table(&found, &units, file)?));
            found.table = Some(shown.to_string());
            text += &format!("commands, and the controller's poses of them: {shown}\n");
        } else {
            text += &format!("{shown} is not written, since points are refused; --keep-going writes the others\n");
        }
    }
    let mut output = Output::new(text, &found)?;
    output.tables = tables;
    output.failed = !all_met;
    output.diagnostics = diagnostics;
    match program {
        Some(program) if is_written => program.output(&found, file, output),
        Some(_) => {
            output.text += "no program is written, since points are refused; --keep-going writes the others\n";
            Ok(output)
        }
        None => Ok(output),
    }
}

/// The outcome as a result, with the controller's poses and the uncertainty of the points.
fn found(
    loaded: &LoadedRobot,
    path: &Path,
    shown: &Shown,
    desired: &[Result<Desired, Refusal>],
    outcome: &Outcome,
    hold: Hold,
) -> Result<Compensation, Error> {
    let model = &loaded.model;
    let nominal: Vec<Option<Vec<f64>>> = desired.iter().map(|d| d.as_ref().ok().map(|d| d.nominal.clone())).collect();
    let points = outcome.points.iter().zip(&path.campaign.readings);
    let pose = |(point, reading): (&Result<_, _>, &Reading)| {
        let point: &Point = point.as_ref().ok()?;
        shown.pose(&point.corrected.joints, reading.marker)
    };
    let poses: Vec<Option<[f64; 6]>> = points.map(pose).collect();
    let names: Vec<String> =
        path.campaign.readings.iter().map(|reading| path.campaign.poses[reading.pose].clone()).collect();
    let found = Compensation::new(model, &names, &nominal, &poses, outcome, hold);
    let Some(uncertainty) = loaded.uncertainty() else { return Ok(found) };
    let mut reached = path.campaign.clone();
    for (point, q) in outcome.points.iter().zip(reached.joints.chunks_mut(model.variables.len().max(1))) {
        if let Ok(point) = point {
            q.copy_from_slice(&point.corrected.joints);
        }
    }
    Ok(found.with_uncertainties(&uncertainty.positions(model, &reached)?))
}

/// Puts the marker and the wrench that the command names into a path.
fn load(command: &Compensate, loaded: &LoadedRobot, path: &mut Path) -> Result<(), Error> {
    at_marker(command.at.as_deref(), loaded, path)?;
    if let Some(text) = &command.wrench {
        if path.campaign.readings.iter().any(Reading::is_loaded) {
            return Err(Error::input("--wrench, and the path has wrenches of its own", "give one of them"));
        }
        let constant = wrench(&loaded.raw.units, text)?;
        path.campaign.readings.iter_mut().for_each(|reading| reading.wrench = constant);
    }
    Ok(())
}

fn settings(command: &Compensate, model: &Model, held: Option<Hold>) -> Settings {
    let mut settings = Settings::new(model.variables.len());
    settings.hold = held.unwrap_or(settings.hold);
    settings.residual = command.residual * 1e-3;
    settings.largest = command.largest.to_radians();
    settings
}

/// Warnings of effects that depend on conditions which the path does not give.
fn condition_doubts(model: &Model, path: &Path) -> Vec<Diagnostic> {
    let mut diagnostics = Vec::new();
    let reader = |condition| model.effects.iter().map(|on| &on.entry.effect).find(|e| e.reads().contains(&condition));
    if let Some(effect) = reader(Condition::Temperature)
        && !path.campaign.conditions.has_temperature()
    {
        let text = format!("the description has `{}`, and the path no temperature: it is not corrected", effect.name());
        diagnostics.push(Diagnostic::warning(text).remedy("add a column `temperature`, or `temperature.<frame>`"));
    }
    if let Some(effect) = reader(Condition::Approach)
        && path.campaign.readings.len() < 2
    {
        let name = effect.name();
        let text = format!("the description has `{name}`, and one point does not say from which side it is reached");
        diagnostics.push(Diagnostic::warning(text).remedy("add columns `approach.<variable>`, 1 or -1"));
    }
    diagnostics
}

/// Warnings where the description does not know the compliance that the path needs.
fn compliance_doubts(
    model: &Model,
    path: &Path,
    desired: &[Result<Desired, Refusal>],
    has_process: bool,
) -> Result<Vec<Diagnostic>, Error> {
    let geometry = Geometry::nominal(model)?;
    let asked: Vec<(&[f64], Option<Option<usize>>)> = desired
        .iter()
        .zip(&path.campaign.readings)
        .filter_map(|(desired, reading)| Some((desired.as_ref().ok()?.nominal.as_slice(), Some(reading.marker))))
        .collect();
    let mut diagnostics = fuzzy::doubts(model, &geometry, &asked);
    let pushed = has_process || path.campaign.readings.iter().any(Reading::is_loaded);
    if pushed && model.fuzzy.is_none() && !Elastics::new(model, geometry.values(), &[]).is_compliant() {
        let text = "something pushes on the tool, and the description declares nothing that gives: it is not corrected";
        diagnostics.push(
            Diagnostic::warning(text).remedy("give `joint_stiffness`, `beams` or `base_stiffness`, or identify them"),
        );
    }
    Ok(diagnostics)
}

/// `--at` for a path that does not say which marker passes.
fn at_marker(at: Option<&str>, loaded: &LoadedRobot, path: &mut Path) -> Result<(), Error> {
    let Some(name) = at else { return Ok(()) };
    let Some(marker) = loaded.model.marker(name) else {
        let valid = loaded.model.markers.iter().map(|marker| marker.name.as_str());
        return Err(Error::from(vec![
            Diagnostic::error(format!("--at: no marker is called `{name}`")).suggest(name, valid),
        ]));
    };
    if path.campaign.readings.iter().any(|reading| reading.marker.is_some()) {
        return Err(Error::input("--at, and the path has a column `marker`", "give one of them"));
    }
    path.campaign.readings.iter_mut().for_each(|reading| reading.marker = Some(marker));
    Ok(())
}
