//! `blind`: sealed campaigns, and the score of the diagnosis on them.

use std::path::{Path, PathBuf};

use rand::RngExt;
use rayon::prelude::*;
use serde_json::json;

use super::convert::written;
use super::simulate::csv;
use crate::Error;
use crate::blind::{Answer, Design, Drawn, Examined, Kind, Signals, Truth, draw, examine, seal, without, workshop};
use crate::cli::args::{Blind, BlindMake, BlindScore, Place, Sigma};
use crate::cli::output::Output;
use crate::cli::session::Session;
use crate::description::campaign::Campaign;
use crate::description::campaign::raw::{Measurements, RawCampaign, RawEstimate, RawInstrument, RawKinds, RawSigma};
use crate::description::raw::RawMarker;
use crate::description::units::{Angle, Force, Length, Torque, Units};
use crate::description::yaml;
use crate::files::{LoadedCampaign, LoadedRobot, bundled_robots, settle};
use crate::model::Model;
use crate::render::blind::score_text;
use crate::results::BlindScore as Scored;
use crate::simulation::generator;

pub fn run(command: &Blind, session: &Session) -> Result<Output, Error> {
    match command {
        Blind::Make(command) => make(command, session),
        Blind::Score(command) => judge(command, session),
    }
}

fn make(command: &BlindMake, session: &Session) -> Result<Output, Error> {
    let seed = session.seed();
    if !(1..=10_000).contains(&command.count) {
        return Err(Error::input(format!("--count {}", command.count), "give 1 to 10000"));
    }
    let kinds = kinds(command)?;
    let plans = plans(command, session)?;
    let drawn: Vec<Result<Drawn, Error>> = (0..command.count)
        .into_par_iter()
        .map(|k| {
            // Every campaign has its own stream, so that it does not depend on how many are drawn.
            let mut random = generator(seed.wrapping_mul(1_000_003).wrapping_add(k as u64));
            let (kind, name) = (kinds[k % kinds.len()], format!("sealed-{:03}", k + 1));
            let design = plans[k / kinds.len() % plans.len()].design();
            let is_stated = match command.sigma {
                _ if command.at == Place::Laboratory => true,
                Sigma::Stated => true,
                Sigma::Unstated => false,
                Sigma::Mixed => random.random(),
            };
            let drawn = match command.at {
                Place::Laboratory => draw(&design, &name, kind, &mut random),
                Place::Workshop => workshop::draw(&design, &name, kind, is_stated, &mut random),
            };
            drawn.map_err(|error| Error::from(error).at(name))
        })
        .collect();
    let mut files: Vec<(PathBuf, String)> = Vec::new();
    for Robot { file, text, .. } in plans.iter().filter_map(|plan| plan.written.as_ref()) {
        if files.iter().all(|(known, _)| known != file) {
            files.push((file.clone(), text.clone()));
        }
    }
    for (k, drawn) in drawn.into_iter().enumerate() {
        let drawn = drawn?;
        let plan = &plans[k / kinds.len() % plans.len()];
        let name = drawn.truth.name.clone();
        let folder = command.into.join(&name);
        make_folder(&folder)?;
        make_folder(&command.into.join("truth"))?;
        let truth = serde_json::to_string_pretty(&drawn.truth)? + "\n";
        let hash = seal(&truth);
        files.push((command.into.join("truth").join(format!("{name}.json")), truth));
        for (campaign, yaml_name, csv_name) in
            [(&drawn.campaign, "campaign.yaml", "measurements.csv"), (&drawn.fresh, "fresh.yaml", "fresh.csv")]
        {
            let raw = file_of(campaign, plan, &hash, drawn.truth.noise, csv_name);
            files.push((folder.join(csv_name), csv(&plan.robot, campaign)?));
            files.push((folder.join(yaml_name), yaml::write(&raw)?));
        }
    }
    let text = format!("{} sealed campaigns: {}\n", command.count, command.into.display());
    let mut output = Output::new(text, &json!({"campaigns": command.count, "seed": seed}))?;
    output.files = files;
    Ok(output)
}

/// The file of a sealed campaign; `hash` seals its truth, `noise` is the instrument's (m).
fn file_of(campaign: &Campaign, plan: &Plan, hash: &str, noise: f64, readings: &str) -> RawCampaign {
    let sigma = RawSigma::All((noise * 1e6).round() * 1e-3);
    RawCampaign {
        campaign: Some(campaign.name.clone()),
        source: Some(format!("sealed; SHA-256 of the truth: {hash}")),
        robot: Some(plan.reference()),
        units: units(&plan.robot),
        observes: Some(RawKinds::one(campaign.observes)),
        instrument: campaign.sigma.map(|_| RawInstrument {
            sigma: Some(sigma),
            ppm: None,
            torque: None,
            orientation: None,
        }),
        estimate: RawEstimate::of([campaign.estimate_base, campaign.estimate_tool]),
        calibrate: Some(campaign.calibrate.clone()),
        without: plan.without.clone(),
        measurements: Some(Measurements::file(readings)),
        ..RawCampaign::default()
    }
}

fn make_folder(folder: &Path) -> Result<(), Error> {
    let refused =
        |error| Error::input(format!("`{}` cannot be made: {error}", folder.display()), "give another folder");
    std::fs::create_dir_all(folder).map_err(refused)
}

/// What campaigns hide, in turns.
fn kinds(command: &BlindMake) -> Result<Vec<Kind>, Error> {
    let asked = match (&command.kinds[..], command.at) {
        ([], Place::Laboratory) => &[Kind::Single, Kind::Pair, Kind::Triple, Kind::Null, Kind::Unknown][..],
        ([], Place::Workshop) => &[Kind::Single, Kind::Unknown, Kind::Pair, Kind::Null, Kind::Mixture, Kind::Trap],
        (asked, _) => asked,
    };
    if command.at == Place::Laboratory && asked.contains(&Kind::Trap) {
        return Err(Error::input("--kinds trap: a laboratory has none", "give --at workshop"));
    }
    Ok(asked.to_vec())
}

/// A description that is written next to the campaigns.
struct Robot {
    file: PathBuf,
    text: String,
    reference: String,
}

/// A robot as it is measured: what of its description is left out, and how.
struct Plan {
    name: String,
    robot: LoadedRobot,
    written: Option<Robot>,
    without: Vec<String>,
    deflection: bool,
    poses: usize,
}

impl Plan {
    fn design(&self) -> Design<'_> {
        let Self { robot, name, deflection, poses, .. } = self;
        Design { model: &robot.model, robot: name, is_deflection: *deflection, poses: *poses }
    }

    /// As campaigns name the robot.
    fn reference(&self) -> String {
        self.written.as_ref().map_or_else(|| self.name.clone(), |robot| robot.reference.clone())
    }

    fn new(name: &str, deflection: bool, poses: usize, command: &BlindMake, session: &Session) -> Result<Self, Error> {
        let loaded = session.reader.robot(name)?;
        let is_workshop = command.at == Place::Workshop;
        if deflection && is_workshop && loaded.model.elastic_slots().is_empty() {
            return Err(Error::input(format!("--plan `{name}`: nothing is compliant"), "measure its positions"));
        }
        if loaded.model.markers.is_empty() && !is_workshop {
            return Err(Error::input(format!("--plan `{name}`: the robot has no markers"), "name another robot"));
        }
        let is_bundled = bundled_robots().iter().any(|known| known == name);
        if is_bundled && !loaded.model.markers.is_empty() {
            let without: Vec<String> = loaded.raw.springs.keys().cloned().collect();
            let left: Vec<&str> = without.iter().map(String::as_str).collect();
            let robot = session.reader.robot_leaving_out(name, &left)?;
            return Ok(Self { name: name.into(), robot, written: None, without, deflection, poses });
        }
        // What is not bundled, or gets markers, is written where the campaigns find it.
        let short = Path::new(name).file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let (folder, mut raw) = (command.into.join("robots"), loaded.raw);
        make_folder(&folder)?;
        raw.springs.clear();
        if raw.markers.is_empty() {
            let unit = raw.units.length.factor();
            for (k, at) in MARKERS.iter().enumerate() {
                let at = Some(at.map(|x| x / unit));
                raw.markers.insert(format!("m{}", k + 1), RawMarker { at, ..RawMarker::default() });
            }
        }
        let file = folder.join(format!("{short}.yaml"));
        let (text, _) = written(&raw, &file)?;
        let robot = session.reader.robot_text(&file, &text)?;
        let reference = format!("../robots/{short}.yaml");
        let written = Some(Robot { file, text, reference });
        Ok(Self { name: short, robot, written, without: Vec::new(), deflection, poses })
    }
}

/// Markers of a robot that has none, on the tool's frame, m.
const MARKERS: [[f64; 3]; 3] = [[0.09, 0.0, 0.05], [-0.05, 0.08, 0.04], [-0.04, -0.07, 0.09]];
/// Readings of a deflection campaign's markers, about: the fewer markers, the more configurations.
const MARKED: usize = 60;

fn plans(command: &BlindMake, session: &Session) -> Result<Vec<Plan>, Error> {
    if !command.plans.is_empty() {
        return command.plans.iter().map(|text| asked_plan(text, command, session)).collect();
    }
    let mut plans = Vec::new();
    for name in bundled_robots() {
        let robot = session.reader.robot(&name)?;
        let markers = robot.model.markers.len();
        let is_workshop = command.at == Place::Workshop;
        let gives = !robot.model.elastic_slots().is_empty() && markers > 0;
        // Base and markers are unknown in positions; a single marker does not tell them apart.
        if markers >= 3 && gives || markers == 0 && is_workshop {
            plans.push(Plan::new(&name, false, 45, command, session)?);
        }
        if gives {
            plans.push(Plan::new(&name, true, MARKED / markers, command, session)?);
        }
    }
    Ok(plans)
}

fn asked_plan(text: &str, command: &BlindMake, session: &Session) -> Result<Plan, Error> {
    let refused = || {
        Error::input(format!("--plan `{text}`"), "write ROBOT:position:45 or ROBOT:deflection:20, of 10 to 1000 poses")
    };
    let mut parts = text.rsplitn(3, ':');
    let (Some(poses), Some(observes), Some(name)) = (parts.next(), parts.next(), parts.next()) else {
        return Err(refused());
    };
    let poses = poses.parse::<usize>().ok().filter(|poses| (10..=1000).contains(poses)).ok_or_else(refused)?;
    match observes {
        "position" => Plan::new(name, false, poses, command, session),
        "deflection" => Plan::new(name, true, poses, command, session),
        _ => Err(refused()),
    }
}

fn units(robot: &LoadedRobot) -> Units {
    Units {
        length: Length::Millimetre,
        angle: Angle::Degree,
        force: Force::Newton,
        torque: Torque::NewtonMetre,
        ..robot.raw.units
    }
}

fn judge(command: &BlindScore, session: &Session) -> Result<Output, Error> {
    settle(&command.folder)?;
    let entries = std::fs::read_dir(&command.folder).map_err(|error| unreadable(&command.folder, &error))?;
    let mut folders: Vec<_> =
        entries.flatten().map(|entry| entry.path()).filter(|path| path.join("campaign.yaml").is_file()).collect();
    folders.sort();
    if folders.is_empty() {
        return Err(unreadable(&command.folder, &"it holds no campaigns"));
    }
    let sealed: Vec<Result<_, Error>> =
        folders.par_iter().map(|folder| Sealed::new(folder, session)?.answered(session)).collect();
    // Only now are the truths opened.
    let opened: Vec<Result<_, Error>> =
        sealed.into_par_iter().map(|sealed| sealed.and_then(|one| one.opened(command, session))).collect();
    let (mut all, mut left_out) = (Vec::new(), Vec::new());
    for opened in opened {
        let (one, without) = opened?;
        all.push(one);
        left_out.extend(without);
    }
    let scored = Scored::new(all, command.leave_out.then_some(left_out));
    Output::new(score_text(&scored, session.terminal.screen), &scored)
}

fn unreadable(path: &Path, error: &dyn std::fmt::Display) -> Error {
    Error::input(format!("`{}` cannot be read: {error}", path.display()), "give a folder that `blind make` wrote")
}

/// A sealed campaign with what is needed to score it.
struct Sealed {
    folder: PathBuf,
    loaded: LoadedCampaign,
    fresh: Campaign,
}

impl Sealed {
    fn new(folder: &Path, session: &Session) -> Result<Self, Error> {
        let read = |name: &str| session.reader.campaign(&folder.join(name).display().to_string(), None);
        let (loaded, fresh) = (read("campaign.yaml")?, read("fresh.yaml")?.campaign);
        Ok(Self { folder: folder.into(), loaded, fresh })
    }

    fn examined(&self, model: &Model, session: &Session) -> Result<Answer, Error> {
        let answer = examine(model, &self.loaded.campaign, &self.fresh, session.seed());
        answer.map_err(|error| self.impossible(&error))
    }

    fn impossible(&self, error: &dyn std::fmt::Display) -> Error {
        Error::Impossible {
            message: format!("`{}`: {error}", self.folder.display()),
            remedy: "make the folder again (`blind make`)",
        }
    }

    fn answered(self, session: &Session) -> Result<Answered, Error> {
        Ok(Answered { answer: self.examined(&self.loaded.robot.model, session)?, sealed: self })
    }

    /// Compares what is named falsely with the signals of the true causes.
    fn tied(&self, one: &mut Examined) -> Result<(), Error> {
        if !one.has_false_name() {
            return Ok(());
        }
        let Sealed { loaded, .. } = self;
        let signals = Signals::new(&loaded.robot.model, &loaded.campaign, &one.truth);
        one.compare(&signals.map_err(|error| self.impossible(&error))?).map_err(|error| self.impossible(&error))
    }
}

/// A sealed campaign that was diagnosed.
struct Answered {
    sealed: Sealed,
    answer: Answer,
}

impl Answered {
    /// Scores the answer, and that without the true effect of a single one where that is asked for.
    fn opened(self, command: &BlindScore, session: &Session) -> Result<(Examined, Option<Examined>), Error> {
        let Self { sealed, answer } = self;
        let name = sealed.folder.file_name().unwrap_or_default();
        let path = command.folder.join("truth").join(Path::new(name).with_extension("json"));
        let text = std::fs::read_to_string(&path).map_err(|error| unreadable(&path, &error))?;
        if !sealed.loaded.raw.source.as_ref().is_some_and(|source| source.ends_with(&seal(&text))) {
            return Err(Error::input(
                format!("`{}` is not the truth that was sealed: its SHA-256 differs", path.display()),
                "make the campaigns again",
            ));
        }
        let truth: Truth = serde_json::from_str(&text).map_err(|error| unreadable(&path, &error))?;
        let mut one = answer.open(truth.clone());
        sealed.tied(&mut one)?;
        let left_out = match &truth.causes[..] {
            [cause] if command.leave_out && truth.kind == Kind::Single => {
                without(&sealed.loaded.robot.model, &sealed.loaded.campaign, &cause.effect)
            }
            _ => None,
        };
        let Some(model) = left_out else { return Ok((one, None)) };
        let mut left_out = sealed.examined(&model, session)?.open_left_out(truth);
        sealed.tied(&mut left_out)?;
        Ok((one, Some(left_out)))
    }
}
