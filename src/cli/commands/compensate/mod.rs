//! `compensate`: commands under which the real robot passes where it should.

mod controller;
mod points;
mod program;
mod stream;
mod vary;

pub use controller::ControllerFile;

use points::{condition_doubts, found, load, orientation_doubt, unit_doubt};
use program::Program;

use crate::Error;
use crate::cli::args::Compensate;
use crate::cli::commands::pose::linear;
use crate::cli::output::Output;
use crate::cli::session::Session;
use crate::cli::values::{hold, joints, units_with};
use crate::compensation::{Deflects, Desired, Hold, Refusal, Settings, compensate};
use crate::description::campaign::Reading;
use crate::description::path::Path;
use crate::description::units::Units;
use crate::description::validity::State;
use crate::diagnostic::Diagnostic;
use crate::elastics::{Elastics, fuzzy_doubts};
use crate::files::writable_table;
use crate::kinematics::Geometry;
use crate::model::Model;
use crate::plausibility::{Limits, as_stiff_as_arms};
use crate::render::compensation as render;
use crate::results::Compensation;
use crate::results::units::mm;

pub fn run(command: &Compensate, session: &Session) -> Result<Output, Error> {
    can_be_done(command)?;
    let program = Program::new(command, session)?;
    let held = if command.hold.is_empty() { None } else { Some(hold(&command.hold)?) };
    let loaded = session.reader.robot(&command.robot)?;
    let model = &loaded.model;
    linear(model, command.equilibrium)?;
    let settings = settings(command, model, held);
    let units = units_with(&loaded.raw.units, command.units.as_deref())?;
    let from = command.from.as_deref().map(|text| joints(model, &loaded.raw.units, text)).transpose()?;
    let Some(file) = &command.path else {
        return stream::run(&stream::Stream { command, session, loaded: &loaded, units, settings, from });
    };
    let mut path = session.reader.path_as(file, &loaded, units, command.orientation.into())?;
    load(command, &loaded, &mut path)?;
    let mut diagnostics = loaded.diagnostics.clone();
    diagnostics.extend(as_stiff_as_arms(model, &Limits::default()));
    let process = command.process.as_deref().map(|file| session.reader.process_as_declared(file)).transpose()?;
    let process = process.map(|(raw, process, warnings)| {
        diagnostics.extend(warnings);
        (raw, process)
    });
    diagnostics.extend(condition_doubts(model, &path));
    diagnostics.extend(unit_doubt(&loaded, &path, &units));
    diagnostics.extend(orientation_doubt(&path, &units));
    let controller = ControllerFile::new(command.nominal.as_deref(), &loaded, &path, session)?;
    diagnostics.extend(controller.diagnostics.iter().cloned());
    let shown = controller.geometry(&loaded)?;
    if !command.vary.is_empty() {
        let (process, from) = (process.as_ref(), from.as_deref());
        let (loaded, path, shown, settings) = (&loaded, &path, &shown, &settings);
        return vary::run(&vary::Vary { command, session, loaded, path, process, shown, from, settings });
    }
    let process = process.map(|(_, process)| process);
    let desired = shown.desired(&path, from.as_deref(), command.frame, settings.hold)?;
    diagnostics.extend(compliance_doubts(model, &path, &desired, process.is_some())?);
    let values = model.registry.nominal();
    let outcome = compensate(model, &values, &path.campaign, &desired, process.as_ref(), &settings)?;
    let met = outcome.points.iter().zip(&path.campaign.readings).enumerate();
    let states = met.filter_map(|(index, (point, reading))| {
        let temperature = path.campaign.conditions.temperature_of(index);
        Some(State { temperature, ..State::new(&point.as_ref().ok()?.corrected.joints, &reading.wrench) })
    });
    diagnostics.extend(loaded.outside(states));
    let mut found = found(&loaded, &path, &shown, &desired, &outcome, settings.hold)?;
    found.process = process.map(|process| process.name);
    diagnostics.extend(linear_doubt(command, &found));
    let refused = outcome.points.iter().filter_map(|point| point.as_ref().err());
    diagnostics.extend(hold_doubt(command, model, refused));
    diagnostics.extend(program.as_ref().and_then(|program| program.doubt(&found, shown.geometry())));
    let mut output = corrected(command, session, &mut found, &units)?;
    output.diagnostics = diagnostics;
    let is_written = !output.failed || command.keep_going;
    match program {
        Some(program) if is_written => program.output(&found, file, output),
        Some(_) => {
            output.text += "no program is written, since points are refused; --keep-going writes the others\n";
            // A program that stands there is not replaced by these words.
            output.written = true;
            Ok(output)
        }
        None => Ok(output),
    }
}

/// Refuses options out of range, and files that could not be written.
fn can_be_done(command: &Compensate) -> Result<(), Error> {
    command.table.as_deref().map_or(Ok(()), writable_table)?;
    let within = |value: f64, most: f64| value > 0.0 && value <= most;
    if !within(residual(command), 10.0) || !within(command.largest, 90.0) {
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
    Ok(())
}

/// The commands as text and JSON, and their table where one is asked for and written.
fn corrected(
    command: &Compensate,
    session: &Session,
    found: &mut Compensation,
    units: &Units,
) -> Result<Output, Error> {
    let all_met = found.refused.is_empty();
    let mut text = render::compensation(found, session.terminal.screen);
    let mut tables = Vec::new();
    if let Some(file) = &command.table {
        let shown = file.display();
        if all_met || command.keep_going {
            tables.push((file.clone(), render::table(found, units, file)?));
            found.table = Some(shown.to_string());
            text += &format!("commands, and the controller's poses of them: {shown}\n");
        } else {
            text += &format!("{shown} is not written, since points are refused; --keep-going writes the others\n");
        }
    }
    let mut output = Output::new(text, found)?;
    output.tables = tables;
    output.failed = !all_met;
    Ok(output)
}

/// Residual up to which a point counts as met, mm.
fn residual(command: &Compensate) -> f64 {
    command.residual.unwrap_or(1e-4)
}

/// A word on `--hold` where a robot of few axes cannot be where the path wants it, and nobody said what may be let go.
fn hold_doubt<'r>(
    command: &Compensate,
    model: &Model,
    mut refused: impl Iterator<Item = &'r Refusal>,
) -> Option<Diagnostic> {
    let axes = model.variables.len();
    let is_few = axes < 6 && command.hold.is_empty();
    (is_few && refused.any(|why| matches!(why, Refusal::Unreachable(_) | Refusal::Singular { .. }))).then(|| {
        let text =
            format!("points are out of reach or singular, and a robot of {axes} axes cannot turn its tool as it likes");
        Diagnostic::warning(text).remedy(
            "say what it is to hold with --hold, as `--hold x,y,z,rz` of a SCARA: the other axes are free, and reported",
        )
    })
}

/// A warning where the linear deflection is off by more than the residual that was asked for.
fn linear_doubt(command: &Compensate, found: &Compensation) -> Option<Diagnostic> {
    let (asked, most) = (command.residual?, mm(found.linear_error?.max));
    (most > asked).then(|| {
        let text = format!(
            "the linear deflection is off the equilibrium at the deflected pose by up to {most:.4} mm, more than --residual {asked}"
        );
        Diagnostic::warning(text).remedy("give --equilibrium")
    })
}

fn settings(command: &Compensate, model: &Model, held: Option<Hold>) -> Settings {
    let mut settings = Settings::new(model.variables.len());
    settings.hold = held.unwrap_or(settings.hold);
    settings.residual = residual(command) * 1e-3;
    // A stream answers while the robot waits.
    settings.deflection = match (command.equilibrium, command.stream || model.fuzzy.is_some()) {
        (true, _) => Deflects::Equilibrium,
        (false, false) => Deflects::Compared,
        (false, true) => Deflects::Linear,
    };
    settings.largest = command.largest.to_radians();
    settings
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
    let mut diagnostics = fuzzy_doubts(model, &geometry, &asked);
    let pushed = has_process || path.campaign.readings.iter().any(Reading::is_loaded);
    if pushed && model.fuzzy.is_none() && !Elastics::new(model, &model.shifted(geometry.values()), &[]).is_compliant() {
        let text = "something pushes on the tool, and the description declares nothing that gives: it is not corrected";
        diagnostics.push(
            Diagnostic::warning(text).remedy("give `joint_stiffness`, `beams` or `base_stiffness`, or identify them"),
        );
    }
    Ok(diagnostics)
}
