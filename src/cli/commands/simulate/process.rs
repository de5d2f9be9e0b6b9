//! `simulate --process`: readings along a path, the arm in equilibrium with what pushes back.

use rand_chacha::ChaCha8Rng;

use super::campaign::{Made, delivered};
use crate::Error;
use crate::cli::args::{FrameName, Simulate};
use crate::cli::commands::compensate::ControllerFile;
use crate::cli::output::Output;
use crate::cli::session::Session;
use crate::compensation::{Balance, Desired, Hold, Refusal, Settings, predict_path};
use crate::description::campaign::Campaign;
use crate::description::limits::beyond;
use crate::files::{LoadedRobot, not_allowed};
use crate::observation::POSITION;
use crate::render::compensation::strip_left;
use crate::results::units::mm;
use crate::results::{PathPoint, StripAt, StripLeft};
use crate::simulation::{Plan, measure};

/// The robot and the command, as far as `simulate` has them.
pub struct Scene<'a> {
    pub command: &'a Simulate,
    pub loaded: &'a LoadedRobot,
    pub values: &'a [f64],
    pub markers: &'a [Option<usize>],
}

pub fn run(scene: &Scene, file: &str, session: &Session, random: &mut ChaCha8Rng) -> Result<Output, Error> {
    let Scene { command, loaded, values, markers } = *scene;
    let observes = command.observes.unwrap_or(POSITION);
    let marker = check(command, markers)?;
    let (process, mut diagnostics) = session.reader.process(file)?;
    let mut path = session.reader.commands(&command.poses, loaded, loaded.raw.units)?;
    if path.joints {
        let rows = (0..path.campaign.readings.len()).map(|row| path.campaign.configuration(row));
        let (model, units) = (&loaded.model, &loaded.raw.units);
        diagnostics.extend(not_allowed(model, units, "rows", rows.clone(), |_, _| None));
        diagnostics.extend(beyond(&model.variables, units, "rows", rows, |_, _| None));
    }
    if marker.is_some() {
        path.campaign.readings.iter_mut().for_each(|reading| reading.marker = marker);
    }
    let controller = ControllerFile::new(None, loaded, &path, session)?;
    let hold = Hold::of(loaded.model.variables.len());
    let desired = controller.geometry(loaded)?.desired(&path, None, FrameName::Base, hold)?;
    let (model, mut campaign) = (&loaded.model, path.campaign);
    let found =
        predict_path(model, values, &mut campaign, &desired, Some(&process), &Settings::new(model.variables.len()))?;
    let (rows, points) = balanced(&mut campaign, &found, &desired)?;
    campaign.name = format!("{}, {}, simulated", model.name, process.name);
    campaign.observes = observes;
    campaign.state_noise((command.noise > 0.0).then_some([command.noise * 1e-3; 3]), None);
    let sigma = [command.noise * 1e-3, command.orientation_noise.to_radians()];
    campaign.calibrate = vec!["geometry".into(), "joint-offset".into()];
    if model.effects.is_empty() && !command.conditions {
        campaign.conditions.approach.clear();
    }
    let campaign = measure(model, values, campaign, sigma, random)?;
    let plan = Plan {
        configurations: Vec::new(),
        markers: markers.to_vec(),
        repeats: 1,
        wrenches: Vec::new(),
        conditions: false,
        observes,
        sigma: sigma[0],
        sigma_orientation: sigma[1],
        estimate: [command.unknown_base, command.unknown_tool],
    };
    let made = Made { command, loaded, values, plan: &plan, seed: session.seed() };
    let left = StripLeft::new(points.iter().filter_map(|point| Some((point.name.as_str(), point.strip?))));
    let mut output = delivered(&made, campaign, Some(points), random)?;
    let header = ["index", "point", "missed x mm", "y", "z", "in all", "fx N", "fy", "fz"];
    let table = session.terminal.screen.table(&header, rows);
    let left = left.as_ref().map(strip_left).unwrap_or_default();
    output.text = format!("{} under `{}`, in equilibrium\n\n{table}{left}\n{}", model.name, process.name, output.text);
    diagnostics.append(&mut output.diagnostics);
    output.diagnostics = diagnostics;
    Ok(output)
}

/// Puts the joints and wrenches of equilibrium into the readings: rows of a table, and the points with what they miss.
fn balanced(
    campaign: &mut Campaign,
    found: &[Result<Balance, Refusal>],
    desired: &[Result<Desired, Refusal>],
) -> Result<(Vec<Vec<String>>, Vec<PathPoint>), Error> {
    let (mut rows, mut points) = (Vec::new(), Vec::new());
    for (index, (balance, desired)) in found.iter().zip(desired).enumerate() {
        let name = campaign.poses[campaign.readings[index].pose].clone();
        let refused = |why: &Refusal| Error::from(why.clone()).at(format!("point {index} ({name})"));
        let (desired, balance) = (desired.as_ref().map_err(refused)?, balance.as_ref().map_err(refused)?);
        let wrench = &balance.wrench;
        let missed = balance.seen.real.translation.vector - desired.target.translation.vector;
        let shown = |v: f64| format!("{:.4}", mm(v));
        let mut row = vec![index.to_string(), name.clone()];
        row.extend(missed.iter().map(|v| shown(*v)));
        row.push(shown(missed.norm()));
        row.extend(wrench[..3].iter().map(|f| format!("{f:.1}")));
        rows.push(row);
        let strip = balance.strip.map(StripAt::from);
        points.push(PathPoint { index, name, missed: [missed.x, missed.y, missed.z], wrench: *wrench, strip });
        let variables = campaign.variables;
        campaign.joints[index * variables..(index + 1) * variables].copy_from_slice(&desired.nominal);
        campaign.readings[index].wrench = *wrench;
    }
    Ok((rows, points))
}

/// The marker on which the process pushes; `None` for the tool centre point.
fn check(command: &Simulate, markers: &[Option<usize>]) -> Result<Option<usize>, Error> {
    let observes = command.observes.unwrap_or(POSITION);
    if observes.is_difference() || observes.target_column().is_some() {
        return Err(Error::input(
            "--process: what is read along a path are positions or poses",
            "give --observes position or pose",
        ));
    }
    let [marker] = markers else {
        return Err(Error::input(
            "--process: the process pushes on one point",
            "give one marker, or none for the tool",
        ));
    };
    if !command.wrench.is_empty() || command.repeats != 1 {
        return Err(Error::input(
            "--process with --wrench or --repeats",
            "wrenches in addition to the process's stand in the path's columns fx .. mz; each point is read once",
        ));
    }
    Ok(*marker)
}
