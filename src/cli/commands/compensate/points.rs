//! Points of a path: what the command puts into them, and what was found for them.

use super::controller::Shown;
use crate::Error;
use crate::cli::args::Compensate;
use crate::cli::values::wrench;
use crate::compensation::{Desired, Hold, Outcome, Point, Refusal};
use crate::description::campaign::Reading;
use crate::description::path::Path;
use crate::diagnostic::Diagnostic;
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
    Ok(found.with_uncertainties(&uncertainty.positions(model, &reached)?))
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
