//! `init`: a commented description and campaign to start from.

use std::path::{Path, PathBuf};

use rand::RngExt;
use rand::seq::SliceRandom;

use super::{schema, simulate};
use crate::Error;
use crate::cli::args::{Init, SchemaOf, StarterKind};
use crate::cli::output::Output;
use crate::cli::session::Session;
use crate::files::{LoadedRobot, settle};
use crate::kinematics::Geometry;
use crate::observation::POSITION;
use crate::simulation::{Plan, carry_out, draw_configurations, draw_errors, generator, unmeasured};

const SERIAL: &str = include_str!("init/serial.yaml");
const PARALLELOGRAM: &str = include_str!("init/parallelogram.yaml");
const FROM_URDF: &str = include_str!("init/urdf.yaml");
const CAMPAIGN: &str = include_str!("init/campaign.yaml");

/// Configurations of the example: enough for every starter's parameters.
const POSES: usize = 60;
/// Noise of a coordinate, m, as `campaign.yaml` states it.
const SIGMA: f64 = 3e-5;

pub fn run(command: &Init, session: &Session) -> Result<Output, Error> {
    let seed = session.seed();
    let folder = Path::new(&command.name);
    usable(folder)?;
    let mut files: Vec<(PathBuf, String)> = Vec::new();
    let (robot, loaded) = match (&command.file, command.kind) {
        (None, Some(StarterKind::Urdf)) => {
            return Err(Error::input("--kind urdf: no file is given", "write `init NAME --kind urdf FILE`"));
        }
        (Some(file), Some(StarterKind::Serial | StarterKind::Parallelogram)) => {
            let message = format!("`{}`: only --kind urdf starts from a file", file.display());
            return Err(Error::input(message, "leave the file out, or give --kind urdf"));
        }
        (Some(path), _) => {
            let (description, copied, loaded) = from_urdf(session, path)?;
            files.push((folder.join(&copied.0), copied.1));
            (description, loaded)
        }
        (None, Some(StarterKind::Parallelogram)) => plain(session, PARALLELOGRAM)?,
        (None, None | Some(StarterKind::Serial)) => plain(session, SERIAL)?,
    };
    let (readings, measurements) = example(&loaded, seed)?;
    let joints: Vec<&str> = loaded.model.variables.iter().map(|variable| variable.name.as_str()).collect();
    let campaign = CAMPAIGN
        .replace("@FOLDER@", &command.name)
        .replace("@SEED@", &seed.to_string())
        .replace("@JOINTS@", &joints.join(", "));
    files.push((folder.join("robot.yaml"), robot));
    files.push((folder.join("campaign.yaml"), campaign));
    files.push((folder.join("measurements.csv"), measurements));
    for of in [SchemaOf::Robot, SchemaOf::Campaign] {
        files.push((folder.join(schema::file_name(of)), schema::text(of)?));
    }
    let name = &command.name;
    let text = format!(
        "{name}/robot.yaml        description: put your robot's numbers in\n\
         {name}/campaign.yaml     campaign, with {readings} made-up readings in measurements.csv\n\
         {name}/*.schema.json     for completion and hover text in editors with a YAML language server\n\n\
         next: elastogeo check {name}/robot.yaml\n      \
               elastogeo identify {name} --save {name}/calibrated.yaml\n      \
               elastogeo report {name}\n"
    );
    let wrote: Vec<String> = files.iter().map(|(path, _)| path.display().to_string()).collect();
    let mut output = Output::new(text, &serde_json::json!({"wrote": wrote, "readings": readings}))?;
    output.diagnostics = loaded.diagnostics;
    std::fs::create_dir_all(folder)
        .map_err(|error| Error::input(format!("`{name}` cannot be made: {error}"), "give another name"))?;
    output.files = files;
    Ok(output)
}

/// Refuses a name that is no plain folder's, and a folder in which something stands already.
fn usable(folder: &Path) -> Result<(), Error> {
    let shown = folder.display();
    let plain = folder.file_name().and_then(|name| name.to_str()).is_some_and(|name| {
        !name.starts_with(['-', '.']) && name.chars().all(|c| c.is_alphanumeric() || "-_.".contains(c))
    });
    if !plain {
        return Err(Error::input(
            format!("`{shown}` is no name for a folder of a robot"),
            "use letters, digits, `-`, `_` and `.`, as in `my-robot`",
        ));
    }
    if folder.exists() {
        settle(folder)?;
        // What a killed one has left on its way is nobody's.
        let is_ours = |name: &str| name.starts_with(".elastogeo-");
        let empty = std::fs::read_dir(folder)
            .is_ok_and(|entries| entries.flatten().all(|entry| entry.file_name().to_str().is_some_and(is_ours)));
        if !empty {
            let what = if folder.is_dir() { "is not empty" } else { "is a file" };
            return Err(Error::input(format!("`{shown}` {what}; nothing is overwritten"), "give another name"));
        }
        return Ok(());
    }
    match folder.parent() {
        Some(parent) if !parent.as_os_str().is_empty() && !parent.is_dir() => Err(Error::input(
            format!("`{shown}` cannot be made: there is no folder `{}`", parent.display()),
            "make the folder, or give another",
        )),
        _ => Ok(()),
    }
}

fn plain(session: &Session, text: &str) -> Result<(String, LoadedRobot), Error> {
    Ok((text.into(), session.reader.robot_text(Path::new("robot.yaml"), text)?))
}

/// A description that starts from a URDF, the URDF's name and text, and both read together.
fn from_urdf(session: &Session, path: &Path) -> Result<(String, (String, String), LoadedRobot), Error> {
    let named = path.extension().and_then(|extension| extension.to_str());
    let Some(name) = path.file_name().and_then(|name| name.to_str()).filter(|_| matches!(named, Some("urdf" | "xml")))
    else {
        return Err(Error::input(format!("`{}` is no URDF by its name", path.display()), "give a .urdf file"));
    };
    let alone = session.reader.robot(&path.display().to_string())?;
    let Some((joint, _)) = alone.raw.frames.iter().find(|(_, frame)| frame.variable.is_some()) else {
        return Err(Error::input(
            format!("`{}` has no joint that moves: there is nothing to calibrate", path.display()),
            "give the URDF of an arm",
        ));
    };
    let text = FROM_URDF
        .replace("@URDF@", &quoted(name))
        .replace("@TOOL@", &quoted(&alone.model.frames[alone.model.tool.0].name))
        .replace("@FIRST@", &quoted(joint));
    // Read as it will stand: next to the URDF, which is copied with it.
    let loaded = session.reader.robot_text(&path.with_file_name("robot.yaml"), &text)?;
    Ok((text, (name.into(), session.reader.text(path)?), loaded))
}

/// The inside of a YAML text in double quotes.
fn quoted(text: &str) -> String {
    text.replace(char::is_control, " ").replace('\\', "\\\\").replace('"', "\\\"")
}

/// Readings of one drawn robot: how many, and their CSV (mm, deg).
fn example(loaded: &LoadedRobot, seed: u64) -> Result<(usize, String), Error> {
    let model = &loaded.model;
    let mut random = generator(seed);
    let mut values = draw_errors(model, 1.0, 0.0, &mut random);
    for (k, size) in [0.5, 0.5, 0.5, 0.3, 0.3, 0.3].into_iter().enumerate() {
        values[model.base + k] += size * (2.0 * random.random::<f64>() - 1.0);
    }
    let geometry = Geometry::new(model, &values)?;
    let plan = Plan {
        configurations: draw_configurations(&geometry, POSES, 0.8, &mut random)?,
        markers: vec![model.marker("ball")],
        repeats: 1,
        wrenches: Vec::new(),
        conditions: false,
        observes: POSITION,
        sigma: SIGMA,
        sigma_orientation: 0.0,
        estimate: [true, true],
    };
    let blank = unmeasured(model, &plan);
    let mut campaign = carry_out(model, &values, &plan, blank, &mut random)?;
    let mut order: Vec<usize> = (0..campaign.poses.len()).collect();
    order.shuffle(&mut random);
    order.truncate(POSES / 4);
    campaign.readings.iter_mut().for_each(|reading| reading.check = Some(order.contains(&reading.pose)));
    Ok((campaign.readings.len(), simulate::csv(loaded, &campaign)?))
}
