//! Points of a path: what the command puts into them, and what was found for them.

use super::controller::Shown;
use crate::Error;
use crate::cli::args::Compensate;
use crate::cli::values::wrench;
use crate::compensation::{Desired, Hold, Outcome, Point, Refusal};
use crate::description::campaign::Reading;
use crate::description::path::Path;
use crate::description::units::Units;
use crate::diagnostic::{Code, Diagnostic};
use crate::files::LoadedRobot;
use crate::model::{Condition, Model};
use crate::results::Compensation;

/// The outcome as a result, with the controller's poses and the uncertainty of the points.
pub fn found(
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
    Ok(found.with_uncertainties(&uncertainty.positions(model, &model.registry.nominal(), &reached)?))
}

/// Puts the marker and the wrench that the command names into a path.
pub fn load(command: &Compensate, loaded: &LoadedRobot, path: &mut Path) -> Result<(), Error> {
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

/// Warnings of effects that depend on conditions which the path does not give.
pub fn condition_doubts(model: &Model, path: &Path) -> Vec<Diagnostic> {
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

/// Joints (least number of angles) of which all values lie within half a turn in rad, about their zero: no path stays there in degrees.
const ANGLES: usize = 3;
/// Limits reach at least so many times further than that.
const WIDER: f64 = 10.0;

/// A doubt about joints of a path that look like rad, and are read in a smaller unit.
pub fn unit_doubt(loaded: &LoadedRobot, path: &Path, units: &Units) -> Option<Diagnostic> {
    let factor = units.angle.factor();
    let angles: Vec<usize> =
        (0..loaded.model.variables.len()).filter(|&k| loaded.model.variables[k].is_angle).collect();
    if !path.joints || factor >= 1.0 || path.campaign.readings.len() < 2 || angles.len() < ANGLES {
        return None;
    }
    let half = std::f64::consts::PI * factor;
    let reaches = |[low, high]: [f64; 2]| high.max(-low) > WIDER * half;
    let are_wide = angles.iter().all(|&k| loaded.model.variables[k].limits.is_none_or(reaches));
    let configurations = || (0..path.campaign.readings.len()).map(|point| path.campaign.configuration(point));
    let is_small = |q: &[f64]| angles.iter().all(|&k| q.get(k).is_some_and(|value| value.abs() <= half));
    let moves = configurations().any(|q| angles.iter().any(|&k| q.get(k).is_some_and(|value| *value != 0.0)));
    (are_wide && moves && configurations().all(is_small)).then(|| {
        let unit = units.angle.symbol();
        let message = format!(
            "all joint angles of the path lie within 3.1416 {unit} of 0, and the robot's limits are far wider: are they in rad, and read in {unit}?"
        );
        Diagnostic::warning(message).code(Code::WrongUnits).remedy("say --units angle=rad, or convert the joint columns")
    })
}

/// A turn of the tool that is meant in rad is often a quarter or half turn, to so many digits.
const QUARTER: f64 = 1e-3;

/// A doubt about orientations of a path that look like rad, and are read in a smaller unit: none turns by more than half a turn in rad,
/// and one is a quarter or half turn.
pub fn orientation_doubt(path: &Path, units: &Units) -> Option<Diagnostic> {
    let factor = units.angle.factor();
    let turns: Vec<f64> = (path.campaign.readings.iter())
        .filter(|reading| reading.observes.angle_rows() == 3)
        .map(|reading| reading.measured[reading.observes.length_rows()..].iter().take(3).map(|r| r * r).sum::<f64>())
        .map(|square| square.sqrt() / factor)
        .collect();
    let half = std::f64::consts::PI;
    let is_turn = |turn: &f64| [0.5 * half, half].iter().any(|exact| (turn - exact).abs() < QUARTER);
    let is_meant = factor < 1.0 && turns.iter().all(|turn| *turn < half + QUARTER) && turns.iter().any(is_turn);
    is_meant.then(|| {
        let unit = units.angle.symbol();
        let message = format!(
            "no orientation of the path turns by more than 3.1416 {unit}, and one is a quarter or half turn in rad: are they in rad, and read in {unit}?"
        );
        Diagnostic::warning(message).code(Code::WrongUnits).remedy("say --units angle=rad, or convert the columns of the orientation")
    })
}

/// `--at` for a path that does not say which marker passes.
fn at_marker(at: Option<&str>, loaded: &LoadedRobot, path: &mut Path) -> Result<(), Error> {
    let Some(name) = at else { return Ok(()) };
    let Some(marker) = loaded.model.marker(name) else {
        let valid = loaded.model.markers.iter().map(|marker| marker.name.as_str());
        return Err(Error::unknown(format!("--at: no marker is called `{name}`"), name, valid));
    };
    if path.campaign.readings.iter().any(|reading| reading.marker.is_some()) {
        return Err(Error::input("--at, and the path has a column `marker`", "give one of them"));
    }
    path.campaign.readings.iter_mut().for_each(|reading| reading.marker = Some(marker));
    Ok(())
}
