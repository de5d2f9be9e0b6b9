//! `compensate`: commands under which the real robot passes where it should.

use nalgebra::Rotation3;

use crate::Error;
use crate::cli::args::{Compensate, FrameName};
use crate::cli::output::Output;
use crate::cli::session::Session;
use crate::cli::values::{hold, joints, units_with, wrench};
use crate::compensation::{Asked, Controller, Desired, Hold, Refusal, Settings, compensate, desire, six};
use crate::description::campaign::Reading;
use crate::description::path::Path;
use crate::description::units::Units;
use crate::diagnostic::Diagnostic;
use crate::elastics::Elastics;
use crate::files::{LoadedRobot, writable_table};
use crate::fuzzy;
use crate::kinematics::{Geometry, Placements, Transform};
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
    let held = if command.hold.is_empty() { None } else { Some(hold(&command.hold)?) };
    let loaded = session.reader.robot(&command.robot)?;
    let model = &loaded.model;
    let units = units_with(&loaded.raw.units, command.units.as_deref())?;
    let path = loaded_path(command, session, &loaded, units)?;
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
    let settings = settings(command, model, held);
    let (desired, shown) = controller.desired(&loaded, &path, command.from.as_deref(), command.frame, settings.hold)?;
    let values = model.registry.nominal();
    diagnostics.extend(compliance_doubts(model, &path, &desired, process.is_some())?);
    let outcome = compensate(model, &values, &path.campaign, &desired, process.as_ref(), &settings)?;
    let corrected = outcome.points.iter().zip(&path.campaign.readings);
    let corrected = corrected.filter_map(|(point, reading)| Some((point.as_ref().ok()?, reading)));
    let states = corrected.map(|(point, reading)| (point.corrected.joints.as_slice(), &reading.wrench));
    diagnostics.extend(loaded.outside(states));
    let nominal: Vec<Option<Vec<f64>>> = desired.iter().map(|d| d.as_ref().ok().map(|d| d.nominal.clone())).collect();
    let poses: Vec<Option<[f64; 6]>> = outcome
        .points
        .iter()
        .zip(&path.campaign.readings)
        .map(|(point, reading)| {
            let point = point.as_ref().ok()?;
            shown.pose(&point.corrected.joints, reading.marker)
        })
        .collect();
    let names: Vec<String> =
        path.campaign.readings.iter().map(|reading| path.campaign.poses[reading.pose].clone()).collect();
    let mut found = Compensation::new(model, &names, &nominal, &poses, &outcome, settings.hold);
    if let Some(uncertainty) = loaded.uncertainty() {
        let mut reached = path.campaign.clone();
        for (point, q) in outcome.points.iter().zip(reached.joints.chunks_mut(model.variables.len().max(1))) {
            if let Ok(point) = point {
                q.copy_from_slice(&point.corrected.joints);
            }
        }
        found = found.with_uncertainties(&uncertainty.positions(model, &reached)?);
    }
    found.process = process.map(|process| process.name);
    let all_met = found.refused.is_empty();
    let mut text = render::compensation(&found, session.terminal.screen);
    let mut tables = Vec::new();
    if let Some(file) = &command.table {
        let shown = file.display();
        if all_met || command.keep_going {
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
    Ok(output)
}

/// The path, at the marker and under the wrench that the command names.
fn loaded_path(command: &Compensate, session: &Session, loaded: &LoadedRobot, units: Units) -> Result<Path, Error> {
    let mut path = session.reader.path(&command.path, loaded, units)?;
    at_marker(command.at.as_deref(), loaded, &mut path)?;
    if let Some(text) = &command.wrench {
        if path.campaign.readings.iter().any(Reading::is_loaded) {
            return Err(Error::input("--wrench, and the path has wrenches of its own", "give one of them"));
        }
        let constant = wrench(&loaded.raw.units, text)?;
        path.campaign.readings.iter_mut().for_each(|reading| reading.wrench = constant);
    }
    Ok(path)
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
pub(super) fn at_marker(at: Option<&str>, loaded: &LoadedRobot, path: &mut Path) -> Result<(), Error> {
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

/// The description that the controller works with.
pub(super) struct ControllerFile {
    loaded: Option<LoadedRobot>,
    markers: Vec<usize>,
    diagnostics: Vec<Diagnostic>,
}

/// The controller's geometry, for poses of commands.
pub(super) struct Shown<'a> {
    geometry: Geometry<'a>,
    markers: &'a [usize],
}

impl Shown<'_> {
    fn pose(&self, q: &[f64], marker: Option<usize>) -> Option<[f64; 6]> {
        let controller = Controller { geometry: &self.geometry, markers: self.markers };
        controller.pose(q, marker, &mut Placements::default()).ok().map(|pose| six(&pose))
    }
}

impl ControllerFile {
    pub fn new(name: Option<&str>, loaded: &LoadedRobot, path: &Path, session: &Session) -> Result<Self, Error> {
        let own: Vec<usize> = (0..loaded.model.markers.len()).collect();
        let Some(name) = name else {
            let mut diagnostics = Vec::new();
            if path.joints && !path.position {
                let text = "the path gives joints, and the description itself says where they lead without load: \
                            what load and effects do is corrected, geometry errors are not";
                diagnostics.push(
                    Diagnostic::warning(text).remedy("give --nominal, the description the controller works with"),
                );
            }
            return Ok(Self { loaded: None, markers: own, diagnostics });
        };
        let nominal = session.reader.robot(name)?;
        let of = |l: &LoadedRobot| -> Vec<String> { l.model.variables.iter().map(|v| v.name.clone()).collect() };
        if of(&nominal) != of(loaded) {
            return Err(Error::input(
                format!(
                    "--nominal `{name}` has the variables {}, and the robot {}",
                    of(&nominal).join(", "),
                    of(loaded).join(", ")
                ),
                "give the uncalibrated description of the same robot",
            ));
        }
        let mut markers = Vec::new();
        for marker in &loaded.model.markers {
            let found = nominal.model.marker(&marker.name);
            let used = path.campaign.readings.iter().any(|r| r.marker == Some(markers.len()));
            match found {
                Some(found) => markers.push(found),
                None if used => {
                    return Err(Error::input(
                        format!("--nominal `{name}` has no marker `{}`", marker.name),
                        "give the uncalibrated description of the same robot",
                    ));
                }
                None => markers.push(0),
            }
        }
        let diagnostics = nominal.diagnostics.clone();
        Ok(Self { loaded: Some(nominal), markers, diagnostics })
    }

    /// Targets and nominal commands of a path.
    pub fn desired<'a>(
        &'a self,
        loaded: &'a LoadedRobot,
        path: &Path,
        from: Option<&str>,
        frame: FrameName,
        hold: Hold,
    ) -> Result<(Vec<Result<Desired, Refusal>>, Shown<'a>), Error> {
        let model = self.loaded.as_ref().map_or(&loaded.model, |nominal| &nominal.model);
        let geometry = Geometry::nominal(model)?;
        let Path { joints: own, position, orientation, .. } = *path;
        let asked = Asked { joints: own, position, orientation, hold };
        let from = from.map(|text| joints(&loaded.model, &loaded.raw.units, text)).transpose()?;
        let controller = Controller { geometry: &geometry, markers: &self.markers };
        let axes: Option<Rotation3<f64>> = match (&from, asked.joints || asked.orientation) {
            (Some(q), false) if model.variables.len() >= 6 || hold.turns() => {
                let pose = controller.pose(q, None, &mut Placements::default())?;
                Some(pose.rotation)
            }
            (None, false) if model.variables.len() >= 6 => {
                return Err(Error::input(
                    "the path gives positions, and nothing says how the tool should stand",
                    "add columns rx, ry, rz or the joints, or give `compensate --from`, a configuration whose orientation is kept",
                ));
            }
            _ => None,
        };
        let measured = Geometry::nominal(&loaded.model)?;
        let frame = match frame {
            FrameName::Base => Transform::identity(),
            FrameName::Measurement => measured.base().inverse(),
        };
        let desired = desire(&controller, &path.campaign, asked, &frame, axes, from.as_deref());
        Ok((desired, Shown { geometry, markers: &self.markers }))
    }
}
