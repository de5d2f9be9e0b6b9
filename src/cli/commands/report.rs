//! `report`: a campaign in one self-contained HTML file.

use std::path::{Path, PathBuf};
use std::time::Instant;

use nalgebra::Matrix3;

use super::identify::left_to_fit;
use crate::Error;
use crate::cli::args::{Arguments, Format, Report};
use crate::cli::{Output, Session};
use crate::description::campaign::Campaign;
use crate::diagnosis::{self, diagnose};
use crate::estimation::{CalibrationError, Settings, calibrate, split};
use crate::files::writable;
use crate::kinematics::{Geometry, Placements};
use crate::parameter::Group;
use crate::render::html::{Report as Found, Shot, write};
use crate::review::{compliance, readings, slice, typical, yielding};
use crate::scene::{Scene, draw};

/// Most configurations of a campaign that are drawn.
const SHOTS: usize = 24;
/// Share of the configurations set aside where the campaign does not say, as `identify` does.
const CHECK: f64 = 0.25;

pub fn run(command: &Report, session: &Session) -> Result<Output, Error> {
    let seed = session.seed();
    let page = page(session.arguments, "report.html", command.json.as_deref())?;
    let loaded = session.reader.campaign(&command.campaign, command.robot.as_deref())?;
    let (model, campaign) = (&loaded.robot.model, &loaded.campaign);
    let bar = session.terminal.bar(None, "{spinner} {msg}");
    let doing = |what: &str| {
        bar.set_message(what.to_string());
        bar.tick();
    };
    doing("calibrating");
    let aside = split(campaign, CHECK, seed);
    left_to_fit(campaign, &aside)?;
    let started = Instant::now();
    let calibration = match calibrate(model, campaign, &aside, &Settings::default(), &mut |_| bar.tick()) {
        Ok(found) => Ok((found, started.elapsed().as_secs_f64())),
        Err(why @ (CalibrationError::NothingFree | CalibrationError::NothingElastic)) => Err(why.to_string()),
        Err(other) => return Err(Error::from(other)),
    };
    let started = Instant::now();
    let stated: Vec<bool> = campaign.readings.iter().map(|reading| reading.check == Some(true)).collect();
    let settings = diagnosis::Settings::new(campaign, seed);
    let diagnosis = diagnose(model, campaign, &stated, &settings, &mut |what| doing(what))?;
    let seconds = started.elapsed().as_secs_f64();
    doing("drawing");
    let fitted = calibration.as_ref().ok().map(|(found, _)| found);
    let stages = readings(model, campaign, fitted, &diagnosis)?;
    // Lengths as described: what readings hardly tell can drive calibrated ones far off. Stiffness as calibrated.
    let calibrated = fitted.map_or(&diagnosis.calibrated, |found| &found.values);
    let values: Vec<f64> = model
        .registry
        .all()
        .iter()
        .zip(calibrated)
        .map(|(parameter, value)| if parameter.group == Group::Elastic { *value } else { parameter.nominal })
        .collect();
    let geometry = Geometry::new(model, &values)?;
    let first = typical(model, campaign);
    let mut placements = Placements::default();
    geometry.place(campaign.configuration(first), &mut placements)?;
    let scene = draw(&loaded.robot.robot, &geometry, &placements);
    let next = diagnosis
        .next_poses
        .iter()
        .enumerate()
        .filter_map(|(k, pose)| {
            let separates = pose.separates.join(" / ");
            shot(&scene, &geometry, &pose.q, format!("{}: {separates}", k + 1), Vec::new())
        })
        .collect();
    let converged = calibration.as_ref().map_or(true, |(found, _)| found.converged());
    let mut given = command.campaign.clone();
    given += &command.robot.as_ref().map_or(String::new(), |robot| format!(" --robot {robot}"));
    given += &if seed == 1 { String::new() } else { format!(" --seed {seed}") };
    let robot = command.robot.clone().or(loaded.raw.robot.clone()).unwrap_or_default();
    let written = write(&Found {
        given,
        robot,
        model,
        campaign,
        aside: &aside,
        shots: shots(&scene, &geometry, campaign, first),
        next,
        slice: slice(&geometry, campaign.configuration(first)),
        yielding: yielding(&geometry, campaign),
        scene: &scene,
        readings: stages,
        calibration,
        diagnosis,
        seconds,
    });
    bar.finish_and_clear();
    let mut output = Output::new(format!("{}\n\n{}\n", campaign.name, written.answer), written.json);
    output.diagnostics = loaded.diagnostics;
    output.failed = !converged;
    if let Some(path) = &command.json {
        let text = serde_json::to_string_pretty(&output.json)? + "\n";
        output.files.push((path.clone(), text));
        output.text += &format!("\nits data: {}\n", path.display());
    }
    if let Some(path) = page {
        output.text += &format!("\nreport: {}\n", path.display());
        output.files.push((path, written.html));
        output.written = true;
    }
    Ok(output)
}

/// Where the page goes: `--output`, or the usual name; none where JSON is asked for. No two files may be one.
pub fn page(arguments: &Arguments, usual: &str, other: Option<&Path>) -> Result<Option<PathBuf>, Error> {
    let refused = |diagnostic| Error::from(vec![diagnostic]);
    let path = match arguments.format {
        Format::Json => None,
        Format::Text => Some(arguments.output.clone().unwrap_or_else(|| PathBuf::from(usual))),
    };
    path.as_deref().map_or(Ok(()), writable).map_err(refused)?;
    if let Some(other) = other {
        writable(other).map_err(refused)?;
        if path.as_deref().or(arguments.output.as_deref()) == Some(other) {
            return Err(Error::input(
                format!("two results would go to `{}`", other.display()),
                "give another name to one of them",
            ));
        }
    }
    Ok(path)
}

/// The robot at a configuration; `None` where it cannot be assembled.
pub fn shot(scene: &Scene, geometry: &Geometry, q: &[f64], name: String, rows: Vec<usize>) -> Option<Shot> {
    let mut placements = Placements::default();
    geometry.place(q, &mut placements).ok()?;
    let points = scene.place(geometry, &placements);
    let compliance = compliance(geometry, q, &placements).ok().flatten();
    let compliance = compliance.map(|c| -> Matrix3<f64> { c.fixed_view::<3, 3>(0, 0).into_owned() });
    Some(Shot { name, points, moved: Vec::new(), compliance, rows })
}

/// The typical configuration and others spread over the campaign.
fn shots(scene: &Scene, geometry: &Geometry, campaign: &Campaign, first: usize) -> Vec<Shot> {
    let of_pose = |pose: usize| campaign.readings.iter().filter(move |reading| reading.pose == pose);
    let mut poses: Vec<usize> = campaign.readings.iter().map(|reading| reading.pose).collect();
    poses.sort_unstable();
    poses.dedup();
    let typical = campaign.readings[first].pose;
    let step = poses.len().div_ceil(SHOTS).max(1);
    let others = poses.iter().copied().step_by(step).filter(|pose| *pose != typical);
    std::iter::once(typical)
        .chain(others)
        .filter_map(|pose| {
            let at = campaign.readings.iter().position(|reading| reading.pose == pose)?;
            let rows = of_pose(pose).map(|reading| reading.row).collect();
            shot(scene, geometry, campaign.configuration(at), campaign.poses[pose].clone(), rows)
        })
        .collect()
}
