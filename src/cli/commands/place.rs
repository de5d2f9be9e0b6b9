//! `place`: where a process deflects the arm least.

use nalgebra::{Rotation3, Translation3, Vector3};

use super::compensate::ControllerFile;
use crate::Error;
use crate::cli::args::{FrameName, PlaceOf};
use crate::cli::boxes::keep_out;
use crate::cli::output::Output;
use crate::cli::session::Session;
use crate::cli::values::{hold, joints, movement, nothing_elastic, units_with, within, wrench};
use crate::compensation::{Desired, Hold, Refusal};
use crate::description::campaign::{LoadPoint, Reading};
use crate::description::path::Path;
use crate::description::units::Units;
use crate::description::validity::State;
use crate::elastics::Elastics;
use crate::files::{LoadedRobot, writable_table};
use crate::kinematics::{AssemblyError, Transform};
use crate::planning::stiffest::{Search, StiffestError, Wanted, Way, Work, as_given, place};
use crate::plausibility::{Limits, as_stiff_as_arms};
use crate::prediction::SinglePredictor;
use crate::process::Process;
use crate::render::place as render;
use crate::results::Placement;

pub fn run(command: &PlaceOf, session: &Session) -> Result<Output, Error> {
    command.table.as_deref().map_or(Ok(()), writable_table)?;
    within("--condition", command.condition, |v| v > 1.0 && v <= 1e6, "give a number above 1, at most 1e6")?;
    let mut loaded = session.reader.robot(&command.robot)?;
    keep_out(&command.keep_out, &mut loaded)?;
    let loaded = loaded;
    let (model, own) = (&loaded.model, &loaded.raw.units);
    let units = units_with(own, command.units.as_deref())?;
    let wanted = wanted(command, &loaded, session)?;
    let from = command.from.as_deref().map(|text| joints(model, own, text)).transpose()?;
    let path = session.reader.path_as(&command.path, &loaded, units, command.orientation.into())?;
    if path.campaign.readings.iter().any(|reading| reading.marker.is_some()) {
        return Err(Error::input(
            "the path has a column `marker`, and what is placed is the tool centre point",
            "leave the column out, and declare `tool: {frame: .., at: ..}` where the marker is",
        ));
    }
    let is_of_point = |reading: &Reading| reading.payload.is_some() || reading.load_point != LoadPoint::Measured;
    if path.campaign.readings.iter().any(is_of_point) {
        return Err(Error::input(
            "the path has a column `payload` or `load_point`, which `place` does not count",
            "leave it out: declare what the tool carries under `bodies:`, and give wrenches at the tool centre point",
        ));
    }
    let mut diagnostics = loaded.diagnostics.clone();
    diagnostics.extend(as_stiff_as_arms(model, &Limits::default()));
    let controller = ControllerFile::new(None, &loaded, &path, session)?;
    let desired = controller.geometry(&loaded)?.desired(&path, from.as_deref(), FrameName::Base, wanted.hold)?;
    let process = command.process.as_deref().map(|file| session.reader.process(file)).transpose()?;
    let process = process.map(|(process, warnings)| {
        diagnostics.extend(warnings);
        process
    });
    let constant = command.wrench.as_deref().map(|text| wrench(own, text)).transpose()?;
    let targets = targets(&path, &desired, wanted.hold)?;
    let mut work = Work {
        wrenches: path.campaign.readings.iter().map(|reading| reading.wrench).collect(),
        carried: constant.unwrap_or_default(),
        from: desired.first().and_then(|first| first.as_ref().ok()).map(|first| first.nominal.clone()),
        targets,
    };
    if let Some(process) = &process {
        push(process, &mut work)?;
    }
    gives(&loaded, &work, command.weight)?;
    let predictor = SinglePredictor::new(model, &model.registry.nominal(), &path.campaign)?;
    let given: Option<Vec<Vec<f64>>> = desired.iter().map(|d| d.as_ref().ok().map(|d| d.nominal.clone())).collect();
    let given: Option<Way> = given.and_then(|joints| as_given(&predictor, &work, &wanted, joints));
    let bar = session.terminal.bar(Some(100), "{spinner} placing the path {bar:30} {percent} %");
    let placed = place(&predictor, &work, &wanted, &mut |share| bar.set_position((100.0 * share) as u64));
    drop(bar);
    let placed = placed.map_err(refused)?;
    let reached = placed.best.postures.iter().map(|posture| State::new(&posture.joints, &posture.wrench));
    diagnostics.extend(loaded.outside(reached));
    let readings = &path.campaign.readings;
    let names: Vec<String> = readings.iter().map(|reading| path.campaign.poses[reading.pose].clone()).collect();
    let mut found = Placement::new(model, &names, given.as_ref(), &placed, &wanted);
    found.process = process.map(|process| process.name);
    found.table = command.table.as_ref().map(|file| file.display().to_string());
    let mut output = output(&found, command, session, &units)?;
    output.diagnostics = diagnostics;
    Ok(output)
}

/// What was found as text and JSON, and the table of the path where it is asked for.
fn output(found: &Placement, command: &PlaceOf, session: &Session, units: &Units) -> Result<Output, Error> {
    let mut output = Output::new(render::placement(found, session.terminal.screen), found)?;
    if let Some(file) = &command.table {
        output.table("the path there, with its joints and wrenches", file, render::table(found, units, file)?);
    }
    Ok(output)
}

/// What is asked of the place.
fn wanted(command: &PlaceOf, loaded: &LoadedRobot, session: &Session) -> Result<Wanted, Error> {
    Ok(Wanted {
        hold: if command.hold.is_empty() { Hold::of(loaded.model.variables.len()) } else { hold(&command.hold)? },
        within: movement("--move", &loaded.raw.units, &command.movement)?,
        directions: ["x", "y", "z"]
            .map(|axis| command.direction.is_empty() || command.direction.iter().any(|own| own == axis)),
        weight: command.weight,
        least: command.least,
        worst_condition: command.condition,
        seed: session.seed(),
        search: Search::default(),
    })
}

/// Targets of the tool centre point; where the path is out of reach as it is given, those that its poses say.
fn targets(path: &Path, desired: &[Result<Desired, Refusal>], hold: Hold) -> Result<Vec<Transform>, Error> {
    let says = path.position && (path.orientation || !hold.turns());
    let rows = desired.iter().zip(&path.campaign.readings).enumerate();
    rows.map(|(index, (desired, reading))| match desired {
        Ok(desired) => Ok(desired.target),
        Err(_) if says => {
            let v = &reading.measured;
            let turn = Rotation3::new(Vector3::new(v[3], v[4], v[5]));
            Ok(Transform::from_parts(Translation3::new(v[0], v[1], v[2]), turn))
        }
        Err(why) => Err(Error::from(why.clone()).at(format!("point {}", index + 1))),
    })
    .collect()
}

/// Adds what a process does to the tool where it should be; what is carried does not turn with the workpiece.
fn push(process: &Process, work: &mut Work) -> Result<(), Error> {
    let at = |index: usize| work.targets.get(index).map(|target| target.translation.vector);
    for index in 0..work.targets.len() {
        let Some(here) = at(index) else { continue };
        let travel = match (index.checked_sub(1).and_then(at), at(index + 1)) {
            (Some(before), _) => here - before,
            (None, Some(after)) => after - here,
            (None, None) => Vector3::zeros(),
        };
        let push = process.push(&here, &travel).map_err(|why| Error::from(why).at(format!("point {}", index + 1)))?;
        let force = push.force - process.carried;
        (0..3).for_each(|k| work.wrenches[index][k] += force[k]);
    }
    (0..3).for_each(|k| work.carried[k] += process.carried[k]);
    Ok(())
}

/// Refuses what cannot be deflected.
fn gives(loaded: &LoadedRobot, work: &Work, weight: bool) -> Result<(), Error> {
    let model = &loaded.model;
    if work.targets.is_empty() {
        return Err(Error::input("the path has no points", "give a row a point"));
    }
    if !Elastics::new(model, &model.shifted(&model.registry.nominal()), &[]).is_compliant() && model.fuzzy.is_none() {
        return Err(nothing_elastic(""));
    }
    let is_loaded = work.carried != [0.0; 6] || work.wrenches.iter().any(|wrench| *wrench != [0.0; 6]);
    if !is_loaded && !weight {
        return Err(Error::input(
            "nothing loads the robot",
            "give columns fx .. mz, --wrench or --process; or --weight, to count own weight",
        ));
    }
    Ok(())
}

fn refused(error: StiffestError) -> Error {
    match error {
        StiffestError::Assembly(error) => AssemblyError::into(error),
        error => Error::Impossible {
            message: error.to_string(),
            remedy: "widen --move, let go of a direction with --hold, or shorten the path",
        },
    }
}
