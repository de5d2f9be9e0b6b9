//! `compensate --vary`: how the deviations of the path depend on what robot and process declare.

use std::path::Path as FilePath;

use nalgebra::Vector3;

use super::controller::Shown;
use crate::Error;
use crate::cli::args::{Compensate, FrameName};
use crate::cli::output::Output;
use crate::cli::session::Session;
use crate::compensation::{Settings, pushed};
use crate::description::campaign::Reading;
use crate::description::path::Path;
use crate::description::process::RawProcess;
use crate::description::vary::Numbers;
use crate::diagnostic::{Diagnostic, Diagnostics};
use crate::files::LoadedRobot;
use crate::process::Process;
use crate::render::variation as render;
use crate::results::{PathDeviations, Variation, Varied};

/// The path as it stands, to be varied.
pub struct Vary<'a> {
    pub command: &'a Compensate,
    pub session: &'a Session<'a>,
    pub loaded: &'a LoadedRobot,
    pub path: &'a Path,
    pub process: Option<&'a (RawProcess, Process)>,
    pub shown: &'a Shown<'a>,
    pub from: Option<&'a [f64]>,
    pub settings: &'a Settings,
}

/// What is varied, and by what.
enum What<'t> {
    /// Numbers of the robot's description.
    Robot(&'t str),
    /// Numbers of the process.
    Process(&'t str),
    /// The place of path and process along an axis of the base.
    Place(usize),
}

/// Beginning of the names of numbers of the process.
const PROCESS: &str = "process.";
/// Names of the place of path and process.
const PLACES: [&str; 3] = ["place.x", "place.y", "place.z"];

/// Numbers that a factor can change.
struct Declared {
    robot: Option<Numbers>,
    process: Option<Numbers>,
}

/// The path with one value of what is varied.
struct Tried {
    factor: Option<f64>,
    /// m.
    moved: Option<f64>,
    places: Vec<String>,
    deviations: PathDeviations,
}

pub fn run(vary: &Vary) -> Result<Output, Error> {
    let Vary { command, loaded, path, process, .. } = vary;
    if process.is_none() && !path.campaign.readings.iter().any(Reading::is_loaded) {
        return Err(Error::input(
            "--vary, and nothing pushes on the tool",
            "give --process or --wrench, or columns fx .. mz of the path",
        ));
    }
    let numbers = Declared { robot: Numbers::of(&loaded.raw), process: process.and_then(|(raw, _)| Numbers::of(raw)) };
    let declared = vary.deviations(loaded, path, process.map(|(_, process)| process))?;
    let whole = |of: &PathDeviations| of.points.iter().all(Option::is_some);
    let mut varied = Vec::new();
    let mut diagnostics = Vec::new();
    for asked in &command.vary {
        let (what, values) = parsed(asked)?;
        for value in values {
            let refused = |found: Diagnostics| Error::from(found).at(format!("--vary {asked} at {value}"));
            let Tried { factor, moved, places, deviations } =
                vary.tried(&what, value, &numbers, &refused, &mut diagnostics)?;
            let change: f64 = (deviations.distance.rms / declared.distance.rms).ln();
            let elasticity = factor.map(|factor| change / factor.ln());
            let elasticity = elasticity.filter(|v| v.is_finite() && whole(&deviations) && whole(&declared));
            let what = asked.split('=').next().unwrap_or(asked).to_string();
            varied.push(Varied { what, factor, moved, places, deviations, elasticity });
        }
    }
    let found = Variation { unit: "m", declared, varied, robot: loaded.model.name.clone() };
    let mut output = Output::new(render::variation(&found, vary.session.terminal.screen), &found)?;
    diagnostics.extend(loaded.diagnostics.iter().cloned());
    output.diagnostics = diagnostics;
    Ok(output)
}

impl Vary<'_> {
    fn tried(
        &self,
        what: &What,
        value: f64,
        numbers: &Declared,
        refused: &dyn Fn(Diagnostics) -> Error,
        warnings: &mut Vec<Diagnostic>,
    ) -> Result<Tried, Error> {
        let Self { command, loaded, path, .. } = *self;
        let process = self.process.map(|(_, process)| process);
        match *what {
            What::Robot(pattern) => {
                let (text, places) = multiplied(numbers.robot.as_ref(), "", pattern, value)?;
                let file = FilePath::new(&command.robot);
                let file = if file.exists() { file.to_path_buf() } else { format!("{}.yaml", command.robot).into() };
                let other = self.session.reader.robot_text(&file, &text).map_err(refused)?;
                let deviations = self.deviations(&other, path, process)?;
                Ok(Tried { factor: Some(value), moved: None, places, deviations })
            }
            What::Process(pattern) => {
                let (text, places) = multiplied(numbers.process.as_ref(), PROCESS, pattern, value)?;
                let read = self.session.reader.process_text(command.process.as_deref().unwrap_or_default(), &text);
                let (_, other, more) = read.map_err(refused)?;
                warnings.extend(more);
                let deviations = self.deviations(loaded, path, Some(&other))?;
                Ok(Tried { factor: Some(value), moved: None, places, deviations })
            }
            What::Place(axis) => {
                if !path.position || command.frame != FrameName::Base {
                    return Err(Error::input(
                        "--vary place: the path does not say positions in the robot's base frame",
                        "give columns x, y, z, in the base frame",
                    ));
                }
                let by = Vector3::ith(axis, value * loaded.raw.units.length.factor());
                let mut moved = path.clone();
                for reading in &mut moved.campaign.readings {
                    reading.measured.iter_mut().zip(by.iter()).for_each(|(at, by)| *at += by);
                }
                let process = process.map(|process| process.moved(&by));
                let deviations = self.deviations(loaded, &moved, process.as_ref())?;
                Ok(Tried { factor: None, moved: Some(by[axis]), places: Vec::new(), deviations })
            }
        }
    }

    fn deviations(&self, robot: &LoadedRobot, path: &Path, process: Option<&Process>) -> Result<PathDeviations, Error> {
        let desired = self.shown.desired(path, self.from, self.command.frame, self.settings.hold)?;
        let values = robot.model.registry.nominal();
        let all = pushed(&robot.model, &values, &path.campaign, &desired, process, self.settings)?;
        Ok(PathDeviations::new(all.into_iter().map(|by| by.ok().map(Into::into)).collect()))
    }
}

/// `PARAMETER=FACTOR,..`
fn parsed(asked: &str) -> Result<(What<'_>, Vec<f64>), Error> {
    let refuse = || {
        let remedy =
            "give PARAMETER=FACTOR,.., as `sections.*.wall=0.5,2`, `process.strip.young=1.1`, or `place.x=-100,100`";
        Error::input(format!("--vary `{asked}`"), remedy)
    };
    let (name, values) = asked.split_once('=').ok_or_else(refuse)?;
    let what = match (PLACES.iter().position(|place| *place == name), name.strip_prefix(PROCESS)) {
        (Some(axis), _) => What::Place(axis),
        (None, Some(pattern)) => What::Process(pattern),
        (None, None) => What::Robot(name),
    };
    let sound = |value: &f64| value.is_finite() && (*value > 0.0 || matches!(what, What::Place(_)));
    let values: Option<Vec<f64>> = values.split(',').map(|value| value.trim().parse().ok().filter(sound)).collect();
    match values {
        Some(values) if !name.is_empty() && !values.is_empty() => Ok((what, values)),
        _ => Err(refuse()),
    }
}

/// The text of a file, whose numbers' names begin as said, with those multiplied that a pattern names, and where they stand.
fn multiplied(
    numbers: Option<&Numbers>,
    begins: &str,
    pattern: &str,
    factor: f64,
) -> Result<(String, Vec<String>), Error> {
    let found = numbers.and_then(|numbers| numbers.multiplied(pattern, factor));
    if let Some((text, places)) = found
        && !places.is_empty()
    {
        return Ok((text, places));
    }
    let places = numbers.map(Numbers::places).unwrap_or_default();
    let places: Vec<String> = places.into_iter().map(|place| format!("{begins}{place}")).collect();
    let name = format!("{begins}{pattern}");
    let message = format!("--vary: `{name}` names no number that a factor changes");
    Err(Error::unknown(message, &name, places.iter().map(String::as_str)))
}
